//! `loadtests memory`: what a server holds while many short runs and many small jobs pass through
//! it. After a warm-up it has to stay as it is.

use anyhow::{Result, ensure};
use serde_json::json;

use crate::client::Client;
use crate::server::Server;

/// Looks at each kind of work.
const LOOKS: u64 = 10;

/// How much.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Short runs before the first look, which fill what the database keeps in memory (64 MiB).
    #[arg(long, default_value_t = 3_000)]
    warm: u64,
    /// Short runs, of one job each time that is looked.
    #[arg(long, default_value_t = 2_000)]
    runs: u64,
    /// Jobs of one run.
    #[arg(long, default_value_t = 7_000)]
    jobs: u64,
    /// Threads that step runs.
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Most growth from the first look to the last, in percent.
    #[arg(long, default_value_t = 10.0)]
    most_percent: f64,
}

/// Posts and waits, and prints what the server holds.
///
/// # Errors
/// When it grows by more than it may.
pub fn run(options: &Options) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    runtime.block_on(async {
        let server = Server::start(options.threads)?;
        let mut client = Client::new(server.address());
        let mut passed = Work { seeds: 1 };
        passed.post(&mut client, options.warm).await?;
        client.newest_job_is_done().await?;
        let (mut runs, mut jobs) = (Vec::new(), Vec::new());
        for _ in 0..LOOKS {
            passed.post(&mut client, options.runs / LOOKS).await?;
            client.newest_job_is_done().await?;
            runs.push(server.resident_bytes()?);
        }
        for _ in 0..LOOKS {
            for _ in 0..options.jobs / LOOKS {
                passed.post(&mut client, 1).await?;
            }
            client.newest_job_is_done().await?;
            jobs.push(server.resident_bytes()?);
        }
        let lines = [
            ("short runs", options.runs, runs),
            ("jobs", options.jobs, jobs),
        ];
        for (what, many, held) in &lines {
            say(what, *many, held);
        }
        for (what, _, held) in &lines {
            let grown = growth_percent(held);
            let most = options.most_percent;
            ensure!(grown <= most, "{what}: {grown:.1} % more, {most} may be");
        }
        Ok(())
    })
}

#[allow(clippy::print_stdout, reason = "the table is the program's output")]
fn say(what: &str, many: u64, held: &[u64]) {
    let mib: Vec<String> = held
        .iter()
        .map(|bytes| format!("{:.1}", *bytes as f64 / f64::from(1 << 20)))
        .collect();
    println!(
        "{many} {what}, MiB after each tenth: {}; from the first to the last {:+.1} %",
        mib.join(" "),
        growth_percent(held)
    );
}

/// Growth of the last look over the first.
fn growth_percent(held: &[u64]) -> f64 {
    match (held.first(), held.last()) {
        (Some(&first), Some(&last)) => (last as f64 / first as f64 - 1.0) * 100.0,
        _ => 0.0,
    }
}

/// What has been posted.
struct Work {
    seeds: u64,
}

impl Work {
    async fn post(&mut self, client: &mut Client, runs: u64) -> Result<()> {
        let job = json!({
            "base": { "arena": "easy", "controller": { "method": "brownian" },
                      "epochs": 1, "steps_per_epoch": 100 },
            "seeds": { "first": self.seeds, "count": runs },
        });
        let answer = client.post("/v1/jobs", Some(job.to_string())).await?;
        ensure!(answer.status == 201, "{:?}", answer.body);
        self.seeds += runs;
        Ok(())
    }
}
