//! A job's coverage over epochs, pooled by group, from what is stored of its finished runs.

use api::curves::JobCurves;

use super::{Assembler, FindingsError};
use crate::store::{JobView, StoreError};
use crate::summary::curves::{CurvesError, Wanted, curves};

impl Assembler {
    /// The curves of a job's groups, as far as its runs are done.
    ///
    /// # Errors
    /// When the store fails, or the groups or their curves cannot be made as was asked.
    pub fn curves(&self, job: &JobView, wanted: Wanted<'_>) -> Result<JobCurves, FindingsError> {
        let runs = self.store.all_runs(job.seq)?;
        let input = self.input(job, &runs)?;
        let done = runs.iter().filter(|run| run.result().is_some());
        let epochs = done.map(|run| run.epochs_total).max().unwrap_or(0);
        let level = |row: &swarm::run::CurveRow| match wanted.measure {
            "p2" => row.p2,
            "p5" => row.p5,
            "p10" => row.p10,
            _ => row.p1,
        };
        let curve = |place: u64| -> Result<Vec<u32>, StoreError> {
            let run = usize::try_from(place)
                .ok()
                .and_then(|place| runs.get(place));
            let findings = run
                .map(|run| self.store.findings(run.seq))
                .transpose()?
                .flatten();
            // A run that was deleted meanwhile has no curve any more.
            Ok(findings.map_or_else(Vec::new, |found| found.curve.iter().map(level).collect()))
        };
        curves(&input, wanted, epochs, curve).map_err(|error| match error {
            CurvesError::Groups(error) => error.into(),
            CurvesError::Runs(runs) => FindingsError::TooManyRuns(runs),
            CurvesError::Curve(error) => error.into(),
        })
    }
}
