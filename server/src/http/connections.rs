//! Connections: how many there are in all and from one address, and how long each may keep still.
//! A new connection takes the place of the one that has been still for longest, so that silent
//! ones shut nobody out.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::Notify;

/// Most connections: each costs a descriptor and up to some hundred kilobytes of buffers.
const MAX_CONNECTIONS: usize = 1_024;
/// Fewest, however few descriptors there are.
const MIN_CONNECTIONS: usize = 16;
/// Share of all that one address may have, so that one client leaves room for others.
const ADDRESS_SHARE: usize = 2;
/// Descriptors for database, checkpoints, logs and libraries.
const KEPT_BACK: u64 = 256;
/// Descriptors of a run that is stepped: all of its channels, which have 44.
const KEPT_BACK_A_RUN: u64 = 50;
/// Longest time between the first byte of a request's head and its last, and from the opening of a
/// connection to the first byte.
const HEAD_TIME: Duration = Duration::from_secs(10);
/// Longest time between two requests, or between two parts of an answer that the client takes.
const IDLE_TIME: Duration = Duration::from_secs(60);

/// Open connections of the process.
static OPEN: AtomicU64 = AtomicU64::new(0);

/// Open connections of the process.
pub fn open_connections() -> u64 {
    OPEN.load(Ordering::Relaxed)
}

/// What a connection is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Nothing but perhaps the end of an answer is under way.
    Idle,
    /// The head of a request is awaited.
    Head,
    /// Its body is awaited; whoever reads it keeps the time.
    Body,
    /// A request is answered; whoever answers keeps the time.
    Working,
}

/// One connection.
pub struct Connection {
    address: IpAddr,
    now: Mutex<(Stage, Instant)>,
    /// Whether a request of it was answered: such a client is kept longer than one that never asked.
    has_asked: AtomicBool,
    closed: Notify,
}

impl Connection {
    /// One that has just been opened.
    pub fn new(address: IpAddr) -> Self {
        Self {
            address,
            now: Mutex::new((Stage::Head, Instant::now())),
            has_asked: AtomicBool::new(false),
            closed: Notify::new(),
        }
    }

    /// Where it comes from.
    pub fn address(&self) -> IpAddr {
        self.address
    }

    /// Says what the connection does from now on.
    pub fn enter(&self, stage: Stage) {
        if stage == Stage::Idle {
            self.has_asked.store(true, Ordering::Relaxed);
        }
        *lock(&self.now) = (stage, Instant::now());
    }

    /// Bytes were read.
    pub fn has_read(&self) {
        let mut now = lock(&self.now);
        if now.0 == Stage::Idle {
            *now = (Stage::Head, Instant::now());
        }
    }

    /// Bytes were written.
    pub fn has_written(&self) {
        let mut now = lock(&self.now);
        if now.0 == Stage::Idle {
            now.1 = Instant::now();
        }
    }

    /// Ends the connection.
    pub fn close(&self) {
        self.closed.notify_one();
    }

    /// How long nothing has been written of an answer, or read of what follows.
    pub fn still_for(&self, at: Instant) -> Duration {
        let (stage, since) = *lock(&self.now);
        match stage {
            Stage::Idle => at.saturating_duration_since(since),
            Stage::Head | Stage::Body | Stage::Working => Duration::ZERO,
        }
    }

    /// Completes when the connection has to end.
    pub async fn closed(&self) {
        self.closed.notified().await;
    }

    fn is_overdue(&self, at: Instant) -> bool {
        let (stage, since) = *lock(&self.now);
        let most = match stage {
            Stage::Head => HEAD_TIME,
            Stage::Idle => IDLE_TIME,
            Stage::Body | Stage::Working => return false,
        };
        at.saturating_duration_since(since) > most
    }

    /// Smaller for those that are closed first; `None` for those that are not.
    fn patience(&self) -> Option<(bool, Instant)> {
        let (stage, since) = *lock(&self.now);
        (stage != Stage::Working).then(|| (self.has_asked.load(Ordering::Relaxed), since))
    }
}

/// The open connections.
pub struct Connections {
    most: usize,
    open: Mutex<BTreeMap<u64, Arc<Connection>>>,
    next: AtomicU64,
}

/// A connection as long as it is open; dropped, its place is free.
pub struct Place {
    connections: Arc<Connections>,
    number: u64,
    /// What it is doing.
    pub connection: Arc<Connection>,
}

impl Drop for Place {
    fn drop(&mut self) {
        OPEN.fetch_sub(1, Ordering::Relaxed);
        lock(&self.connections.open).remove(&self.number);
    }
}

impl Connections {
    /// As many as the process's descriptors allow where so many runs are stepped at once; raises
    /// their number as far as it may.
    pub fn beside(runs: usize) -> Self {
        Self::with_most(most_connections(raise_descriptors(), runs as u64))
    }

