//! `loadtests faults`: kills the service again and again while jobs of all kinds are posted and
//! changed, then compares: no acknowledged job lost, no result different from an undisturbed one's.

mod jobs;
mod ledger;
mod options;
mod rounds;

use std::time::Instant;

use anyhow::{Context, Result, ensure};

use crate::client::Client;
use crate::server::Server;
use jobs::Findings;
use ledger::Ledger;
pub use options::Options;

/// Kills, brings all to an end and compares.
pub fn run(options: &Options) -> Result<()> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .enable_all()
        .build()?;
    runtime.block_on(async {
        let started = Instant::now();
        let home = tempfile::tempdir()?;
        let mut random = fastrand::Rng::with_seed(options.seed);
        let mut ledger = Ledger::default();
        let (killed, generations) =
            rounds::all(options, home.path(), &mut random, &mut ledger).await?;
        say(&format!("{killed}; {:.0} s", started.elapsed().as_secs_f64()));

        let server = Server::start_at(home.path(), options.threads, None)?;
        let mut client = Client::new(server.address());
        ledger.check(&mut client).await?;
        let mut found = Findings::new();
        for job in ledger.jobs() {
            jobs::bring_to_end(&mut client, job).await?;
            found.append(&mut jobs::findings(&mut client, job).await?);
        }
        drop(server);
        let expected = undisturbed(options.threads, generations).await?;
        let different = found
            .iter()
            .filter(|(id, digest)| expected.get(*id) != Some(digest));
        let different: Vec<&String> = different.map(|(id, _)| id).collect();
        say(&format!(
            "{} acknowledged jobs, {} deleted by request, 0 lost; {} different runs compared, {} different; {:.0} s",
            ledger.jobs().count() as u64 + ledger.deleted(),
            ledger.deleted(),
            found.len(),
            different.len(),
            started.elapsed().as_secs_f64()
        ));
        ensure!(different.is_empty(), "different: {different:?}");
        let kills = options.kills + options.at_places;
        ensure!(found.len() as u64 > kills / 2, "too few runs were compared");
        Ok(())
    })
}

/// What all runs come to when nothing happens.
async fn undisturbed(threads: usize, generations: u64) -> Result<Findings> {
    let server = Server::start(threads)?;
    let mut client = Client::new(server.address());
    let mut found = Findings::new();
    for generation in 0..generations {
        let mut posted = Vec::new();
        for kind in 0..jobs::KINDS {
            let whole = jobs::whole(kind, generation);
            let answer = client.post("/v1/jobs", Some(whole)).await?;
            ensure!(
                answer.status == 201,
                "kind {kind}: {}",
                String::from_utf8_lossy(&answer.body)
            );
            let id = answer.json()?["id"].as_str().map(str::parse);
            posted.push(id.context("an id")??);
        }
        for job in posted {
            jobs::bring_to_end(&mut client, job).await?;
            found.append(&mut jobs::findings(&mut client, job).await?);
        }
    }
    Ok(found)
}

#[allow(clippy::print_stdout, reason = "what is found is the program's output")]
fn say(line: &str) {
    println!("{line}");
}
