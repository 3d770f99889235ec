//! What is dear to compute and asked for again: pictures, the squares that a robot can reach, and
//! reports.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use arenas::Arena;
use axum::body::Bytes;
use hashlink::LruCache;
use sha2::{Digest, Sha256};
use swarm::world::ObjectPose;

use crate::artifacts::Pushed;

use crate::reproduce::Report;
use crate::store::JobSeq;

/// Pictures kept, of some 50 kB each.
const PICTURES: usize = 128;
/// Masks kept, of a byte a square.
const MASKS: usize = 64;

/// Reports kept, of some megabytes each.
const REPORTS: usize = 4;

type Key = [u8; 32];

/// The latest pictures, masks and reports; the least recently used give way.
pub struct Pictures {
    pngs: Mutex<LruCache<Key, Bytes>>,
    masks: Mutex<LruCache<Key, Option<Arc<[bool]>>>>,
    /// Of jobs that are done: these do not change, and no job's number is used again.
    reports: Mutex<LruCache<JobSeq, Arc<Report>>>,
}

impl Default for Pictures {
    fn default() -> Self {
        Self {
            pngs: Mutex::new(LruCache::new(PICTURES)),
            masks: Mutex::new(LruCache::new(MASKS)),
            reports: Mutex::new(LruCache::new(REPORTS)),
        }
    }
}

impl Pictures {
    /// The picture of these visits and objects of this run, drawn only if it is not kept.
    pub fn png(
        &self,
        run: &str,
        visits: &[u32],
        objects: &[Pushed],
        draw: impl FnOnce() -> Vec<u8>,
    ) -> Bytes {
        let mut hash = Sha256::new();
        hash.update(run);
        for count in visits {
            hash.update(count.to_le_bytes());
        }
        for object in objects {
            hash.update((object.way_m.len() as u64).to_le_bytes());
            let ObjectPose { x_m, y_m, cos, sin } = object.pose;
            let way_m = object.way_m.iter().flatten().copied();
            for number in way_m.chain([x_m, y_m, cos, sin]) {
                hash.update(number.to_le_bytes());
            }
        }
        kept(&self.pngs, hash.finalize().into(), || draw().into())
    }

    /// The report of this job, made only if it is not kept, and kept only if it can be made.
    pub fn report<E>(
        &self,
        job: JobSeq,
        make: impl FnOnce() -> Result<Report, E>,
    ) -> Result<Arc<Report>, E> {
        if let Some(report) = lock(&self.reports).get(&job) {
            return Ok(Arc::clone(report));
        }
        let report = Arc::new(make()?);
        lock(&self.reports).insert(job, Arc::clone(&report));
        Ok(report)
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

fn lock<K, V>(cache: &Mutex<LruCache<K, V>>) -> MutexGuard<'_, LruCache<K, V>> {
    cache.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::documents::{BuiltinArenas, resolve};

    #[test]
    fn a_picture_is_kept_until_visits_or_objects_change() {
        let spec = serde_json::json!({ "engine": "rapier", "arena": {
            "name": "yard", "width_m": 0.6, "height_m": 0.6, "walls_m": [],
            "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.8 }],
            "objects": [{ "kind": "disc", "x_m": 0.3, "y_m": 0.3, "radius_m": 0.03 }]
        } });
        let spec = resolve(&spec, &BuiltinArenas).unwrap();
        let here = crate::artifacts::pushed(&spec, &swarm::run::Tracks::default());
        let mut turned = here.clone();
        (turned[0].pose.cos, turned[0].pose.sin) = (0.0, 1.0);
        let mut pushed = here.clone();
        pushed[0].way_m.push([0.4, 0.3]);
        let pictures = Pictures::default();
        let cases = [
            ([1, 2], &here),
            ([1, 3], &here),
            ([1, 2], &turned),
            ([1, 2], &pushed),
        ];
        for (number, (visits, objects)) in (0_u8..).zip(cases) {
            assert_eq!(
                pictures.png("a", &visits, objects, || vec![number])[0],
                number
            );
        }
        assert_eq!(pictures.png("a", &[1, 2], &here, || vec![9])[0], 0);
        assert_eq!(pictures.png("b", &[1, 2], &here, || vec![9])[0], 9);
    }
}
