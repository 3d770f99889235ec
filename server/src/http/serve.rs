//! The service as a process: data directory, workers, listening socket, and an orderly end.

use std::io::{Read, Write};
use std::net::SocketAddr;
use std::num::{NonZeroU32, NonZeroUsize};
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use tokio::net::TcpListener;
use tokio::time::MissedTickBehavior;

use super::access::Tokens;
use super::listen::listen;
use super::router::router;
use crate::channels::{ChannelSettings, Cleaner};
use crate::memory::give_back;
use crate::recording::Limits;
use crate::runner::default_run_memory_bytes;
use crate::scheduler::{Keep, Scheduler, SchedulerConfig};
use crate::stop::Stop;
use crate::store::Store;

/// Most runs that may be unfinished.
const UNFINISHED_LIMIT: u64 = 200_000;
/// Time between two looks for jobs that are kept no longer.
const RETENTION: Duration = Duration::from_secs(60);
/// Largest file of tokens that is read.
const MAX_TOKEN_FILE_BYTES: u64 = 4 << 20;
/// Bits of a file's mode by which others than its owner may write it.
const OTHERS_WRITE: u32 = 0o022;
/// By how much threads that answer requests are nicer than those that step runs: of a processor
/// that both want they get two fifths.
const ASIDE: i32 = 2;

/// What a service is started with.
#[derive(Clone, Debug)]
pub struct ServeOptions {
    /// Address to listen on; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Directory of the database and the checkpoints.
    pub data: PathBuf,
    /// Runs stepped at a time; one a processor when not given.
    pub threads: Option<usize>,
    /// Most bytes that a run may hold; three quarters of the machine's memory over the threads when
    /// not given.
    pub run_memory_bytes: Option<u64>,
    /// Epochs of an arena after which a checkpoint of each run is kept for later recordings.
    pub keep_every_epochs: Option<NonZeroU32>,
    /// Most bytes of recordings.
    pub recordings: Limits,
    /// A token that allows everything. This or a file of them is needed to listen beyond loopback.
    pub token: Option<String>,
    /// A file of tokens, as `evswarm token` makes its lines.
    pub tokens: Option<PathBuf>,
    /// Time that open requests have to end once the service is to stop.
    pub drain: Duration,
    /// What is kept of jobs that have ended.
    pub keep: Keep,
    /// Most bytes of last states of runs that are done.
    pub final_state_bytes: u64,
}

/// Serves until SIGINT or SIGTERM, then checkpoints every run.
///
/// # Errors
/// When the address is beyond loopback without a token, when address or data directory are in use
/// or cannot be used, or when the system refuses threads.
pub fn serve(options: ServeOptions) -> anyhow::Result<()> {
    let tokens = tokens(&options)?;
    let store = Arc::new(Store::open(&options.data)?);
    store.finals().set_most_bytes(options.final_state_bytes);
    let workers = options
        .threads
        .and_then(NonZeroUsize::new)
        .or_else(|| std::thread::available_parallelism().ok())
        .unwrap_or(NonZeroUsize::MIN);
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .thread_name("http")
        .on_thread_start(step_aside)
        .enable_all()
        .build()
        .context("cannot start the runtime")?;
    let served = runtime.block_on(async {
        let listener = TcpListener::bind(options.listen)
            .await
            .with_context(|| format!("cannot listen on {}", options.listen))?;
        let address = listener.local_addr().context("cannot tell the address")?;
        let config = SchedulerConfig {
            workers,
            unfinished_limit: UNFINISHED_LIMIT,
            run_memory_bytes: options
                .run_memory_bytes
                .unwrap_or_else(|| default_run_memory_bytes(workers)),
            keep_every_epochs: options.keep_every_epochs,
            recordings: options.recordings,
            channels: ChannelSettings::default(),
        };
        let _cleaner = Cleaner::start(config.channels.root.clone());
        let scheduler = Arc::new(Scheduler::start(Arc::clone(&store), config)?);
        let stop = Stop::on_signals(1)?;
        let routes = router(store, Arc::clone(&scheduler), tokens);
        tokio::spawn(give_back());
        if options.keep.is_limited() {
            tokio::spawn(retain(Arc::clone(&scheduler), options.keep));
        }
        announce(address);
        // Runs are let go of at once, not when the last request has ended.
        let parked = tokio::spawn({
            let asked = stop.clone().asked();
            async move {
                asked.await;
                tokio::task::spawn_blocking(move || scheduler.shut_down()).await
            }
        });
        let runs = workers.get();
        run((listener, routes), runs, stop.asked(), options.drain).await;
        parked
            .await
            .and_then(|parked| parked)
            .context("the workers did not end")
    });
    // Nobody waits for the answers that blocking threads may still be working on.
    runtime.shutdown_timeout(Duration::ZERO);
    served
}

