//! How long tables are that were made: they are never held as a whole.

use std::sync::{Mutex, PoisonError};

use axum::http::HeaderValue;
use hashlink::LruCache;

/// Tables whose lengths are known.
const LENGTHS: usize = 256;

/// How long tables are, by their tags: so that one that is fetched in parts is counted once.
pub struct Lengths(Mutex<LruCache<HeaderValue, u64>>);

impl Default for Lengths {
    fn default() -> Self {
        Self(Mutex::new(LruCache::new(LENGTHS)))
    }
}

impl Lengths {
    /// The length of the table with this tag.
    pub fn get(&self, tag: &HeaderValue) -> Option<u64> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.get(tag).copied()
    }

    /// Keeps it; the least recently used gives way.
    pub fn put(&self, tag: &HeaderValue, bytes: u64) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.insert(tag.clone(), bytes);
    }
}
