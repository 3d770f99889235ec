//! Runs on workers end as they do alone, whatever happens to them on the way.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use api::State as Life;
use serde_json::{Value, json};
use swarm::run::Run;

use super::*;
use crate::channels::ChannelSettings;
use crate::documents::{BuiltinArenas, ResolvedRun, expand};
use crate::recording::Limits;
use crate::store::{Created, Intent, JobKey, JobRequest, RunState, Store};

const PATIENCE: Duration = Duration::from_secs(120);

pub fn start(dir: &Path, workers: usize) -> (Arc<Store>, Scheduler) {
    start_with(dir, workers, Limits::DEFAULT)
}

pub fn start_with(dir: &Path, workers: usize, recordings: Limits) -> (Arc<Store>, Scheduler) {
    let store = Arc::new(Store::open(dir).unwrap());
    let config = SchedulerConfig {
        workers: NonZeroUsize::new(workers).unwrap(),
        unfinished_limit: 100,
        run_memory_bytes: 64 << 20,
        keep_every_epochs: None,
        recordings,
        channels: ChannelSettings::default(),
    };
    let scheduler = Scheduler::start(Arc::clone(&store), config).unwrap();
    (store, scheduler)
}

/// Brownian runs of the easy arena.
pub fn job(epochs: u32, seeds: u32) -> Value {
    json!({
        "base": {
            "arena": "easy", "controller": { "method": "brownian" },
            "epochs": epochs, "steps_per_epoch": 500,
        },
        "seeds": { "first": 1, "count": seeds },
    })
}

pub fn runs(job: &Value) -> Vec<ResolvedRun> {
    expand(job, &BuiltinArenas).unwrap().runs
}

pub fn submit(scheduler: &Scheduler, job: &Value) -> JobKey {
    let expanded = expand(job, &BuiltinArenas).unwrap();
    let request = JobRequest::new(b"", None);
    let job = scheduler.new_job(expanded, request).unwrap();
    match scheduler.submit(&job).unwrap() {
        Created::New(job, _) | Created::Replayed(job) => job,
    }
}

