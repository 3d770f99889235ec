//! What the runs found, read from the store.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use anyhow::{Context, bail};
use api::RunResult;
use swarm::spec::EngineKind;

use super::plan::{Plan, PlannedRun};
use crate::statistics::{Summary, summary};
use crate::store::{RunState, Store};

/// One finished run.
#[derive(Clone, Debug)]
pub struct Finding {
    pub arena: String,
    pub method: String,
    pub engine: EngineKind,
    pub seed: u64,
    pub result: RunResult,
    /// p1 after each epoch.
    pub p1_by_epoch: Vec<f64>,
    /// Entries counted a square, row 0 the lowest y.
    pub visits: Vec<u32>,
}

/// All finished runs, in the order of the plan.
#[derive(Clone, Debug)]
pub struct Findings(pub Vec<Finding>);

impl Finding {
    /// p1, p2, p5 and p10, squares.
    pub fn counts(&self) -> [f64; 4] {
        let RunResult {
            p1, p2, p5, p10, ..
        } = self.result;
        [p1, p2, p5, p10].map(f64::from)
    }

    /// Squares in which at least 1, 2, 5 and 10 steps were spent; none for older results.
    pub fn dwell(&self) -> [f64; 4] {
        let levels = self.result.dwell.unwrap_or_default();
        [levels.p1, levels.p2, levels.p5, levels.p10].map(f64::from)
    }

    /// Counted epochs until a share of the reachable squares had been entered, by p1 after each
    /// epoch; `None` where it never was.
    pub fn epochs_to(&self, share: f64) -> Option<usize> {
        let needed = share * f64::from(self.result.reachable);
        let reached = self.p1_by_epoch.iter().position(|&p1| p1 >= needed)?;
        Some(reached + 1)
    }

    /// p1 after each epoch, averaged over the epochs; 0 without epochs.
    pub fn p1_over_time(&self) -> f64 {
        let epochs = self.p1_by_epoch.len().max(1) as f64;
        self.p1_by_epoch.iter().sum::<f64>() / epochs
    }

    /// p1 to p10 as shares of the reachable squares.
    pub fn fractions(&self) -> [f64; 4] {
        let shares = self.result.fractions;
        [shares.p1, shares.p2, shares.p5, shares.p10]
    }

    /// Divergence of its model in nats a pair that the model knows; `None` without a model.
    fn divergence_a_pair(&self) -> Option<f64> {
        let model = self.result.model.filter(|model| model.pairs > 0)?;
        Some(model.divergence_nats / f64::from(model.pairs))
    }
}

impl Findings {
    /// Reads every run of the plan.
    ///
    /// # Errors
    /// A run that is not there, is not finished, or cannot be read.
    pub fn read(plan: &Plan, store: &Store) -> anyhow::Result<Self> {
        let read = |run: &PlannedRun| {
            let key = run.spec.key();
            read_run(run, store, &key).with_context(|| format!("cannot use run {key}"))
        };
        plan.runs
            .iter()
            .map(read)
            .collect::<anyhow::Result<_>>()
            .map(Self)
    }

    /// Nats a pair of state and action that the transition tables of those runs are from the
    /// reference (section 4.3.4), of the runs that have a table.
    pub fn divergence_a_pair(&self, arena: &str, method: &str) -> Vec<f64> {
        self.of(arena, method)
            .filter_map(Finding::divergence_a_pair)
            .collect()
    }

