//! The load: clients that mix reads and writes, listeners to events (some slow), and what they see.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use http_body_util::BodyExt;
use hyper::Method;
use serde_json::json;
use tokio::sync::watch;

use super::probe::{self, Health, Progress};
use super::report::{self, Figures};
use super::tally::Tally;
use crate::client::Client;
use crate::server::Server;

/// Load on the service over HTTP, on this machine alone.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Clients that ask one request after the other.
    #[arg(long, default_values_t = [50, 250], value_delimiter = ',')]
    clients: Vec<usize>,
    /// Milliseconds that a client waits between an answer and its next request; with 0 the clients
    /// take what processor time there is.
    #[arg(long, default_value_t = 100)]
    pause_ms: u64,
    /// Listeners to a job's events; every tenth is slow.
    #[arg(long, default_value_t = 200)]
    listeners: usize,
    /// Seconds of each measurement.
    #[arg(long, default_value_t = 15)]
    seconds: u64,
    /// Threads that step runs.
    #[arg(long, default_value_t = 2)]
    threads: usize,
}

/// Measures stepping alone, then under each number of clients, and prints what was found.
pub fn run(options: &Options) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()?;
    runtime.block_on(async {
        let quiet = measure(options, 0, 0).await?;
        let mut figures = vec![quiet];
        for &clients in &options.clients {
            figures.push(measure(options, clients, options.listeners).await?);
        }
        for line in report::lines(&figures) {
            #[allow(clippy::print_stdout, reason = "the table is the program's output")]
            {
                println!("{line}");
            }
        }
        Ok(())
    })
}

/// One server, with runs on all its threads, under so many clients and listeners.
async fn measure(options: &Options, clients: usize, listeners: usize) -> Result<Figures> {
    let server = Server::start(options.threads)?;
    let address = server.address();
    prepare(address, options.threads).await?;
    let (stop, stopped) = watch::channel(false);
    let health = tokio::spawn(probe::health(address, stopped.clone()));
    let progress = tokio::spawn(probe::progress(address, LONG_JOB, stopped.clone()));
    let listening: Vec<_> = (0..listeners)
        .map(|number| tokio::spawn(listen(address, number % 10 == 0, stopped.clone())))
        .collect();
    let pause = Duration::from_millis(options.pause_ms);
    let asking: Vec<_> = (0..clients)
        .map(|number| tokio::spawn(ask(address, number, pause, stopped.clone())))
        .collect();
    let (started, cpu_s) = (Instant::now(), server.stepping_cpu_s()?);
    tokio::time::sleep(Duration::from_secs(options.seconds)).await;
    let (wall_s, cpu_s) = (
        started.elapsed().as_secs_f64(),
        server.stepping_cpu_s()? - cpu_s,
    );
    stop.send(true)?;
    let mut tally = Tally::default();
    for client in asking {
        tally.add(client.await?);
    }
    let mut events = 0;
    for listener in listening {
        events += listener.await?;
    }
    let health: Health = health.await?;
    let progress: Progress = progress.await??;
    Ok(Figures {
        clients,
        listeners,
        wall_s,
        tally,
        events,
        health,
        progress,
        stepping_cpu_s: cpu_s,
        resident_bytes: server.resident_bytes()?,
    })
}

/// The job whose runs step all along.
const LONG_JOB: u64 = 1;

/// Jobs to ask for: one that steps on every thread for as long as this lasts, and a finished one.
async fn prepare(address: SocketAddr, threads: usize) -> Result<()> {
    let mut client = Client::new(address);
    let long = json!({
        "name": "steps all along",
        "base": { "arena": "maze", "controller": { "method": "im" },
                  "epochs": 1_000_000, "steps_per_epoch": 2_000 },
        "seeds": { "first": 1, "count": threads },
        "priority": 10,
    });
    let long = match client.post("/v1/jobs", Some(long.to_string())).await? {
        answer if answer.status == 201 => answer,
        _ => {
            // A server without priorities.
            let mut plain = long;
            plain.as_object_mut().map(|job| job.remove("priority"));
            client.post("/v1/jobs", Some(plain.to_string())).await?
        }
    };
    anyhow::ensure!(long.status == 201, "the long job: {:?}", long.body);
    tokio::time::sleep(Duration::from_millis(1500)).await;
    Ok(())
}