pub fn wait_for(what: &str, condition: impl Fn() -> bool) {
    let start = Instant::now();
    while !condition() {
        assert!(start.elapsed() < PATIENCE, "waited too long for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub fn wait_until_done(store: &Store, job: JobKey) {
    wait_for("the job", || {
        let view = store.job(job).unwrap().unwrap();
        assert_eq!(view.counts.failed, 0);
        view.counts.done == view.counts.total
    });
}

pub fn digest(store: &Store, run: &ResolvedRun) -> String {
    store
        .run(&run.key())
        .unwrap()
        .unwrap()
        .result()
        .unwrap()
        .state_sha256
        .clone()
}

pub fn digest_alone(run: &ResolvedRun) -> String {
    let mut run = Run::new(run.run_spec()).unwrap();
    run.advance(u64::MAX);
    run.outcome().unwrap().state_sha256
}

#[test]
fn a_run_that_holds_too_much_fails_and_others_go_on() {
    let home = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(home.path(), 1);
    // Their samples take some 100 MB while they babble; 64 MiB are allowed.
    let swarm = json!({
        "base": {
            "arena": { "from": "easy", "tile": [5, 4] }, "robots": 300, "placement": "grid",
            "controller": { "method": "im", "babbling_epochs": 100 }, "epochs": 1,
        },
    });
    let large = submit(&scheduler, &swarm);
    let small = submit(&scheduler, &job(2, 1));
    wait_for("the failure", || {
        store.job(large).unwrap().unwrap().counts.failed == 1
    });
    let run = store.all_runs(large).unwrap().remove(0);
    let RunState::Failed { reason } = run.state else {
        panic!("{run:?}")
    };
    assert!(reason.contains("memory_budget_bytes"), "{reason}");
    wait_until_done(&store, small);
}

/// Threads that keep every processor busy while they live.
struct Busy(
    Arc<std::sync::atomic::AtomicBool>,
    Vec<std::thread::JoinHandle<u64>>,
);

impl Busy {
    fn start(a_processor: usize) -> Self {
        let stop = Arc::new(std::sync::atomic::AtomicBool::new(false));
        let processors = std::thread::available_parallelism().unwrap().get();
        let threads = (0..processors * a_processor).map(|_| {
            let stop = Arc::clone(&stop);
            std::thread::spawn(move || {
                let mut turns = 0_u64;
                while !stop.load(std::sync::atomic::Ordering::Relaxed) {
                    turns = std::hint::black_box(turns + 1);
                }
                turns
            })
        });
        Self(Arc::clone(&stop), threads.collect())
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.store(true, std::sync::atomic::Ordering::Relaxed);
        for thread in self.1.drain(..) {
            thread.join().unwrap();
        }
    }
}

/// Views stood still for 9 to 15 s once one of them had been slow.
#[test]
fn views_keep_coming_while_every_processor_is_busy() {
    const WATCHED: Duration = Duration::from_secs(12);
    /// A second, and room for the scheduler of a system that shares its processors with other tests.
    const LONGEST: Duration = Duration::from_secs(3);
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 2);
    let endless = json!({
        "base": {
            "arena": { "from": "easy", "tile": [4, 4] }, "robots": 300, "placement": "grid",
            "controller": { "method": "brownian" }, "epochs": 1_000_000, "steps_per_epoch": 100,
        },
        "seeds": { "first": 1, "count": 2 },
    });
    let submitted = submit(&scheduler, &endless);
    let seqs: Vec<_> = runs(&endless)
        .iter()
        .map(|run| store.run(&run.key()).unwrap().unwrap().seq)
        .collect();
    wait_for("views", || {
        seqs.iter().all(|seq| scheduler.view(*seq).is_some())
    });
    let _busy = Busy::start(4);
    let begin = Instant::now();
    let mut last = vec![(0, begin); seqs.len()];
    let mut longest = Duration::ZERO;
    while begin.elapsed() < WATCHED {
        for (seq, (steps, at)) in seqs.iter().zip(&mut last) {
            let now = scheduler.view(*seq).unwrap().progress.robot_steps_done;
            longest = longest.max(at.elapsed());
            if now > *steps {
                (*steps, *at) = (now, Instant::now());
            }
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    eprintln!("greatest gap between two views: {longest:?}");
    assert!(longest < LONGEST, "{longest:?} between two views");
    scheduler.set_intent(submitted, Intent::Cancelled).unwrap();
}

#[test]
fn a_job_ends_with_the_results_of_its_runs_alone() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 2);
    let small = job(4, 3);
    wait_until_done(&store, submit(&scheduler, &small));
    for run in runs(&small) {
        assert_eq!(digest(&store, &run), digest_alone(&run));
        let view = store.run(&run.key()).unwrap().unwrap();
        let findings = store.findings(view.seq).unwrap().unwrap();
        assert_eq!(findings.curve.len(), 4);
        assert_eq!(findings.visits.len(), 10_000);
        assert!(store.checkpoints().read(&run.key()).unwrap().is_none());
    }
}

#[test]
fn a_run_stopped_again_and_again_ends_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let long = job(12_000, 1);
    let run = runs(&long).remove(0);
    let (mut store, mut scheduler) = start(dir.path(), 1);
    let job = submit(&scheduler, &long);
    for _ in 0..3 {
        let seq = store.run(&run.key()).unwrap().unwrap().seq;
        wait_for("a view", || scheduler.view(seq).is_some());
        scheduler.set_intent(job, Intent::Paused).unwrap();
        wait_for("the worker", || scheduler.view(seq).is_none());
        let view = store.run(&run.key()).unwrap().unwrap();
        if view.state.state() == Life::Done {
            break;
        }
        assert_eq!(view.state.state(), Life::Paused);
        assert!(store.checkpoints().findings(&run.key()).unwrap().is_some());
        scheduler.set_intent(job, Intent::Active).unwrap();
        wait_for("a view", || scheduler.view(seq).is_some());
        // The end of the process, and a new one.
        drop(scheduler);
        drop(store);
        (store, scheduler) = start(dir.path(), 1);
    }
    wait_until_done(&store, job);
    assert_eq!(digest(&store, &run), digest_alone(&run));
}

