//! What is dear to compute and asked for again: pictures, and the squares that a robot can reach.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use arenas::Arena;
use axum::body::Bytes;
use hashlink::LruCache;
use sha2::{Digest, Sha256};

/// Pictures kept, of some 50 kB each.
const PICTURES: usize = 128;
/// Masks kept, of a byte a square.
const MASKS: usize = 64;

type Key = [u8; 32];

/// The latest pictures and masks; the least recently used give way.
pub struct Pictures {
    pngs: Mutex<LruCache<Key, Bytes>>,
    masks: Mutex<LruCache<Key, Option<Arc<[bool]>>>>,
}

impl Default for Pictures {
    fn default() -> Self {
        Self {
            pngs: Mutex::new(LruCache::new(PICTURES)),
            masks: Mutex::new(LruCache::new(MASKS)),
        }
    }
}

impl Pictures {
    /// The picture of these visits of this run, drawn only if it is not kept.
    pub fn png(&self, run: &str, visits: &[u32], draw: impl FnOnce() -> Vec<u8>) -> Bytes {
        let mut hash = Sha256::new();
        hash.update(run);
        for count in visits {
            hash.update(count.to_le_bytes());
        }
        kept(&self.pngs, hash.finalize().into(), || draw().into())
    }

    /// The squares that a robot of this radius can reach from the arena's first start.
    pub fn mask(&self, arena: &Arena, body_radius_m: f64) -> Option<Arc<[bool]>> {
        let mut hash = Sha256::new();
        hash.update(body_radius_m.to_le_bytes());
        hash.update(arena.content_key());
        kept(&self.masks, hash.finalize().into(), || {
            let start = *arena.starts().first()?;
            Some(arenas::reachable(arena, start, body_radius_m).mask.into())
        })
    }
}

/// The value of this key. It is made without the lock, at worst twice at a time.
fn kept<V: Clone>(cache: &Mutex<LruCache<Key, V>>, key: Key, make: impl FnOnce() -> V) -> V {
    if let Some(value) = lock(cache).get(&key) {
        return value.clone();
    }
    let value = make();
    lock(cache).insert(key, value.clone());
    value
}

fn lock<V>(cache: &Mutex<LruCache<Key, V>>) -> MutexGuard<'_, LruCache<Key, V>> {
    cache.lock().unwrap_or_else(PoisonError::into_inner)
}
