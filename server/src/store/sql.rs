//! Counts as SQLite has them.

/// SQLite integers are signed; counts here stay far below 2^63.
pub fn to_sql(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// The inverse of [`to_sql`].
pub fn from_sql(count: i64) -> u64 {
    u64::try_from(count).unwrap_or(0)
}