/// A client: nine reads to a write, in a fixed order that differs from client to client.
async fn ask(
    address: SocketAddr,
    number: usize,
    pause: Duration,
    mut stop: watch::Receiver<bool>,
) -> Tally {
    let mut client = Client::new(address);
    let mut tally = Tally::default();
    let run = run_id(&mut client).await.unwrap_or_default();
    let reads = [
        "/v1/jobs?limit=20".to_owned(),
        format!("/v1/jobs/{LONG_JOB}"),
        format!("/v1/jobs/{LONG_JOB}/runs?limit=20"),
        format!("/v1/runs/{run}"),
        format!("/v1/runs/{run}/curve?points=200"),
        format!("/v1/runs/{run}/coverage.csv"),
        format!("/v1/runs/{run}/metrics.csv"),
        "/v1/controllers".to_owned(),
        format!("/v1/jobs/{LONG_JOB}/summary"),
    ];
    let mut turn = number;
    let mut own: Option<String> = None;
    while !*stop.borrow_and_update() {
        turn += 1;
        tokio::time::sleep(pause).await;
        let writes = turn.is_multiple_of(10);
        let answer = if writes {
            match own.take() {
                Some(job) => client.post(&format!("/v1/jobs/{job}/cancel"), None).await,
                None => client.post("/v1/jobs", Some(tiny(number, turn))).await,
            }
        } else {
            client.get(&reads[turn % reads.len()]).await
        };
        let Ok(answer) = answer else {
            *tally.statuses.entry(0).or_default() += 1;
            continue;
        };
        *tally.statuses.entry(answer.status.as_u16()).or_default() += 1;
        if writes {
            tally.writes.push(answer.took);
            if answer.status == 201 {
                own = answer
                    .json()
                    .ok()
                    .and_then(|job| job["id"].as_str().map(str::to_owned));
            }
        } else {
            tally.reads.push(answer.took);
        }
    }
    tally
}

async fn run_id(client: &mut Client) -> Result<String> {
    let page = client
        .get(&format!("/v1/jobs/{LONG_JOB}/runs?limit=1"))
        .await?
        .json()?;
    let id = page["items"][0]["id"].as_str().context("a run")?;
    Ok(id.to_owned())
}

/// A job of its own: one run of ten steps.
fn tiny(client: usize, turn: usize) -> String {
    json!({
        "name": format!("tiny {client} {turn}"),
        "base": { "arena": "easy", "controller": { "method": "brownian" }, "epochs": 1,
                  "steps_per_epoch": 10, "seed": client * 1_000_000 + turn },
    })
    .to_string()
}

/// Listens to the long job's events; a slow listener takes a chunk every second. Returns events seen.
async fn listen(address: SocketAddr, slow: bool, mut stop: watch::Receiver<bool>) -> u64 {
    let mut client = Client::new(address);
    let path = format!("/v1/jobs/{LONG_JOB}/events");
    let Ok(response) = client.send(Method::GET, &path, None).await else {
        return 0;
    };
    if response.status() != 200 {
        return 0;
    }
    let mut body = response.into_body();
    let mut events = 0;
    loop {
        tokio::select! {
            _ = stop.changed() => return events,
            frame = body.frame() => {
                let Some(Ok(frame)) = frame else { return events };
                let data = frame.into_data().unwrap_or_default();
                events += data.windows(2).filter(|pair| pair == b"\n\n").count() as u64;
                if slow {
                    tokio::time::sleep(Duration::from_secs(1)).await;
                }
            }
        }
    }
}
