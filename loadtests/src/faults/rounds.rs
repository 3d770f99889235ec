//! Rounds: the service is started, asked to do this and that, and killed in the middle.

use std::fmt;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};
use fastrand::Rng;

use super::jobs;
use super::ledger::Ledger;
use super::options::Options;
use crate::client::Client;
use crate::server::Server;

/// Places where the service kills itself, and how often each is passed at most before.
const PLACES: [(&str, u64); 6] = [
    ("claimed", 4),
    ("checkpoint-rename", 2),
    ("result-stored", 4),
    ("job-part", 2),
    ("job-stored", 2),
    ("job-changed", 2),
];
/// Places in the migrations of a new database that are tried, from the first.
const MIGRATIONS: u64 = 12;
/// Longest that a place is waited for; then the service is killed where it is.
const LONGEST: Duration = Duration::from_secs(4);

/// How the service ended.
#[derive(Debug, Default)]
pub struct Killed {
    /// At a random moment.
    at_random: u64,
    /// At a place.
    at_place: u64,
    /// The place was not come to in time: at that moment.
    in_time: u64,
    /// Requests that were cut short.
    cut_short: u64,
}

impl fmt::Display for Killed {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            to,
            "killed {} times at random moments, {} times at places, {} times where a place was not \
             come to; {} requests cut short",
            self.at_random, self.at_place, self.in_time, self.cut_short
        )
    }
}

/// All rounds, in turn at random moments and at places; looks after some whether anything is lost.
/// Gives how many generations of jobs there were, too.
pub async fn all(
    options: &Options,
    home: &Path,
    random: &mut Rng,
    ledger: &mut Ledger,
) -> Result<(Killed, u64)> {
    let mut killed = Killed::default();
    let mut round = 0;
    // A place that is not come to is no kill at a place; a bound on how often that may be.
    let most = 3 * options.kills.max(options.at_places);
    while round < most && (round < options.kills || killed.at_place < options.at_places) {
        if round < options.kills {
            let server = Server::start_at(home, options.threads, None)?;
            let until = Instant::now() + Duration::from_millis(random.u64(5..900));
            ask(&server, random, ledger, until, &mut killed).await?;
            drop(server);
            killed.at_random += 1;
        }
        if killed.at_place < options.at_places {
            if round % 5 == 4 {
                in_a_migration(options, random, &mut killed).await?;
            } else {
                at_a_place(options, home, random, ledger, &mut killed).await?;
            }
        }
        if round % 10 == 9 {
            let server = Server::start_at(home, options.threads, None)?;
            ledger.check(&mut Client::new(server.address())).await?;
            ledger.next_generation();
        }
        round += 1;
    }
    Ok((killed, ledger.generation() + 1))
}

async fn at_a_place(
    options: &Options,
    home: &Path,
    random: &mut Rng,
    ledger: &mut Ledger,
    killed: &mut Killed,
) -> Result<()> {
    let (place, most) = PLACES[random.usize(0..PLACES.len())];
    let place = format!("{place}:{}", random.u64(1..=most));
    let until = Instant::now() + LONGEST;
    // It may come to the place before it listens.
    let Ok(mut server) = Server::start_at(home, options.threads, Some(&place)) else {
        killed.at_place += 1;
        return Ok(());
    };
    ask(&server, random, ledger, until, killed).await?;
    match server.has_ended()? {
        true => killed.at_place += 1,
        false => killed.in_time += 1,
    }
    Ok(())
}

/// A new data directory, killed on its way to the newest layout, opens and works.
async fn in_a_migration(options: &Options, random: &mut Rng, killed: &mut Killed) -> Result<()> {
    let home = tempfile::tempdir()?;
    let place = format!("migration:{}", random.u64(1..=MIGRATIONS));
    match Server::start_at(home.path(), options.threads, Some(&place)) {
        Err(_) => killed.at_place += 1,
        Ok(_) => killed.in_time += 1,
    }
    let server = Server::start_at(home.path(), options.threads, None)
        .with_context(|| format!("after {place}"))?;
    let mut client = Client::new(server.address());
    let posted = client.post("/v1/jobs", Some(jobs::job(0, 0, 1, 1))).await?;
    ensure!(posted.status == 201, "after {place}: {}", posted.status);
    Ok(())
}

