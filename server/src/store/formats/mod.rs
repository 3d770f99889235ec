//! What findings are on disk: types of the store's own, each layout with a version, in an envelope
//! with a digest. To change a layout: add the next version beside the old one, write the new, read
//! both, and add a data directory of the new program to `tests/data_directories`.

mod blobs;
mod coverage;
mod envelope;
mod metrics;
mod tracks;
mod v0;

pub use blobs::Blobs;
pub use envelope::Damage;
pub use v0::{findings as findings_v0, upgrade as upgrade_v0};

#[cfg(test)]
mod tests;
