//! What is done about a reader of lossless frames that lags behind: it is waited for, unless it was
//! killed, the run is to be let go, the channel is not wanted any more, or the time is over.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use iceoryx2::port::{BackpressureAction, BackpressureInfo};
use iceoryx2::prelude::*;
use scoped_tls_hkt::scoped_thread_local;

use super::desk::Desk;
use super::set::LosslessSettings;

/// Time between two looks for readers that were killed, while one is waited for.
pub(super) const LOOK_FOR_DEAD: Duration = Duration::from_millis(200);
/// Sleep while a reader is waited for.
pub(super) const REST: Duration = Duration::from_micros(200);

scoped_thread_local! {
    /// What the thread that sends does while it waits, and whether it goes on waiting. The transport
    /// keeps whoever decides about readers for as long as the channel is open, so what lasts for one
    /// frame cannot be told otherwise.
    pub(super) static LOOK_AROUND: for<'a> &'a dyn Fn() -> bool
}

/// Whether to go on waiting for readers of a lossless channel.
#[derive(Clone)]
pub(super) struct Wanted {
    stopping: Arc<AtomicBool>,
    desk: Arc<Desk>,
    settings: LosslessSettings,
}

impl Wanted {
    /// As long as the channel is asked for like this, and the run is not to be let go.
    pub(super) fn new(
        stopping: &Arc<AtomicBool>,
        desk: &Arc<Desk>,
        settings: LosslessSettings,
    ) -> Self {
        Self {
            stopping: Arc::clone(stopping),
            desk: Arc::clone(desk),
            settings,
        }
    }

    pub(super) fn is_so(&self) -> bool {
        !self.stopping.load(Ordering::Relaxed) && self.desk.asked().lossless == Some(self.settings)
    }
}

/// Whether a port is still a reader.
type IsReader = Box<dyn Fn(u128) -> bool + Send>;

/// Who waits for a reader that lags behind.
pub(super) struct Patience {
    timeout: Duration,
    wanted: Wanted,
    config: Config,
    looked: Mutex<Instant>,
    is_reader: IsReader,
}

impl fmt::Debug for Patience {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Patience")
            .field("timeout", &self.timeout)
            .finish_non_exhaustive()
    }
}

impl Patience {
    /// Waits for so long, while the channel is wanted.
    pub(super) fn new(timeout: Duration, wanted: Wanted, config: Config) -> Self {
        Self {
            timeout,
            wanted,
            config,
            looked: Mutex::new(Instant::now()),
            is_reader: Box::new(|_| true),
        }
    }

    /// By what it knows whether a port is still a reader.
    pub(super) fn ask_whether(&mut self, is_reader: impl Fn(u128) -> bool + Send + 'static) {
        self.is_reader = Box::new(is_reader);
    }

    /// What to do about a reader whose buffer is full. It is asked again until there is room.
    pub(super) fn decide(&self, info: &BackpressureInfo) -> BackpressureAction {
        let goes_on = !LOOK_AROUND.is_set() || LOOK_AROUND.with(|look_around| look_around());
        if !goes_on || !self.wanted.is_so() || info.elapsed_time >= self.timeout {
            return BackpressureAction::DiscardDataAndFail;
        }
        let mut looked = self.looked.lock().unwrap_or_else(PoisonError::into_inner);
        if looked.elapsed() >= LOOK_FOR_DEAD {
            *looked = Instant::now();
            remove_dead(&self.config);
            if !(self.is_reader)(info.receiver_port_id) {
                return BackpressureAction::DiscardData;
            }
        }
        std::thread::sleep(REST);
        BackpressureAction::Retry
    }
}

/// Removes what processes that were killed left behind.
pub(super) fn remove_dead(config: &Config) {
    let listed = Node::<ipc::Service>::list(config, |state| {
        if let NodeState::Dead(dead) = state
            && let Err(error) = dead.try_remove_stale_resources()
        {
            tracing::debug!(?error, "a killed reader cannot be cleaned up yet");
        }
        CallbackProgression::Continue
    });
    if let Err(error) = listed {
        tracing::debug!(?error, "no look for killed readers");
    }
}
