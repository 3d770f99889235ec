//! The hand-over between a run's thread and its publishing thread: one frame, latest wins.
//! Neither side waits for the other longer than a swap of pointers takes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

use api::frames::{FrameHeader, ObjectState, RobotState};

use super::extent::Extent;

/// A frame in ordinary memory.
#[derive(Debug, Default)]
pub(super) struct Frame {
    /// What it shows.
    pub(super) header: FrameHeader,
    /// Every robot, in order of its number.
    pub(super) robots: Vec<RobotState>,
    /// Every movable object, in the order of the arena's.
    pub(super) objects: Vec<ObjectState>,
}

/// What the publishing thread finds in the slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taken {
    /// A frame that was not seen before.
    Fresh,
    /// Nothing new within the time limit.
    Nothing,
    /// Nothing new, and nothing will come.
    Closed,
}

/// The slot; shared by exactly two threads.
#[derive(Debug, Default)]
pub(super) struct Slot {
    state: Mutex<State>,
    changed: Condvar,
    watched: AtomicBool,
}

#[derive(Debug, Default)]
struct State {
    frame: Frame,
    fresh: bool,
    closed: bool,
}

impl Slot {
    /// An empty slot with room for frames of this extent.
    pub(super) fn with_room_for(extent: Extent) -> Self {
        let slot = Self::default();
        slot.lock().frame.robots.reserve(extent.robots);
        slot.lock().frame.objects.reserve(extent.objects);
        slot
    }

    /// Writes a frame over the one that waits, if any. Returns `false`, without having called
    /// `fill`, when the other side holds the slot at this very moment.
    pub(super) fn try_put(&self, fill: impl FnOnce(&mut Frame)) -> bool {
        let state = match self.state.try_lock() {
            Ok(state) => state,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return false,
        };
        self.fill(state, fill);
        true
    }

    /// As [`Slot::try_put`], but waits for the other side's swap to end.
    pub(super) fn put(&self, fill: impl FnOnce(&mut Frame)) {
        self.fill(self.lock(), fill);
    }

    fn fill(&self, mut state: MutexGuard<'_, State>, fill: impl FnOnce(&mut Frame)) {
        fill(&mut state.frame);
        state.fresh = true;
        drop(state);
        self.changed.notify_one();
    }

    /// Waits at most `limit` for a frame and swaps it with `spare`.
    pub(super) fn take(&self, spare: &mut Frame, limit: Duration) -> Taken {
        let idle = |state: &mut State| !state.fresh && !state.closed;
        let (mut state, _) = self
            .changed
            .wait_timeout_while(self.lock(), limit, idle)
            .unwrap_or_else(PoisonError::into_inner);
        if state.fresh {
            state.fresh = false;
            std::mem::swap(&mut state.frame, spare);
            Taken::Fresh
        } else if state.closed {
            Taken::Closed
        } else {
            Taken::Nothing
        }
    }

    /// Says that no further frame will come; the one that waits is still taken.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.changed.notify_one();
    }

    /// Whether anybody read frames when the publishing thread last looked.
    pub(super) fn watched(&self) -> bool {
        self.watched.load(Ordering::Relaxed)
    }

    /// Tells the run's thread whether anybody reads.
    pub(super) fn set_watched(&self, watched: bool) {
        self.watched.store(watched, Ordering::Relaxed);
    }

    /// A frame is replaced as a whole, so a panic of the other side leaves nothing half done that
    /// matters.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_WAIT: Duration = Duration::ZERO;

    fn put(slot: &Slot, sequence: u64) -> bool {
        slot.try_put(|frame| frame.header.sequence = sequence)
    }

    #[test]
    fn the_latest_frame_wins_and_is_taken_once() {
        let (slot, mut spare) = (Slot::default(), Frame::default());
        assert_eq!(slot.take(&mut spare, NO_WAIT), Taken::Nothing);
        assert!(put(&slot, 1) && put(&slot, 2));
        assert_eq!(slot.take(&mut spare, NO_WAIT), Taken::Fresh);
        assert_eq!(spare.header.sequence, 2);
        assert_eq!(slot.take(&mut spare, NO_WAIT), Taken::Nothing);
    }

    #[test]
    fn the_last_frame_is_taken_before_the_end() {
        let (slot, mut spare) = (Slot::default(), Frame::default());
        assert!(put(&slot, 7));
        slot.close();
        assert_eq!(slot.take(&mut spare, NO_WAIT), Taken::Fresh);
        assert_eq!(slot.take(&mut spare, NO_WAIT), Taken::Closed);
    }

    #[test]
    fn a_busy_slot_is_skipped_not_waited_for() {
        let slot = Slot::default();
        let held = slot.lock();
        assert!(!put(&slot, 1));
        drop(held);
        assert!(put(&slot, 1));
    }
}
