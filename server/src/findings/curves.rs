//! A job's coverage over epochs, pooled by group, from what is stored of its finished runs.

use api::curves::JobCurves;

use super::groups::run_at;
use super::{Assembler, FindingsError};
use crate::asked::is_given_up;
use crate::store::JobView;
use crate::summary::curves::{CurvesError, Wanted, curves};

impl Assembler {
    /// The curves of a job's groups, as far as its runs are done.
    ///
    /// # Errors
    /// When the store fails, or the groups or their curves cannot be made as was asked.
    pub fn curves(&self, job: &JobView, wanted: Wanted<'_>) -> Result<JobCurves, FindingsError> {
        let runs = self.store.all_runs(job.seq)?;
        let input = self.input(job, &runs)?;
        let _turn = self.turn_for_runs(&runs)?;
        let done = runs.iter().filter(|run| run.result().is_some());
        let epochs = done.map(|run| run.epochs_total).max().unwrap_or(0);
        let share_of = wanted.measure.strip_suffix("_fraction");
        let level = |row: &swarm::run::CurveRow| match share_of.unwrap_or(wanted.measure) {
            "p2" => row.p2,
            "p5" => row.p5,
            "p10" => row.p10,
            _ => row.p1,
        };
        let curve = |place: u64| -> Result<Vec<f64>, FindingsError> {
            if is_given_up() {
                return Err(FindingsError::GivenUp);
            }
            let run = run_at(&runs, place);
            let findings = run
                .map(|run| self.store.findings(run.seq))
                .transpose()?
                .flatten();
            let result = run.and_then(|run| run.result());
            let whole = match (share_of, result) {
                (Some(_), Some(result)) => f64::from(result.reachable.max(1)),
                _ => 1.0,
            };
            // A run that was deleted meanwhile has no curve any more.
            let curve = findings.map_or_else(Vec::new, |found| found.curve);
            Ok(curve
                .iter()
                .map(|row| f64::from(level(row)) / whole)
                .collect())
        };
        curves(&input, wanted, epochs, curve).map_err(|error| match error {
            CurvesError::Groups(error) => error.into(),
            CurvesError::Runs(runs) => FindingsError::TooManyRuns(runs),
            CurvesError::Curve(error) => error,
        })
    }
}