/// Posts and changes jobs until it is time, or until the service no longer answers.
async fn ask(
    server: &Server,
    random: &mut Rng,
    ledger: &mut Ledger,
    until: Instant,
    killed: &mut Killed,
) -> Result<()> {
    let mut client = Client::new(server.address());
    while Instant::now() < until {
        let left = until.saturating_duration_since(Instant::now());
        // A request under way when the time is up is cut short by the kill.
        let mut action = Action::choose(random, ledger);
        let outcome = tokio::time::timeout(left, action.ask(&mut client)).await;
        let answered = matches!(outcome, Ok(Ok(true)));
        killed.cut_short += u64::from(!matches!(outcome, Ok(Ok(_))));
        action.enter(ledger, answered, matches!(outcome, Ok(Ok(_))));
        if matches!(outcome, Ok(Err(_))) {
            return Ok(());
        }
        tokio::time::sleep(Duration::from_millis(random.u64(0..60))).await;
    }
    Ok(())
}

/// Something that is asked of the service.
enum Action {
    /// A job of a kind, with so many runs; its number once it is known.
    Post(String, u64, Option<u64>),
    /// More seeds for a job.
    Extend(u64),
    /// A job is deleted.
    Delete(u64),
    /// A job is changed in a way that loses nothing.
    Change(u64, &'static str),
    /// The same of a run of a job.
    ChangeRun(u64, &'static str),
}

impl Action {
    fn choose(random: &mut Rng, ledger: &Ledger) -> Self {
        let known: Vec<u64> = ledger.jobs().collect();
        let job = match known.is_empty() {
            true => return Self::new_post(random, ledger.generation()),
            // Newer ones more often: older ones are mostly done.
            false => known[known.len() - 1 - random.usize(0..known.len().min(12))],
        };
        match random.u32(0..100) {
            0..30 => Self::new_post(random, ledger.generation()),
            // Seeds start at 1 or 2.
            30..38 if ledger.most_runs(job) + 2 <= jobs::SEEDS => Self::Extend(job),
            38..42 => Self::Delete(job),
            42..72 => Self::Change(
                job,
                ["pause", "resume", "cancel", "retry"][random.usize(0..4)],
            ),
            _ => Self::ChangeRun(
                job,
                ["pause", "resume", "cancel", "retry", "step"][random.usize(0..5)],
            ),
        }
    }

    fn new_post(random: &mut Rng, generation: u64) -> Self {
        let (kind, count) = (random.usize(0..jobs::KINDS), random.u64(1..4));
        // Extensions add the seeds that follow, one each.
        let first = random.u64(1..=2);
        let document = jobs::job(kind, generation, first, count);
        Self::Post(document, count, None)
    }

    /// Whether it was done; an error when it is not known.
    async fn ask(&mut self, client: &mut Client) -> Result<bool> {
        let answer = match self {
            Self::Post(document, _, number) => {
                let answer = client.post("/v1/jobs", Some(document.clone())).await?;
                ensure!(answer.status == 201, "a post: {}", answer.status);
                let id = answer.json()?["id"].as_str().map(str::parse);
                *number = Some(id.context("an id")??);
                return Ok(true);
            }
            Self::Extend(job) => {
                let path = format!("/v1/jobs/{job}/extend");
                client.post(&path, Some(r#"{"seeds": 1}"#.into())).await?
            }
            Self::Delete(job) => client.delete(&format!("/v1/jobs/{job}")).await?,
            Self::Change(job, what) => client.post(&format!("/v1/jobs/{job}/{what}"), None).await?,
            Self::ChangeRun(job, what) => {
                let runs = jobs::runs(client, *job).await?;
                let Some((id, _)) = runs.first() else {
                    return Ok(false);
                };
                let body = (*what == "step").then(|| r#"{"epochs": 2}"#.to_owned());
                client.post(&format!("/v1/runs/{id}/{what}"), body).await?
            }
        };
        let status = answer.status.as_u16();
        ensure!(status < 500, "{status}");
        Ok(status < 300)
    }

    /// Enters what is known of it.
    fn enter(self, ledger: &mut Ledger, done: bool, answered: bool) {
        match self {
            Self::Post(_, count, Some(job)) if done => ledger.posted(job, count),
            Self::Extend(job) if done || !answered => ledger.extended(job, 1, done),
            Self::Delete(job) if done || !answered => ledger.deleted_job(job, done),
            _ => {}
        }
    }
}