#[test]
fn a_damaged_checkpoint_costs_time_but_not_the_result() {
    let dir = tempfile::tempdir().unwrap();
    let long = job(12_000, 1);
    let run = runs(&long).remove(0);
    let (store, scheduler) = start(dir.path(), 1);
    let job = submit(&scheduler, &long);
    let seq = store.run(&run.key()).unwrap().unwrap().seq;
    wait_for("a view", || scheduler.view(seq).is_some());
    scheduler.shut_down();
    drop(scheduler);
    drop(store);
    let path = dir
        .path()
        .join("checkpoints")
        .join(format!("{}.checkpoint", run.key()));
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x40;
    std::fs::write(&path, bytes).unwrap();
    let (store, _scheduler) = start(dir.path(), 1);
    wait_until_done(&store, job);
    assert_eq!(digest(&store, &run), digest_alone(&run));
}

#[test]
fn a_cancelled_job_stops_and_leaves_nothing_behind() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let endless = job(1_000_000, 2);
    let job = submit(&scheduler, &endless);
    let running = runs(&endless).remove(0);
    let seq = store.run(&running.key()).unwrap().unwrap().seq;
    wait_for("a view", || scheduler.view(seq).is_some());
    scheduler.set_intent(job, Intent::Cancelled).unwrap();
    wait_for("the worker", || scheduler.view(seq).is_none());
    let counts = store.job(job).unwrap().unwrap().counts;
    assert_eq!((counts.cancelled, counts.total), (2, 2));
    assert!(store.checkpoints().read(&running.key()).unwrap().is_none());
    // The worker is free again, and the same runs can be asked for anew.
    wait_until_done(&store, submit(&scheduler, &self::job(1, 1)));
    let again = submit(&scheduler, &endless);
    wait_for("the run", || {
        store.job(again).unwrap().unwrap().counts.running == 1
    });
    scheduler.delete(again).unwrap();
    assert!(store.job(again).unwrap().is_none());
}

#[test]
fn a_spec_that_cannot_be_run_fails_alone() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let expanded = expand(&job(1, 1), &BuiltinArenas).unwrap();
    let request = JobRequest::new(b"", None);
    let mut broken = scheduler.new_job(expanded, request).unwrap();
    broken.runs[0].id = "broken".to_owned();
    broken.runs[0].spec = "{\"arena\": \"nowhere\"}".to_owned();
    scheduler.submit(&broken).unwrap();
    wait_until_done(&store, submit(&scheduler, &job(1, 1)));
    let state = store.run("broken").unwrap().unwrap().state;
    assert!(
        matches!(&state, crate::store::RunState::Failed { reason } if reason.contains("nowhere")),
        "{state:?}"
    );
}

#[test]
fn ended_jobs_go_by_age_and_by_size_but_none_that_runs() {
    let dir = tempfile::tempdir().unwrap();
    let (store, scheduler) = start(dir.path(), 1);
    let first = submit(&scheduler, &job(1, 1));
    let second = submit(&scheduler, &job(2, 2));
    wait_until_done(&store, first);
    wait_until_done(&store, second);
    let endless = submit(&scheduler, &job(1_000_000, 2));
    let nothing = Keep::default();
    assert!(!nothing.is_limited());
    assert_eq!(scheduler.retain(&nothing).unwrap(), []);
    let ended = store.ended_jobs().unwrap();
    assert_eq!(ended.len(), 2);
    assert!(ended[0].bytes > 10_000 && ended[1].bytes > ended[0].bytes);
    let days = |days| Keep {
        days: Some(days),
        bytes: None,
    };
    assert_eq!(scheduler.retain(&days(1)).unwrap(), []);
    let bytes = Keep {
        days: None,
        bytes: Some(ended[1].bytes),
    };
    assert_eq!(scheduler.retain(&bytes).unwrap(), [first]);
    assert_eq!(scheduler.retain(&days(0)).unwrap(), [second]);
    assert_eq!(scheduler.retain(&days(0)).unwrap(), []);
    let left = store.jobs(None, 10).unwrap();
    assert_eq!((left.len(), left[0].seq), (1, endless));
    // One that was cancelled has ended too.
    scheduler.set_intent(endless, Intent::Cancelled).unwrap();
    assert_eq!(scheduler.retain(&days(0)).unwrap(), [endless]);
}
