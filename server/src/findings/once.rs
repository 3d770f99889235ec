//! What is the same for all who ask for it: made once, however many ask at a time.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use hashlink::LruCache;
use parking_lot::Mutex;

/// Most bytes that are kept; the least recently used give way.
const MAX_BYTES: usize = 64 << 20;
/// Longest wait for another who makes the same.
const PATIENCE: Duration = Duration::from_secs(30);

/// What was made, and what is being made.
pub struct Once(Mutex<State>);

struct State {
    made: LruCache<String, Bytes>,
    bytes: usize,
    being_made: BTreeMap<String, Arc<Mutex<()>>>,
}

impl Default for Once {
    fn default() -> Self {
        Self(Mutex::new(State {
            made: LruCache::new_unbounded(),
            bytes: 0,
            being_made: BTreeMap::new(),
        }))
    }
}

impl Once {
    /// What was made for this key, by whoever asked first; `None` where that takes too long.
    pub fn get<E>(
        &self,
        key: &str,
        make: impl FnOnce() -> Result<Bytes, E>,
    ) -> Option<Result<Bytes, E>> {
        let making = {
            let mut state = self.0.lock();
            if let Some(made) = state.made.get(key) {
                return Some(Ok(made.clone()));
            }
            Arc::clone(state.being_made.entry(key.to_owned()).or_default())
        };
        let _making = making.try_lock_for(PATIENCE)?;
        if let Some(made) = self.0.lock().made.get(key) {
            return Some(Ok(made.clone()));
        }
        // Whoever waits has the lock too: should this fail, the next one tries.
        let made = make();
        let mut state = self.0.lock();
        state.being_made.remove(key);
        if let Ok(made) = &made {
            state.keep(key.to_owned(), made.clone());
        }
        Some(made)
    }
}

impl State {
    fn keep(&mut self, key: String, made: Bytes) {
        if made.len() > MAX_BYTES {
            return;
        }
        self.bytes += made.len();
        if let Some(before) = self.made.insert(key, made) {
            self.bytes -= before.len();
        }
        while self.bytes > MAX_BYTES
            && let Some((_, oldest)) = self.made.remove_lru()
        {
            self.bytes -= oldest.len();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn what_many_ask_at_once_is_made_once() {
        let (once, times) = (Once::default(), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..16 {
                scope.spawn(|| {
                    let made = once.get("curves", || {
                        times.fetch_add(1, Ordering::SeqCst);
                        std::thread::sleep(Duration::from_millis(20));
                        Ok::<_, ()>(Bytes::from_static(b"made"))
                    });
                    assert_eq!(made, Some(Ok(Bytes::from_static(b"made"))));
                });
            }
        });
        assert_eq!(times.into_inner(), 1);
        assert!(once.0.lock().being_made.is_empty());
    }

    #[test]
    fn what_is_kept_is_made_once_and_failures_are_not_kept() {
        let once = Once::default();
        let make = |byte: u8| move || Ok::<_, ()>(Bytes::from(vec![byte]));
        assert_eq!(once.get("a", || Err(7)), Some(Err(7)));
        assert_eq!(once.get("a", make(1)).unwrap().unwrap()[0], 1);
        assert_eq!(once.get("a", make(2)).unwrap().unwrap()[0], 1);
        assert_eq!(once.get("b", make(3)).unwrap().unwrap()[0], 3);
    }

    #[test]
    fn failures_are_not_kept_and_what_is_kept_is_bounded() {
        let once = Once::default();
        assert_eq!(once.get("a", || Err(7)), Some(Err(7)));
        let part = Bytes::from(vec![0; MAX_BYTES / 2]);
        for asked in ["a", "b", "c"] {
            let made = once.get(asked, || Ok::<_, ()>(part.clone()));
            assert_eq!(made.unwrap().unwrap().len(), part.len());
        }
        let whole = Bytes::from(vec![0; MAX_BYTES + 1]);
        once.get("d", || Ok::<_, ()>(whole)).unwrap().unwrap();
        let state = once.0.lock();
        assert_eq!((state.bytes, state.made.len()), (MAX_BYTES / 2 * 2, 2));
        assert!(state.being_made.is_empty());
    }
}
