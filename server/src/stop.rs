//! Asking the process to stop: the first signal does; only one that comes at least a second later
//! ends it at once. Process groups, Slurm and container inits send several within milliseconds, and
//! none of these may cost the checkpoint that the first one asked for.

use std::time::{Duration, Instant};

use anyhow::Context;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use tokio::sync::watch;

/// Signals that come sooner after the first one are taken for the same wish.
const SAME_WISH: Duration = Duration::from_secs(1);

/// Whether the process was asked to stop.
#[derive(Clone, Debug)]
pub struct Stop(watch::Receiver<bool>);

impl Stop {
    /// Listens for SIGINT and SIGTERM from now on; the process ends with `forced` where it is told
    /// to stop at once. To be called once in a process.
    ///
    /// # Errors
    /// When the system refuses the handlers or a thread.
    pub fn on_signals(forced: i32) -> anyhow::Result<Self> {
        let (sender, receiver) = watch::channel(false);
        let mut signals = Signals::new([SIGINT, SIGTERM]).context("cannot listen for signals")?;
        let listen = move || {
            let mut wishes = Wishes::default();
            for _ in signals.forever() {
                if wishes.is_forced(Instant::now()) {
                    tracing::warn!("asked again to stop: ending at once, without a checkpoint");
                    std::process::exit(forced);
                }
                sender.send_replace(true);
            }
        };
        std::thread::Builder::new()
            .name("signals".to_owned())
            .spawn(listen)
            .context("cannot start a thread")?;
        Ok(Self(receiver))
    }

    /// A process that nobody can stop, or that was asked to before it began.
    #[cfg(test)]
    pub fn fixed(asked: bool) -> Self {
        Self(watch::channel(asked).1)
    }

    /// Whether a signal has come.
    pub fn is_asked(&self) -> bool {
        *self.0.borrow()
    }

    /// Completes when a signal comes.
    pub async fn asked(mut self) {
        // Without a sender there is no thread that listens: nothing will come any more.
        if self.0.wait_for(|asked| *asked).await.is_err() {
            std::future::pending().await
        }
    }
}

/// When the first signal came.
#[derive(Debug, Default)]
struct Wishes {
    first: Option<Instant>,
}

impl Wishes {
    /// Whether a signal that comes now means to stop at once.
    fn is_forced(&mut self, now: Instant) -> bool {
        let first = *self.first.get_or_insert(now);
        now.saturating_duration_since(first) >= SAME_WISH
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_signal_that_comes_a_second_after_the_first_forces() {
        let start = Instant::now();
        let mut wishes = Wishes::default();
        let mut check = |after_ms, forced| {
            let now = start + Duration::from_millis(after_ms);
            assert_eq!(wishes.is_forced(now), forced, "after {after_ms} ms");
        };
        check(0, false);
        check(2, false);
        check(300, false);
        check(999, false);
        check(1_000, true);
        check(60_000, true);
    }
}
