//! What is dear to make and asked for again: pictures and reports.

use std::hash::Hash;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use hashlink::LruCache;

use crate::reproduce::Report;
use crate::store::JobKey;

/// Files kept, of some 50 kB each.
const FILES: usize = 128;
/// Reports kept, of some megabytes each.
const REPORTS: usize = 4;

/// The latest of each; the least recently used give way.
pub struct Kept {
    /// By the tag of what they show.
    files: Mutex<LruCache<String, Bytes>>,
    /// Of jobs that are done, with so many runs: more come and some go, but of a job with a report
    /// it is known which. No job's number is used again.
    reports: Mutex<LruCache<(JobKey, u64), Arc<Report>>>,
}

impl Default for Kept {
    fn default() -> Self {
        Self {
            files: Mutex::new(LruCache::new(FILES)),
            reports: Mutex::new(LruCache::new(REPORTS)),
        }
    }
}

impl Kept {
    /// The file of this tag, made only if it is not kept.
    pub fn file<E>(&self, tag: &str, make: impl FnOnce() -> Result<Bytes, E>) -> Result<Bytes, E> {
        kept(&self.files, tag.to_owned(), make)
    }

    /// The report of this job with so many runs, made only if it is not kept, and kept only if it can
    /// be made.
    pub fn report<E>(
        &self,
        job: (JobKey, u64),
        make: impl FnOnce() -> Result<Report, E>,
    ) -> Result<Arc<Report>, E> {
        kept(&self.reports, job, || make().map(Arc::new))
    }
}

/// The value of this key. It is made without the lock, at worst twice at a time.
fn kept<K: Hash + Eq, V: Clone, E>(
    cache: &Mutex<LruCache<K, V>>,
    key: K,
    make: impl FnOnce() -> Result<V, E>,
) -> Result<V, E> {
    if let Some(value) = lock(cache).get(&key) {
        return Ok(value.clone());
    }
    let value = make()?;
    lock(cache).insert(key, value.clone());
    Ok(value)
}

fn lock<K, V>(cache: &Mutex<LruCache<K, V>>) -> MutexGuard<'_, LruCache<K, V>> {
    cache.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn what_is_kept_is_made_once_and_failures_are_not_kept() {
        let kept = Kept::default();
        let make = |byte: u8| move || Ok::<_, ()>(Bytes::from(vec![byte]));
        assert_eq!(kept.file("a", || Err(7)), Err(7));
        assert_eq!(kept.file("a", make(1)).unwrap()[0], 1);
        assert_eq!(kept.file("a", make(2)).unwrap()[0], 1);
        assert_eq!(kept.file("b", make(3)).unwrap()[0], 3);
    }
}
