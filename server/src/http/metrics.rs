//! What the server does, counted and measured for Prometheus.

use std::sync::atomic::AtomicU64;

use api::WaitsFor;
use axum::http::{Method, StatusCode};
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::Registry;

use super::connections::open_connections;
use super::refusal::Refusal;
use crate::memory::resident_bytes;
use crate::scheduler::{Counters, Scheduler};
use crate::store::Store;

type Labels = Vec<(&'static str, String)>;
type Number = Gauge<u64, AtomicU64>;
type Times = Family<Labels, Histogram, fn() -> Histogram>;

/// What is told, by name.
pub struct Metrics {
    registry: Registry,
    requests: Times,
    runs: Family<Labels, Number>,
    store_bytes: Family<Labels, Number>,
    queued: Number,
    busy: Number,
    waiting: Family<Labels, Number>,
    threads: Number,
    memory_bytes: Number,
    room_bytes: Number,
    connections: Number,
}

impl Metrics {
    /// All of them; those that workers count are theirs.
    pub fn new(counters: &Counters) -> Self {
        let mut told = Self {
            registry: Registry::with_prefix("evswarm"),
            // From a millisecond to half a minute.
            requests: Family::new_with_constructor(|| {
                Histogram::new(exponential_buckets(0.001, 3.0, 10))
            }),
            runs: Family::default(),
            store_bytes: Family::default(),
            queued: Number::default(),
            busy: Number::default(),
            waiting: Family::default(),
            threads: Number::default(),
            memory_bytes: Number::default(),
            room_bytes: Number::default(),
            connections: Number::default(),
        };
        let registry = &mut told.registry;
        registry.register(
            "robot_steps",
            "Robot-steps done since the start",
            counters.robot_steps.clone(),
        );
        registry.register(
            "checkpoint_seconds",
            "Time to write a checkpoint",
            counters.checkpoint_s.clone(),
        );
        registry.register(
            "checkpoints_failed",
            "Checkpoints that could not be written",
            counters.checkpoints_failed.clone(),
        );
        registry.register(
            "http_request_seconds",
            "Time to answer, by method, route and status; to the head of what is streamed",
            told.requests.clone(),
        );
        registry.register("runs", "Runs by state", told.runs.clone());
        registry.register(
            "queued_runs",
            "Runs that wait for a thread",
            told.queued.clone(),
        );
        registry.register("busy_threads", "Threads that step a run", told.busy.clone());
        registry.register(
            "waiting_runs",
            "Runs that a thread holds while they wait for other programs",
            told.waiting.clone(),
        );
        registry.register("threads", "Threads that step runs", told.threads.clone());
        registry.register(
            "memory_resident_bytes",
            "Memory of the process that is resident",
            told.memory_bytes.clone(),
        );
        registry.register(
            "store_bytes",
            "Bytes of the data directory, by part",
            told.store_bytes.clone(),
        );
        registry.register(
            "store_room_bytes",
            "Bytes that are left where the data directory is",
            told.room_bytes.clone(),
        );
        registry.register("connections", "Open connections", told.connections.clone());
        told
    }

    /// Counts an answer.
    pub fn answered(&self, method: &Method, route: &str, status: StatusCode, seconds: f64) {
        // Methods come from outside, and there is no end of them.
        let known = [
            Method::GET,
            Method::HEAD,
            Method::POST,
            Method::PUT,
            Method::DELETE,
        ];
        let method = if known.contains(method) {
            method.as_str()
        } else {
            "other"
        };
        let labels = vec![
            ("method", method.to_owned()),
            ("route", route.to_owned()),
            ("status", status.as_str().to_owned()),
        ];
        self.requests.get_or_create(&labels).observe(seconds);
    }

    /// OpenMetrics text of this moment.
    pub fn text(&self, store: &Store, scheduler: &Scheduler) -> Result<String, Refusal> {
        let mut counts: Vec<(String, u64)> = store.run_counts()?;
        // A state that no run is in any more is told as 0.
        for state in api::State::ALL {
            if !counts.iter().any(|(known, _)| known == state.name()) {
                counts.push((state.name().to_owned(), 0));
            }
        }
        for (state, count) in counts {
            self.runs.get_or_create(&vec![("state", state)]).set(count);
        }
        for (part, bytes) in store.sizes() {
            let labels = vec![("part", part.to_owned())];
            self.store_bytes.get_or_create(&labels).set(bytes);
        }
        self.queued.set(scheduler.queued() as u64);
        let busy = scheduler.busy();
        self.busy.set(busy.len() as u64);
        for whom in WaitsFor::ALL {
            let waiting = busy.iter().filter(|it| it.waits_for == Some(whom)).count();
            let labels = vec![("for", whom.name().to_owned())];
            self.waiting.get_or_create(&labels).set(waiting as u64);
        }
        self.threads.set(scheduler.worker_count() as u64);
        self.memory_bytes.set(resident_bytes());
        self.room_bytes.set(store.room_bytes());
        self.connections.set(open_connections());
        let mut text = String::new();
        encode(&mut text, &self.registry).map_err(|error| Refusal::internal(&error))?;
        Ok(text)
    }
}
