//! Where the runs of a group of a job went, pooled from what is stored of them.

use api::SCHEMA;
use api::curves::GroupCoverage;
use arenas::Squares;

use super::groups::run_at;
use super::{Assembler, FindingsError};
use crate::asked::is_given_up;
use crate::store::JobView;
use crate::summary::comparison::{ComparisonError, DEFAULT_MEASURE, sets};
use crate::summary::curves::{MOST_GROUPS, MOST_RUNS};

impl Assembler {
    /// The coverage of a group of a job, as far as its runs are done. `by` is a varied field whose
    /// values are the groups.
    ///
    /// # Errors
    /// When the store fails, there is no such group, or its runs cannot be pooled.
    pub fn group_coverage(
        &self,
        job: &JobView,
        group: u64,
        by: Option<&str>,
    ) -> Result<GroupCoverage, FindingsError> {
        let runs = self.store.all_runs(job.seq)?;
        let input = self.input(job, &runs)?;
        let sets = sets(&input, DEFAULT_MEASURE, by, MOST_GROUPS)?;
        let groups = sets.len() as u64;
        let set = usize::try_from(group)
            .ok()
            .and_then(|place| sets.get(place));
        let set = set.ok_or(ComparisonError::Group {
            asked: group,
            groups,
        })?;
        if set.places.len() > MOST_RUNS {
            return Err(FindingsError::TooManyRuns(set.places.len()));
        }
        let _turn = self.turn_for_runs(&runs)?;
        let mut sums = Sums::default();
        for &(place, _) in &set.places {
            if is_given_up() {
                return Err(FindingsError::GivenUp);
            }
            let Some(run) = run_at(&runs, place) else {
                continue;
            };
            let Some(found) = self.store.findings(run.seq)? else {
                continue;
            };
            if sums.n == 0 {
                let squares = Squares::of(self.resolved(run)?.arena());
                sums.squares = [squares.columns(), squares.rows()];
                sums.runs = vec![0; found.visits.len()];
                sums.entries = vec![0; found.visits.len()];
            }
            if found.visits.len() != sums.runs.len() {
                return Err(ComparisonError::Squares.into());
            }
            sums.add(&found.visits);
        }
        Ok(sums.told(&input.job_id, group, groups, set.label.clone()))
    }
}

#[derive(Default)]
struct Sums {
    n: u64,
    squares: [u32; 2],
    runs: Vec<u32>,
    entries: Vec<u64>,
}

impl Sums {
    fn add(&mut self, visits: &[u32]) {
        self.n += 1;
        for ((runs, entries), &count) in self.runs.iter_mut().zip(&mut self.entries).zip(visits) {
            *runs += u32::from(count > 0);
            *entries += u64::from(count);
        }
    }

    fn told(self, job_id: &str, group: u64, groups: u64, label: String) -> GroupCoverage {
        let columns = self.squares[0].max(1) as usize;
        let n = self.n.max(1) as f64;
        let entered: u64 = self.runs.iter().map(|&runs| u64::from(runs)).sum();
        let mean = |entries: &u64| ((*entries as f64 / n) * 100.0).round() as f32 / 100.0;
        GroupCoverage {
            schema: SCHEMA,
            job_id: job_id.to_owned(),
            group,
            groups,
            label,
            n: self.n,
            squares: self.squares,
            // An arena has at most 1,000 x 1,000 squares.
            union_squares: self.runs.iter().filter(|&&runs| runs > 0).count() as u32,
            mean_squares: entered as f64 / n,
            runs: self.runs.chunks(columns).map(<[u32]>::to_vec).collect(),
            mean_entries: self
                .entries
                .chunks(columns)
                .map(|row| row.iter().map(mean).collect())
                .collect(),
        }
    }
}