    fn with_most(most: usize) -> Self {
        Self {
            most,
            open: Mutex::default(),
            next: AtomicU64::new(0),
        }
    }

    /// A place for a new connection from this address; where there is none, the stillest connection
    /// of the same address, or of all, is closed. `None` when every one is at work.
    pub fn admit(self: &Arc<Self>, address: IpAddr) -> Option<Place> {
        let mut open = lock(&self.open);
        let of_address = open.values().filter(|other| other.address == address);
        let has_share = of_address.count() >= self.most / ADDRESS_SHARE;
        if has_share || open.len() >= self.most {
            let (_, number) = open
                .iter()
                .filter(|(_, other)| !has_share || other.address == address)
                .filter_map(|(number, other)| Some((other.patience()?, *number)))
                .min()?;
            if let Some(other) = open.remove(&number) {
                other.close();
            }
        }
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        let connection = Arc::new(Connection::new(address));
        open.insert(number, Arc::clone(&connection));
        OPEN.fetch_add(1, Ordering::Relaxed);
        Some(Place {
            connections: Arc::clone(self),
            number,
            connection,
        })
    }

    /// Closes what has been still for too long.
    pub fn close_overdue(&self) {
        let now = Instant::now();
        let open = lock(&self.open);
        for connection in open.values().filter(|other| other.is_overdue(now)) {
            connection.close();
        }
    }
}

/// Raises the number of descriptors that the process may have as far as it may; returns it.
fn raise_descriptors() -> u64 {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limits = getrlimit(Resource::Nofile);
    let raised = Rlimit {
        current: limits.maximum,
        maximum: limits.maximum,
    };
    if let Err(error) = setrlimit(Resource::Nofile, raised) {
        tracing::warn!(%error, "the number of descriptors cannot be raised");
    }
    getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX)
}

fn most_connections(descriptors: u64, runs: u64) -> usize {
    let kept_back = KEPT_BACK.saturating_add(KEPT_BACK_A_RUN.saturating_mul(runs));
    let left = usize::try_from(descriptors.saturating_sub(kept_back)).unwrap_or(usize::MAX);
    left.clamp(MIN_CONNECTIONS, MAX_CONNECTIONS)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    const HERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::LOCALHOST);
    const THERE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 1));

    fn open(connections: &Arc<Connections>) -> Vec<u64> {
        lock(&connections.open).keys().copied().collect()
    }

    #[test]
    fn the_stillest_of_an_address_gives_way() {
        let connections = Arc::new(Connections::with_most(6));
        let places: Vec<Place> = (0..3).map(|_| connections.admit(HERE).unwrap()).collect();
        places[0].connection.enter(Stage::Idle);
        let other = connections.admit(THERE).unwrap();
        // Connection 0 has asked for something, so 1 goes; then 2.
        let _fourth = connections.admit(HERE).unwrap();
        assert_eq!(open(&connections), [0, 2, 3, 4]);
        let fifth = connections.admit(HERE).unwrap();
        assert_eq!(open(&connections), [0, 3, 4, 5]);
        places[0].connection.enter(Stage::Working);
        fifth.connection.enter(Stage::Working);
        _fourth.connection.enter(Stage::Working);
        assert!(connections.admit(HERE).is_none());
        assert!(connections.admit(THERE).is_some());
        drop(other);
        drop(places);
        assert_eq!(open(&connections), [4, 5]);
    }

    #[test]
    fn a_full_server_closes_the_stillest_of_all() {
        let connections = Arc::new(Connections::with_most(4));
        let address = |last| IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, last));
        let places: Vec<Place> = (0..4)
            .map(|last| connections.admit(address(last)).unwrap())
            .collect();
        places[0].connection.enter(Stage::Working);
        let _fifth = connections.admit(address(9)).unwrap();
        assert_eq!(open(&connections), [0, 2, 3, 4]);
    }

    #[test]
    fn time_is_kept_by_stage() {
        let connection = Connection::new(HERE);
        let after = |time: Duration| connection.is_overdue(Instant::now() + time);
        let moment = Duration::from_secs(1);
        assert!(!after(HEAD_TIME - moment) && after(HEAD_TIME + moment));
        connection.enter(Stage::Working);
        assert!(!after(IDLE_TIME * 2));
        connection.has_read();
        assert!(!after(IDLE_TIME * 2));
        connection.enter(Stage::Idle);
        assert!(!after(IDLE_TIME - moment) && after(IDLE_TIME + moment));
        connection.has_read();
        assert!(after(HEAD_TIME + moment));
    }

    #[test]
    fn descriptors_are_kept_back() {
        assert_eq!(most_connections(1_000_000, 100), MAX_CONNECTIONS);
        assert_eq!(most_connections(1_024, 2), 668);
        assert_eq!(most_connections(64, 1), MIN_CONNECTIONS);
    }
}
