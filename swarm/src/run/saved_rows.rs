//! Rows of metrics as a snapshot has them: five metrics in the state, whose bytes and digest no
//! later metric changes, and those that came later behind the state, each under its name.

use sha2::{Digest, Sha256};

use super::metrics::{IN_STATE, MetricsRow};
use crate::metrics::{RowValues, Value, over_time};
use crate::saved_bytes;

/// The last bytes of a snapshot that has later metrics.
const MAGIC: &[u8; 8] = b"evsrows1";
/// Digest and length of what stands before them, and the magic.
const TAIL_BYTES: usize = 32 + 8 + 8;

/// A metric's name, and its value in each row.
type Column = (String, Vec<Option<Value>>);

/// The later metrics of some rows, as bytes to stand behind the state; none where there are none.
pub(super) fn later(rows: &[MetricsRow]) -> Vec<u8> {
    let names = over_time().filter(|name| !IN_STATE.contains(name));
    let column = |name: &str| {
        let values = rows.iter().map(|row| row.values.get(name));
        (name.to_owned(), values.collect())
    };
    let columns: Vec<Column> = names.map(column).collect();
    seal(&columns)
}

fn seal(columns: &[Column]) -> Vec<u8> {
    if columns.is_empty() {
        return Vec::new();
    }
    let mut bytes = saved_bytes::append(Vec::new(), columns);
    let (digest, length) = (Sha256::digest(&bytes), bytes.len() as u64);
    bytes.extend_from_slice(&digest);
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(MAGIC);
    bytes
}

/// Parts a snapshot into the state and the later metrics behind it; `None` where these are damaged.
fn split(bytes: &[u8]) -> Option<(&[u8], Vec<Column>)> {
    if !bytes.ends_with(MAGIC) {
        return Some((bytes, Vec::new()));
    }
    let (rest, tail) = bytes.split_at_checked(bytes.len().checked_sub(TAIL_BYTES)?)?;
    let (digest, length) = tail.split_at_checked(32)?;
    let length = u64::from_le_bytes(length.first_chunk().copied()?);
    let state = rest.len().checked_sub(usize::try_from(length).ok()?)?;
    let (state, columns) = rest.split_at_checked(state)?;
    if Sha256::digest(columns)[..] != *digest {
        return None;
    }
    Some((state, postcard::from_bytes(columns).ok()?))
}

/// The later metrics of a snapshot.
pub(super) struct Later(Vec<Column>);

impl Later {
    /// Takes them from behind the state; `None` where they are damaged.
    pub(super) fn split(bytes: &[u8]) -> Option<(&[u8], Self)> {
        split(bytes).map(|(state, columns)| (state, Self(columns)))
    }

    /// Adds them to the rows of the state; a metric that the program which saved them had not stays
    /// absent. `None` where there are not as many values as rows.
    pub(super) fn add_to(self, rows: &mut [MetricsRow]) -> Option<()> {
        if self.0.iter().any(|(_, values)| values.len() != rows.len()) {
            return None;
        }
        let column = |name: &str| self.0.iter().find(|(known, _)| known == name);
        for (place, row) in rows.iter_mut().enumerate() {
            let saved = row.values;
            row.values = RowValues::from_names(|name| {
                column(name).map_or_else(|| saved.get(name), |(_, values)| values[place])
            });
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    fn row(steps: u64) -> MetricsRow {
        MetricsRow {
            steps,
            epoch: 2,
            entered: [4, 3, 2, 1],
            values: RowValues::from_names(|name| match name {
                "overlap" => None,
                "collisions" => Some(Value::Count(steps)),
                _ => Some(Value::Real(steps as f64 / 8.0)),
            }),
        }
    }

    /// As the state gives a row back.
    fn of_state(row: &MetricsRow) -> MetricsRow {
        postcard::from_bytes(&postcard::to_stdvec(row).unwrap()).unwrap()
    }

    #[test]
    fn rows_come_back_with_every_metric() {
        let rows = [row(7), row(8)];
        let bytes = [b"state".as_slice(), &later(&rows)].concat();
        let (state, later) = Later::split(&bytes).unwrap();
        assert_eq!(state, b"state");
        let mut restored = rows.each_ref().map(of_state);
        later.add_to(&mut restored).unwrap();
        assert_eq!(restored, rows);
    }

    #[test]
    fn later_metrics_are_absent_where_they_were_not_saved() {
        let row = row(7);
        let mut restored = [of_state(&row)];
        Later::split(b"state")
            .unwrap()
            .1
            .add_to(&mut restored)
            .unwrap();
        for (name, value) in restored[0].values.iter() {
            let known = IN_STATE.contains(&name);
            assert_eq!(value, row.values.get(name).filter(|_| known), "{name}");
        }
    }

    #[test]
    fn damage_behind_the_state_is_found() {
        let column = |values: Vec<Option<Value>>| ("other".to_owned(), values);
        let columns = [column(vec![None, Some(Value::Count(3))])];
        let bytes = [b"state".as_slice(), &seal(&columns)].concat();
        let (state, read) = split(&bytes).unwrap();
        assert_eq!((state, &read[..]), (b"state".as_slice(), &columns[..]));
        assert!(seal(&[]).is_empty());
        // Two values for one row.
        assert!(Later(read).add_to(&mut [row(1)]).is_none());
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1;
            let found = split(&damaged);
            // What is not found here leaves other bytes as the state, which has a digest of its own.
            assert!(found.is_none_or(|(state, _)| state != b"state"), "{place}");
        }
    }
}
