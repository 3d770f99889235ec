//! `evswarm serve`: its settings, which come from flags, else from the environment, else from a file,
//! else they have their defaults.

use std::net::SocketAddr;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::failure::Failure;
use super::token;
use super::values::{listen_address, threads};
use crate::http::ServeOptions;
use crate::recording::Limits;
use crate::scheduler::Keep;
use crate::store::DEFAULT_FINAL_BYTES;

/// Settings of the service.
#[derive(Debug, Args)]
pub struct ServeArguments {
    /// File of settings, as TOML: the names of these flags with `_` for `-`. Flags and variables
    /// come before it.
    #[arg(long, env = "EVSWARM_CONFIG", value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Address to listen on: an IP address or localhost, with a port; a port alone is one of
    /// 127.0.0.1, and port 0 takes a free one.
    #[arg(long, env = "EVSWARM_LISTEN", default_value = "127.0.0.1:8080", value_parser = listen_address)]
    listen: SocketAddr,
    /// Directory of the database, checkpoints and results.
    #[arg(long, env = "EVSWARM_DATA", default_value = "evswarm-data")]
    data: PathBuf,
    /// Threads that step runs [default: one a processor].
    #[arg(long, env = "EVSWARM_THREADS", value_parser = threads)]
    threads: Option<usize>,
    /// Most bytes that a run may hold; one that holds more fails [default: three quarters of the
    /// machine's memory over the threads].
    #[arg(long, env = "EVSWARM_RUN_MEMORY_BYTES", value_parser = clap::value_parser!(u64).range(1_000_000..))]
    run_memory_bytes: Option<u64>,
    /// File of tokens, whose lines `evswarm token` makes: clients must send one of them, or the
    /// one in the variable EVSWARM_TOKEN. Needed to listen beyond this machine.
    #[arg(long, env = "EVSWARM_TOKENS", value_name = "FILE")]
    tokens: Option<PathBuf>,
    /// Seconds that open requests have to end once the service is to stop.
    #[arg(long, env = "EVSWARM_DRAIN_S", default_value_t = 3, value_parser = clap::value_parser!(u64).range(0..=3_600))]
    drain_s: u64,
    /// Days after which a job that has ended is deleted, with what only it found [default: never].
    #[arg(long, env = "EVSWARM_KEEP_DAYS", value_parser = clap::value_parser!(u64).range(0..=36_500))]
    keep_days: Option<u64>,
    /// Most bytes that what ended jobs found takes, about; the oldest jobs are deleted first
    /// [default: no limit].
    #[arg(long, env = "EVSWARM_KEEP_BYTES")]
    keep_bytes: Option<u64>,
    /// Most bytes of last states of runs that are done, from which they can be extended or forked;
    /// 0 keeps none.
    #[arg(long, env = "EVSWARM_FINAL_STATE_BYTES", default_value_t = DEFAULT_FINAL_BYTES)]
    final_state_bytes: u64,
    /// Most bytes of all recordings together: the oldest go to make room.
    #[arg(long, env = "EVSWARM_RECORDINGS_BYTES", value_name = "BYTES", default_value_t = Limits::DEFAULT.all_bytes, value_parser = clap::value_parser!(u64).range(1_000_000..))]
    recordings_bytes: u64,
    /// Most bytes of the recordings of a job's runs: what would take more is refused.
    #[arg(long, env = "EVSWARM_JOB_RECORDINGS_BYTES", value_name = "BYTES", default_value_t = Limits::DEFAULT.job_bytes, value_parser = clap::value_parser!(u64).range(1_000_000..))]
    job_recordings_bytes: u64,
    /// Most bytes of the recordings of a run: what would take more is refused.
    #[arg(long, env = "EVSWARM_RUN_RECORDINGS_BYTES", value_name = "BYTES", default_value_t = Limits::DEFAULT.run_bytes, value_parser = clap::value_parser!(u64).range(1_000_000..))]
    run_recordings_bytes: u64,
    /// Keep a checkpoint of each run after every so many epochs of an arena, at most 16 a run, so
    /// that a recording made later begins near [default: none].
    #[arg(long, env = "EVSWARM_KEEP_CHECKPOINTS_EVERY", value_name = "EPOCHS")]
    keep_checkpoints_every: Option<NonZeroU32>,
}

/// Serves until it is stopped.
pub fn serve(arguments: ServeArguments) -> Result<(), Failure> {
    let ServeArguments {
        config: _,
        listen,
        data,
        threads,
        run_memory_bytes,
        tokens,
        drain_s,
        keep_days,
        keep_bytes,
        final_state_bytes,
        recordings_bytes,
        job_recordings_bytes,
        run_recordings_bytes,
        keep_checkpoints_every,
    } = arguments;
    crate::http::serve(ServeOptions {
        listen,
        data,
        threads,
        run_memory_bytes,
        token: token::of_environment(),
        tokens,
        drain: Duration::from_secs(drain_s),
        keep: Keep {
            days: keep_days,
            bytes: keep_bytes,
        },
        final_state_bytes,
        recordings: Limits {
            run_bytes: run_recordings_bytes,
            job_bytes: job_recordings_bytes,
            all_bytes: recordings_bytes,
        },
        keep_every_epochs: keep_checkpoints_every,
    })?;
    Ok(())
}
