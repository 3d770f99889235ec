//! Vectors of a generic length in a snapshot, as one flat list of numbers.
//!
//! For `#[serde(with = "super::flat")]`: serde itself has no arrays of a generic length.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Writes the numbers one after the other.
pub fn serialize<const D: usize, S: Serializer>(
    vectors: &[[f32; D]],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    vectors.as_flattened().serialize(serializer)
}

/// Reads them back.
///
/// # Errors
/// When the count is not a multiple of `D`.
pub fn deserialize<'de, const D: usize, E: Deserializer<'de>>(
    deserializer: E,
) -> Result<Vec<[f32; D]>, E::Error> {
    let numbers = Vec::<f32>::deserialize(deserializer)?;
    match numbers.as_chunks::<D>() {
        (vectors, []) => Ok(vectors.to_vec()),
        _ => Err(E::Error::custom(format!(
            "{} numbers are no vectors of {D}",
            numbers.len()
        ))),
    }
}