/// Has the present thread wait a little for those that step runs: many clients cost runs less, and
/// an answer takes some milliseconds more.
fn step_aside() {
    if let Err(error) = rustix::process::nice(ASIDE) {
        tracing::warn!(%error, "threads that answer requests cannot step aside for those that step runs");
    }
}

/// The tokens of the options, which are enough for the address.
fn tokens(options: &ServeOptions) -> anyhow::Result<Tokens> {
    let mut tokens = Tokens::default();
    if let Some(path) = &options.tokens {
        let shown = path.display();
        let file = std::fs::File::open(path);
        let file = file.with_context(|| format!("cannot read the tokens in {shown}"))?;
        let mode = file.metadata().map_or(0, |of_file| of_file.mode());
        if mode & OTHERS_WRITE != 0 {
            tracing::warn!(file = %shown, mode = format!("{:o}", mode & 0o777),
                "others than its owner may write the file of tokens, and so give themselves one");
        }
        let mut text = String::new();
        let read = file.take(MAX_TOKEN_FILE_BYTES).read_to_string(&mut text);
        read.with_context(|| format!("cannot read the tokens in {shown}"))?;
        let of_file = Tokens::parse(&text);
        tokens = of_file.map_err(|error| anyhow!("cannot use the tokens in {shown}: {error}"))?;
    }
    if let Some(token) = &options.token {
        tokens = tokens.with_secret(token).map_err(anyhow::Error::msg)?;
    }
    if tokens.is_empty() && !options.listen.ip().is_loopback() {
        bail!(
            "{} can be reached from other machines: set a token with EVSWARM_TOKEN or --tokens, \
             or listen on 127.0.0.1",
            options.listen
        )
    }
    Ok(tokens)
}

/// Serves until the signal comes, and a little longer for requests that are under way.
async fn run(
    (listener, routes): (TcpListener, axum::Router),
    runs: usize,
    stop: impl Future<Output = ()> + Send + 'static,
    drain: Duration,
) {
    let (stopping, stopped) = tokio::sync::oneshot::channel::<()>();
    let server = listen(listener, routes, runs, async move {
        stop.await;
        tracing::info!("stopping: runs are checkpointed");
        #[allow(
            clippy::let_underscore_must_use,
            reason = "the receiver is gone only when the server is"
        )]
        let _ = stopping.send(());
    });
    let too_late = async {
        #[allow(
            clippy::let_underscore_must_use,
            reason = "it only fails when the sender is gone, which is as good"
        )]
        let _ = stopped.await;
        tokio::time::sleep(drain).await;
    };
    tokio::select! {
        () = server => {}
        () = too_late => tracing::warn!("requests were still open"),
    }
}

/// Deletes now and then what is kept no longer.
async fn retain(scheduler: Arc<Scheduler>, keep: Keep) {
    let mut look = tokio::time::interval(RETENTION);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        look.tick().await;
        let scheduler = Arc::clone(&scheduler);
        let done = tokio::task::spawn_blocking(move || scheduler.retain(&keep).map(drop)).await;
        match done {
            Ok(Ok(())) => {}
            Ok(Err(error)) => tracing::error!(%error, "ended jobs cannot be deleted"),
            Err(error) => tracing::error!(%error, "ended jobs cannot be deleted"),
        }
    }
}

/// Where the page is, on standard output: for people, and for programs that asked for port 0.
fn announce(address: SocketAddr) {
    #[allow(
        clippy::let_underscore_must_use,
        reason = "without a standard output there is nobody to tell"
    )]
    let _ = writeln!(std::io::stdout(), "evswarm listens on http://{address}/");
}
