//! What the service acknowledged, and so must not lose.

use std::collections::BTreeMap;

use anyhow::{Result, ensure};

use super::jobs;
use crate::client::Client;

/// A job that was acknowledged.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Fewest and most runs that it has: a request that was cut short may have been done.
    runs: (u64, u64),
    /// Whether its deletion was asked for; acknowledged or cut short.
    deletion: Deletion,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Deletion {
    Not,
    CutShort,
    Acknowledged,
}

/// All jobs that were acknowledged.
#[derive(Debug, Default)]
pub struct Ledger {
    entries: BTreeMap<u64, Entry>,
    /// Of the jobs that are posted now.
    generation: u64,
}

impl Ledger {
    /// Which jobs are posted now.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// From now on others are posted.
    pub fn next_generation(&mut self) {
        self.generation += 1;
    }

    /// A post was acknowledged.
    pub fn posted(&mut self, job: u64, runs: u64) {
        let deletion = Deletion::Not;
        let runs = (runs, runs);
        self.entries.insert(job, Entry { runs, deletion });
    }

    /// A deletion was asked for.
    pub fn deleted_job(&mut self, job: u64, acknowledged: bool) {
        if let Some(entry) = self.entries.get_mut(&job) {
            entry.deletion = match acknowledged {
                true => Deletion::Acknowledged,
                false => Deletion::CutShort,
            };
        }
    }

    /// More seeds were asked for.
    pub fn extended(&mut self, job: u64, seeds: u64, acknowledged: bool) {
        if let Some(entry) = self.entries.get_mut(&job) {
            entry.runs.1 += seeds;
            if acknowledged {
                entry.runs.0 += seeds;
            }
        }
    }

    /// Jobs that are still there, in the order of their numbers.
    pub fn jobs(&self) -> impl Iterator<Item = u64> + '_ {
        let live = |entry: &Entry| entry.deletion == Deletion::Not;
        self.entries
            .iter()
            .filter(move |(_, entry)| live(entry))
            .map(|(&job, _)| job)
    }

    /// Most runs that a job has.
    pub fn most_runs(&self, job: u64) -> u64 {
        self.entries.get(&job).map_or(0, |entry| entry.runs.1)
    }

    /// Jobs whose deletion was acknowledged, or found done.
    pub fn deleted(&self) -> u64 {
        self.entries.len() as u64 - self.jobs().count() as u64
    }

    /// Asks whether everything is there, and only that.
    pub async fn check(&mut self, client: &mut Client) -> Result<()> {
        for (&job, entry) in &mut self.entries {
            let answer = client.get(&format!("/v1/jobs/{job}")).await?;
            match (answer.status.as_u16(), entry.deletion) {
                (404, Deletion::CutShort | Deletion::Acknowledged) => {
                    entry.deletion = Deletion::Acknowledged;
                    continue;
                }
                (200, Deletion::Not) => {}
                // It was killed before it heard.
                (200, Deletion::CutShort) => entry.deletion = Deletion::Not,
                (status, deletion) => anyhow::bail!("job {job} ({deletion:?}): {status}"),
            }
            let runs = jobs::runs(client, job).await?.len() as u64;
            ensure!(
                (entry.runs.0..=entry.runs.1).contains(&runs),
                "job {job} has {runs} runs of {:?}",
                entry.runs
            );
            entry.runs = (runs, runs);
        }
        Ok(())
    }
}
