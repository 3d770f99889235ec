//! Values as SQLite has them.

use rusqlite::Row;
use rusqlite::types::ValueRef;

/// SQLite integers are signed; counts here stay far below 2^63.
pub fn to_sql(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// The inverse of [`to_sql`].
pub fn from_sql(count: i64) -> u64 {
    u64::try_from(count).unwrap_or(0)
}

/// A text, with replacement characters for what is not UTF-8: for lists, which one row that was
/// changed outside of this program does not take with it.
pub fn shown_text(row: &Row<'_>, column: &str) -> rusqlite::Result<String> {
    match row.get_ref(column)? {
        ValueRef::Text(bytes) => Ok(String::from_utf8_lossy(bytes).into_owned()),
        _ => row.get(column),
    }
}

/// A priority; one that is out of range is the nearest that is not.
pub fn nearest_i32(row: &Row<'_>, column: &str) -> rusqlite::Result<i32> {
    let priority: i64 = row.get(column)?;
    let (least, most) = (i64::from(i32::MIN), i64::from(i32::MAX));
    Ok(priority.clamp(least, most) as i32)
}
