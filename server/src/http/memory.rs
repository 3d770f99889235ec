//! Memory of the process: how much of it is resident, and giving back what large requests left.

use std::time::Duration;

use tokio::time::MissedTickBehavior;

/// Time between two looks at what is resident.
const LOOK_EVERY: Duration = Duration::from_secs(5);
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

/// Gives back to the system, whenever the process has grown, what is free within it: glibc keeps the
/// small pieces that large requests took, hundreds of megabytes after some at once.
pub async fn give_back() {
    let mut look = tokio::time::interval(LOOK_EVERY);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut least_bytes = resident_bytes();
    loop {
        look.tick().await;
        let bytes = resident_bytes();
        if bytes <= least_bytes + GROWN_BYTES {
            least_bytes = least_bytes.min(bytes);
            continue;
        }
        if let Err(error) = tokio::task::spawn_blocking(trim).await {
            tracing::error!(%error, "free memory cannot be given back");
        }
        least_bytes = resident_bytes();
        tracing::debug!(bytes, least_bytes, "free memory was given back");
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
