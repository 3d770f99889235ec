//! Bytes on disk with their kind, version and digest: changed, cut or longer ones are found out.

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use swarm::saved_bytes;

const MAGIC: [u8; 4] = *b"EVSF";
const DIGEST_BYTES: usize = 32;

/// What a blob is about; the number is on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Curve, visits, dwell.
    Coverage = 1,
    /// Swarm metrics over time and robot by robot.
    Metrics = 2,
    /// Movable objects over time.
    Objects = 3,
}

impl Kind {
    /// As messages and columns call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Coverage => "coverage",
            Self::Metrics => "metrics",
            Self::Objects => "objects",
        }
    }
}

/// Why bytes on disk cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Damage {
    /// They do not begin as such bytes do.
    #[error("it does not begin as it should")]
    Foreign,
    /// Bytes were changed, cut off or added.
    #[error("its digest does not match")]
    Digest,
    /// A later program wrote them.
    #[error("it has version {0}, which this program does not know")]
    Version(u8),
    /// They are whole, but do not fit together.
    #[error("{0}")]
    Content(String),
}

/// A layout with its version, in its envelope.
pub fn seal(kind: Kind, version: u8, layout: &impl Serialize) -> Vec<u8> {
    let mut bytes = [&MAGIC[..], &[kind as u8, version], &[0; DIGEST_BYTES]].concat();
    let head_bytes = bytes.len();
    bytes = saved_bytes::append(bytes, layout);
    let (head, payload) = bytes.split_at_mut(head_bytes);
    head[head_bytes - DIGEST_BYTES..].copy_from_slice(&digest(kind, version, payload));
    bytes
}

/// The version and the layout's bytes, once the envelope is found whole and of this kind.
pub fn open(kind: Kind, bytes: &[u8]) -> Result<(u8, &[u8]), Damage> {
    let rest = bytes.strip_prefix(&MAGIC).ok_or(Damage::Foreign)?;
    let ([found, version], rest) = rest.split_first_chunk().ok_or(Damage::Foreign)?;
    let (expected, payload) = rest.split_first_chunk().ok_or(Damage::Digest)?;
    if *found != kind as u8 {
        return Err(Damage::Foreign);
    }
    if *expected != digest(kind, *version, payload) {
        return Err(Damage::Digest);
    }
    Ok((*version, payload))
}

fn digest(kind: Kind, version: u8, payload: &[u8]) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update([kind as u8, version]);
    hash.update(payload);
    hash.finalize().into()
}

/// A layout that takes up all of these bytes.
pub fn whole<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Damage> {
    let (layout, rest) = taken(bytes)?;
    match rest {
        [] => Ok(layout),
        rest => Err(Damage::Content(format!(
            "{} bytes are left over",
            rest.len()
        ))),
    }
}

/// A layout at the beginning of these bytes, and what follows it.
pub fn taken<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), Damage> {
    postcard::take_from_bytes(bytes).map_err(|error| Damage::Content(error.to_string()))
}
