//! Memory of the process: how much of it is resident, and giving back what large requests left.

use std::time::Duration;

use tokio::time::MissedTickBehavior;

/// Time between two looks at what is resident ...
const LOOK_EVERY: Duration = Duration::from_secs(5);
/// ... and looks that are passed over at most while there is nothing to give back.
const MOST_PASSED_OVER: u32 = 60;
/// Growth after which the allocator is asked to give back what nobody holds.
const GROWN_BYTES: u64 = 64 << 20;

/// Resident memory of the process; 0 where the system does not tell.
pub fn resident_bytes() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = statm
        .split_whitespace()
        .nth(1)
        .and_then(|pages| pages.parse().ok());
    pages.unwrap_or(0_u64) * rustix::param::page_size() as u64
}

/// Gives back to the system, now and then while the process is larger than it was, what is free
/// within it: glibc keeps the small pieces that large requests took, hundreds of megabytes after
/// some at once.
pub async fn give_back() {
    let mut look = tokio::time::interval(LOOK_EVERY);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut least_bytes = resident_bytes();
    let (mut last_bytes, mut pass_over, mut passed_over) = (least_bytes, 0, 0);
    loop {
        look.tick().await;
        let bytes = resident_bytes();
        least_bytes = least_bytes.min(bytes);
        if bytes > last_bytes + GROWN_BYTES {
            pass_over = 0;
        }
        if bytes <= least_bytes + GROWN_BYTES || passed_over < pass_over {
            passed_over += 1;
            continue;
        }
        if let Err(error) = tokio::task::spawn_blocking(trim).await {
            tracing::error!(%error, "free memory cannot be given back");
        }
        last_bytes = resident_bytes();
        tracing::debug!(bytes, last_bytes, "free memory was given back");
        // What is in use need not be looked through again and again.
        let gave_back = last_bytes + GROWN_BYTES < bytes;
        passed_over = 0;
        pass_over = if gave_back {
            0
        } else {
            (2 * pass_over + 1).min(MOST_PASSED_OVER)
        };
    }
}

/// Gives back to the system what is free within the process, milliseconds for each 100 MB.
#[cfg(target_env = "gnu")]
pub fn trim() {
    // SAFETY: takes a number alone, may be called by any thread at any time, and touches nothing
    // that is in use (malloc_trim(3)).
    unsafe { libc::malloc_trim(0) };
}

/// Other allocators give back by themselves.
#[cfg(not(target_env = "gnu"))]
pub fn trim() {}
