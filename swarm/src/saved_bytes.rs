//! Plain data as `postcard` bytes: states of runs and what is stored of findings, which are mostly
//! small numbers of a byte each.

use postcard::ser_flavors::Flavor;
use serde::Serialize;

/// Bytes that are pushed one by one where they come one by one: postcard's own list copies a slice
/// for every number.
struct Pushed(Vec<u8>);

impl Flavor for Pushed {
    type Output = Vec<u8>;

    #[inline(always)]
    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0.push(byte);
        Ok(())
    }

    #[inline(always)]
    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        match *bytes {
            [byte] => self.0.push(byte),
            _ => self.0.extend_from_slice(bytes),
        }
        Ok(())
    }

    fn finalize(self) -> postcard::Result<Self::Output> {
        Ok(self.0)
    }
}

/// Appends a value to `bytes`: what [`postcard::to_stdvec`] gives.
pub fn append<T: Serialize + ?Sized>(bytes: Vec<u8>, value: &T) -> Vec<u8> {
    #[allow(
        clippy::expect_used,
        reason = "plain data has no sequence of unknown length, so this cannot fail"
    )]
    postcard::serialize_with_flavor(value, Pushed(bytes)).expect("plain data serializes")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn the_bytes_are_postcards() {
        let value = (
            vec![0_u32, 1, 127, 128, 70_000, u32::MAX],
            ("text", Some(-1.5_f32), [u64::MAX, 0, 3]),
            (None::<u8>, i64::MIN),
        );
        let expected = postcard::to_stdvec(&value).unwrap();
        assert_eq!(append(Vec::new(), &value), expected);
        let after = append(b"head".to_vec(), &value);
        assert_eq!(after.strip_prefix(b"head"), Some(&expected[..]));
    }
}