    /// Runs of a method on an arena under the kinematic engine, by seed.
    pub fn of<'a>(
        &'a self,
        arena: &'a str,
        method: &'a str,
    ) -> impl Iterator<Item = &'a Finding> + Clone {
        self.under(EngineKind::Kinematic, arena, method)
    }

    /// Runs of a method on an arena under an engine, by seed.
    pub fn under<'a>(
        &'a self,
        engine: EngineKind,
        arena: &'a str,
        method: &'a str,
    ) -> impl Iterator<Item = &'a Finding> + Clone {
        self.0
            .iter()
            .filter(move |run| run.engine == engine && run.arena == arena && run.method == method)
    }

    /// A figure of each of those runs.
    pub fn values(&self, arena: &str, method: &str, figure: impl Fn(&Finding) -> f64) -> Vec<f64> {
        self.of(arena, method).map(figure).collect()
    }

    /// p1, p2, p5 and p10 over those runs; `None` without runs.
    pub fn summaries(
        &self,
        arena: &str,
        method: &str,
        figures: impl Fn(&Finding) -> [f64; 4],
    ) -> Option<[Summary; 4]> {
        let rows: Vec<[f64; 4]> = self.of(arena, method).map(figures).collect();
        let column = |place: usize| -> Vec<f64> { rows.iter().map(|row| row[place]).collect() };
        (!rows.is_empty()).then(|| std::array::from_fn(|place| summary(&column(place))))
    }

    /// `runs.csv`: one line a run, by engine, arena, method and seed.
    pub fn csv(&self) -> String {
        let mut runs: Vec<&Finding> = self.0.iter().collect();
        runs.sort_by(|one, other| {
            let engine = |run: &Finding| run.engine.name();
            (engine(one), &one.arena, &one.method, one.seed).cmp(&(
                engine(other),
                &other.arena,
                &other.method,
                other.seed,
            ))
        });
        let mut text = String::from(
            "engine,arena,method,seed,p1,p2,p5,p10,reachable,\
             p1_fraction,p2_fraction,p5_fraction,p10_fraction,\
             p1_over_time,t50_epochs,t90_epochs,\
             states,actions,model_pairs,model_divergence_nats\n",
        );
        for run in runs {
            let [p1, p2, p5, p10] = run.counts();
            let [f1, f2, f5, f10] = run.fractions();
            let clusters = &run.result.clusters;
            let epochs_to = |share| match run.epochs_to(share) {
                Some(epochs) => epochs.to_string(),
                None => String::new(),
            };
            let (pairs, nats) = run.result.model.map_or(Default::default(), |model| {
                (
                    model.pairs.to_string(),
                    format!("{:.6}", model.divergence_nats),
                )
            });
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{p1},{p2},{p5},{p10},{},{f1:.6},{f2:.6},{f5:.6},{f10:.6},\
                 {:.1},{},{},{},{},{pairs},{nats}",
                run.engine.name(),
                run.arena,
                run.method,
                run.seed,
                run.result.reachable,
                run.p1_over_time(),
                epochs_to(0.5),
                epochs_to(0.9),
                clusters.sensor,
                clusters.actuator
            );
        }
        text
    }
}

fn read_run(run: &PlannedRun, store: &Store, key: &str) -> anyhow::Result<Finding> {
    let stored = store.run(key)?.context("it is not stored")?;
    let findings = store.findings(stored.seq)?;
    let (RunState::Done(result), Some(findings)) = (stored.state, findings) else {
        bail!("it is not finished");
    };
    Ok(Finding {
        arena: run.arena.clone(),
        method: run.method.clone(),
        engine: run.engine,
        seed: run.spec.seed(),
        result: *result,
        p1_by_epoch: findings.curve.iter().map(|row| f64::from(row.p1)).collect(),
        visits: findings.visits,
    })
}

#[cfg(test)]
pub(super) mod testing {
    use api::Fractions;

    use super::*;

    /// A run with p1, p2, p5, p10 at its end and a curve that leads there in a straight line.
    pub fn finding(arena: &str, method: &str, seed: u64, counts: [u32; 4]) -> Finding {
        let [p1, p2, p5, p10] = counts;
        let share = |count: u32| f64::from(count) / 4_000.0;
        Finding {
            arena: arena.to_owned(),
            method: method.to_owned(),
            engine: EngineKind::Kinematic,
            seed,
            result: RunResult {
                metrics: None,
                schema: 1,
                p1,
                p2,
                p5,
                p10,
                reachable: 4_000,
                fractions: Fractions {
                    p1: share(p1),
                    p2: share(p2),
                    p5: share(p5),
                    p10: share(p10),
                },
                dwell: None,
                steps: 1,
                collisions: 0,
                clusters: api::ClusterCounts::default(),
                model: None,
                bytes: 1,
                memory: api::Memory::default(),
                objects: Vec::new(),
                state_sha256: String::new(),
            },
            p1_by_epoch: (1..=20).map(|epoch| f64::from(p1 * epoch) / 20.0).collect(),
            visits: vec![0; 10_000],
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::testing::finding;
    use super::*;

    #[test]
    fn the_table_is_sorted_and_holds_counts_and_shares() {
        let findings = Findings(vec![
            finding("maze", "im", 10, [400, 300, 200, 100]),
            finding("maze", "im", 2, [4_000, 3, 2, 1]),
            finding("easy", "im", 1, [8, 4, 2, 1]),
        ]);
        let csv = findings.csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines[0].starts_with("engine,arena,method,seed,p1,"));
        assert_eq!(
            lines[1],
            "kinematic,easy,im,1,8,4,2,1,4000,0.002000,0.001000,0.000500,0.000250,4.2,,,0,0,,"
        );
        assert!(
            lines[2].starts_with("kinematic,maze,im,2,4000,")
                && lines[3].starts_with("kinematic,maze,im,10,400,")
        );
        let [p1, ..] = findings.summaries("maze", "im", Finding::counts).unwrap();
        assert_eq!((p1.mean, p1.median), (2_200.0, 2_200.0));
        assert!(
            findings
                .summaries("maze", "brownian", Finding::counts)
                .is_none()
        );
    }
}
