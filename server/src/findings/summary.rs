//! A job's finished runs pooled over seeds, from what is stored of them.

use std::collections::{BTreeMap, BTreeSet};

use api::JobSummary;
use api::comparison::Comparison;

use super::groups::{Groups, run_at};
use super::{Assembler, FindingsError};
use crate::documents::Design;
use crate::recording::known_explanation;
use crate::store::{JobKey, JobView, RunView};
use crate::summary::comparison::comparison;
use crate::summary::{FinishedRun, Input, Told, summary};

impl Assembler {
    /// The summary of a job as far as it is done.
    ///
    /// # Errors
    /// When the store fails, or holds of one of its runs what cannot be read.
    pub fn summary(&self, job: &JobView) -> Result<JobSummary, FindingsError> {
        let runs = self.store.all_runs(job.seq)?;
        let input = Input {
            told: self.told(&runs),
            ..self.input(job, &runs)?
        };
        let _turn = self.turn_for_runs(&runs)?;
        let mut fault = None;
        let summary = summary(&input, |place| {
            let run = run_at(&runs, place)?;
            let findings = self.store.findings(run.seq);
            let metrics = findings
                .map_err(|error| fault.get_or_insert(error))
                .ok()??
                .metrics;
            (!metrics.first_entry.is_empty()).then_some((metrics.first_entry, metrics.reachable))
        });
        fault.map_or(Ok(summary), |fault| Err(fault.into()))
    }

    /// The groups of a job against each other by a measure, as far as they are done; `by` is a
    /// varied field whose values are the groups.
    ///
    /// # Errors
    /// As [`Assembler::summary`], and when it cannot be compared as was asked.
    pub fn comparison(
        &self,
        job: &JobView,
        measure: &str,
        by: Option<&str>,
    ) -> Result<Comparison, FindingsError> {
        let runs = self.store.all_runs(job.seq)?;
        Ok(comparison(&self.input(job, &runs)?, measure, by)?)
    }

    pub(super) fn input(&self, job: &JobView, runs: &[RunView]) -> Result<Input, FindingsError> {
        let seq = job.seq;
        let designs = self.designs(seq, runs)?;
        let groups = Groups::new(&designs, runs)
            .ok_or_else(|| broken(seq, "its design is not that of its runs"))?;
        let firsts = groups.firsts.iter();
        let robots = firsts.map(|first| match first.and_then(|place| runs.get(place)) {
            Some(run) => self.robots(run),
            None => Ok(0),
        });
        Ok(Input {
            job_id: seq.to_string(),
            name: job.name.clone(),
            runs: runs.len() as u64,
            robots: robots.collect::<Result<_, _>>()?,
            finished: finished(runs, &groups.of_runs),
            labels: groups.labels,
            counts: groups.counts,
            told: BTreeMap::new(),
            designs,
        })
    }

    /// What the job varies; one that was stored without is one group.
    fn designs(&self, job: JobKey, runs: &[RunView]) -> Result<Vec<Design>, FindingsError> {
        let stored = self.store.design(job)?;
        let parsed = stored.map(|text| Design::parse(&text)).transpose();
        let designs = parsed.map_err(|error| broken(job, error))?;
        // Jobs of forks were stored with none.
        Ok(designs
            .filter(|designs| !designs.is_empty())
            .unwrap_or_else(|| {
                vec![Design {
                    seeds: runs.len(),
                    ..Design::default()
                }]
            }))
    }

    /// What is known of why runs did what they did, by their places.
    fn told(&self, runs: &[RunView]) -> BTreeMap<u64, Told> {
        let recordings = self.store.recordings();
        let known: BTreeSet<String> = recordings.runs().into_iter().collect();
        let explained = runs.iter().filter(|run| known.contains(&run.id));
        explained
            .filter_map(|run| {
                let explanation = known_explanation(&recordings.of(&run.id))?.ok()?;
                let told = Told {
                    is_odd: explanation.is_odd,
                    sentence: explanation.sentence,
                };
                Some((run.ordinal, told))
            })
            .collect()
    }

    /// Robots of a run, from its stored spec.
    fn robots(&self, run: &RunView) -> Result<u32, FindingsError> {
        let why = |why: String| FindingsError::broken(format!("run {}", run.id), why);
        let text = self.spec_text(run)?;
        let spec: api::RunSpec =
            serde_json::from_str(&text).map_err(|error| why(format!("its spec: {error}")))?;
        spec.robots
            .ok_or_else(|| why("its spec does not say how many robots it has".to_owned()))
    }
}

fn finished(runs: &[RunView], combinations: &[usize]) -> Vec<FinishedRun> {
    let all = runs.iter().zip(combinations);
    let done = all.filter_map(|(run, combination)| Some((run, *combination, run.result()?)));
    done.map(|(run, combination, result)| FinishedRun {
        id: run.id.clone(),
        place: run.ordinal,
        combination,
        seed: run.seed,
        result: result.clone(),
        cpu_ns_per_robot_step: run.cpu_ns_per_robot_step,
    })
    .collect()
}

fn broken(job: JobKey, why: impl ToString) -> FindingsError {
    FindingsError::broken(format!("job {job}"), why)
}
