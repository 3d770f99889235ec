//! A job's runs pooled over seeds: measures by combination, scaling over robots, and what sharing
//! changes. Formulas and rules: `docs/metrics.md`.

mod combinations;
pub mod comparison;
pub mod curves;
mod escape;
mod groups;
mod odd;
mod scaling;
mod sharing;
mod table;
#[cfg(test)]
mod tests;

use api::{JobSummary, SCHEMA};

use combinations::{Combination, alike, axis_of, combinations, values};
pub use combinations::{FinishedRun, FirstEntries, Input, Told};
pub use table::{csv, markdown};

/// The summary of a job. `first_entries` gives them for the run at a place.
pub fn summary(
    input: &Input,
    mut first_entries: impl FnMut(u64) -> Option<FirstEntries>,
) -> JobSummary {
    let mut summary = JobSummary {
        schema: SCHEMA,
        job_id: input.job_id.clone(),
        name: input.name.clone(),
        runs: input.runs,
        runs_done: input.finished.len() as u64,
        odd_runs: Vec::new(),
        groups: Vec::new(),
        scaling: Vec::new(),
        sharing: Vec::new(),
    };
    let mut first = 0;
    for (design, &robots) in input.designs.iter().zip(&input.robots) {
        let combinations = combinations(input, design, robots, first);
        let labels = input.labels.get(first..).unwrap_or_default();
        let counts = input.counts.get(first..).unwrap_or_default();
        first += combinations.len();
        let (scaling, sharing) = (
            scaling::scaling(design, &combinations, &mut first_entries),
            sharing::sharing(design, &combinations),
        );
        let odd = odd::odd_runs(labels, &combinations, |place| input.told.get(&place));
        summary.odd_runs.extend(odd);
        summary
            .groups
            .extend(groups::groups(design, labels, counts, &combinations));
        summary.scaling.extend(scaling);
        summary.sharing.extend(sharing);
    }
    summary.odd_runs = odd::in_order(summary.odd_runs);
    summary
}
