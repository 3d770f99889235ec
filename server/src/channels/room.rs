//! Whether shared memory has room for what is about to be written. Its files are sparse: a write to
//! a page for which there is none ends the process (SIGBUS), so every write asks here first.

/// Where the transport's segments lie (`shm_open`).
const SHARED_MEMORY: &str = "/dev/shm";
/// What must stay free after any write: some 50 times the transport's own tables of a channel with
/// its readers, and room for other programs that write between the look and the write.
const MARGIN_BYTES: u64 = 1 << 20;

/// Shared memory is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{SHARED_MEMORY} has {free_bytes} bytes free and {needed_bytes} are needed")]
pub struct NoRoom {
    /// Bytes to be written, margin included.
    pub needed_bytes: u64,
    /// Bytes that are free.
    pub free_bytes: u64,
}

/// Looks whether so many bytes, and a margin, are free.
///
/// # Errors
/// [`NoRoom`] when they are not. A system that does not say is taken to have room.
pub(super) fn for_bytes(bytes: usize) -> Result<(), NoRoom> {
    let Ok(state) = rustix::fs::statvfs(SHARED_MEMORY) else {
        return Ok(());
    };
    compare(bytes, state.f_bavail.saturating_mul(state.f_frsize))
}

fn compare(bytes: usize, free_bytes: u64) -> Result<(), NoRoom> {
    let needed_bytes = (bytes as u64).saturating_add(MARGIN_BYTES);
    if free_bytes < needed_bytes {
        return Err(NoRoom {
            needed_bytes,
            free_bytes,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_margin_stays_free() {
        assert_eq!(compare(10, MARGIN_BYTES + 10), Ok(()));
        let refused = NoRoom {
            needed_bytes: MARGIN_BYTES + 10,
            free_bytes: MARGIN_BYTES + 9,
        };
        assert_eq!(compare(10, MARGIN_BYTES + 9), Err(refused));
        assert!(compare(usize::MAX, u64::MAX - 1).is_err());
        assert_eq!(for_bytes(0), Ok(()), "this machine has shared memory");
    }
}
