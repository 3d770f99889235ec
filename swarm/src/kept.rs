//! What follows from an arena and a body alone, kept for the next run of the same: the index of the
//! walls, and the squares within reach. Bounded, and gone with the process.

use std::sync::{Arc, LazyLock, Mutex, MutexGuard, PoisonError};

use arenas::index::WallIndex;
use arenas::{Arena, Reachable};
use hashlink::LruCache;
use nalgebra::Point2;

/// Most bytes of each kind that are kept.
const MOST_BYTES: usize = 64 << 20;

/// Most starts for which squares within reach are kept: robots that are placed at random have others
/// in every run.
const MOST_STARTS: usize = 64;

static INDEXES: LazyLock<Kept<WallIndex>> = LazyLock::new(Kept::new);
static REACHABLE: LazyLock<Kept<Reachable>> = LazyLock::new(Kept::new);

/// The walls of an arena, indexed as [`WallIndex::new`] does.
pub(crate) fn wall_index(arena: &Arena, contact_m: f64, reach_m: f64) -> Arc<WallIndex> {
    let key = key(arena, &[contact_m, reach_m]);
    INDEXES.get_or_make(key, WallIndex::bytes, || {
        WallIndex::new(arena, contact_m, reach_m)
    })
}

/// The squares within reach from one start or another, as [`arenas::reachable_from`] finds them.
pub fn reachable_from(arena: &Arena, starts: &[Point2<f64>], body_radius_m: f64) -> Arc<Reachable> {
    let find = || arenas::reachable_from(arena, starts, body_radius_m);
    if starts.len() > MOST_STARTS {
        return Arc::new(find());
    }
    let places = starts.iter().flat_map(|start| [start.x, start.y]);
    let figures: Vec<f64> = std::iter::once(body_radius_m).chain(places).collect();
    let bytes = |found: &Reachable| found.mask.len();
    REACHABLE.get_or_make(key(arena, &figures), bytes, find)
}

/// An arena and some figures as bytes; figures are told apart by their bits.
fn key(arena: &Arena, figures: &[f64]) -> Vec<u8> {
    let mut key = Vec::new();
    for figure in figures {
        key.extend_from_slice(&figure.to_le_bytes());
    }
    key.extend_from_slice(&arena.content_key());
    key
}

type Values<V> = LruCache<Vec<u8>, (Arc<V>, usize)>;

/// Values by key with their bytes; the ones used longest ago give way.
struct Kept<V> {
    values: Mutex<Values<V>>,
}

impl<V> Kept<V> {
    fn new() -> Self {
        Self {
            values: Mutex::new(LruCache::new_unbounded()),
        }
    }

    /// The value of a key; `make` is called where it is not kept, at the same time by several who
    /// ask for it at once.
    fn get_or_make(
        &self,
        key: Vec<u8>,
        bytes: impl Fn(&V) -> usize,
        make: impl FnOnce() -> V,
    ) -> Arc<V> {
        if let Some((value, _)) = self.values().get(&key) {
            return Arc::clone(value);
        }
        let value = Arc::new(make());
        let bytes = key.len() + bytes(&value);
        if bytes <= MOST_BYTES / 4 {
            let mut values = self.values();
            values.insert(key, (Arc::clone(&value), bytes));
            let mut sum: usize = values.iter().map(|(_, (_, bytes))| bytes).sum();
            while sum > MOST_BYTES {
                sum -= values.remove_lru().map_or(sum, |(_, (_, bytes))| bytes);
            }
        }
        value
    }

    fn values(&self) -> MutexGuard<'_, Values<V>> {
        self.values.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(kept: &Kept<u32>, key: u8, bytes: usize, made: &mut u32) -> u32 {
        *kept.get_or_make(
            vec![key],
            |_| bytes,
            || {
                *made += 1;
                u32::from(key)
            },
        )
    }

    #[test]
    fn the_ones_used_last_are_kept_within_bounds() {
        let (kept, mut made) = (Kept::new(), 0);
        let quarter = MOST_BYTES / 4 - 1;
        for key in [1, 2, 3, 4, 1, 2, 3, 4] {
            assert_eq!(number(&kept, key, quarter, &mut made), u32::from(key));
        }
        assert_eq!(made, 4, "all four fit");
        number(&kept, 5, quarter, &mut made);
        number(&kept, 2, quarter, &mut made);
        assert_eq!(made, 5, "the one used last but three is still there");
        number(&kept, 1, quarter, &mut made);
        assert_eq!(made, 6, "the one used longest ago went");
        number(&kept, 9, MOST_BYTES, &mut made);
        number(&kept, 9, MOST_BYTES, &mut made);
        assert_eq!(made, 8, "what is too large is not kept");
    }

    #[test]
    fn what_is_kept_is_what_would_be_found() {
        for name in ["easy", "maze", "easy", "maze"] {
            #[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
            let arena = arenas::builtin(name).unwrap();
            let starts = [arena.starts()[0].position()];
            for radius_m in [0.037, 0.02, 0.037] {
                let kept = reachable_from(&arena, &starts, radius_m);
                assert_eq!(*kept, arenas::reachable_from(&arena, &starts, radius_m));
                let index = wall_index(&arena, radius_m, 0.1);
                let fresh = WallIndex::new(&arena, radius_m, 0.1);
                assert_eq!(format!("{index:?}"), format!("{fresh:?}"));
            }
        }
    }
}
