//! Which combination of a job's matrix each of its runs has. A run's label says it: places in the job
//! do not, once runs were deleted or the job was extended.

use std::collections::BTreeMap;

use crate::documents::Design;
use crate::store::RunView;

/// The combinations of a job, part by part, and its runs among them.
pub struct Groups {
    /// What each combination is called.
    pub labels: Vec<String>,
    /// How many runs each has.
    pub counts: Vec<u64>,
    /// Place among `runs` of a run of each part; `None` for a part that has none any more.
    pub firsts: Vec<Option<usize>>,
    /// The combination of each run.
    pub of_runs: Vec<usize>,
}

impl Groups {
    /// `None` when a run has none of the combinations.
    pub fn new(designs: &[Design], runs: &[RunView]) -> Option<Self> {
        let mut labels: Vec<String> = designs.iter().flat_map(Design::labels).collect();
        let by_label = by_label(&labels);
        let of_run = |run: &RunView| match by_label.get(run.label.as_str()) {
            Some(&Some(combination)) => Some(combination),
            _ if labels.len() == 1 => Some(0),
            // Versions before labels stored jobs in the order of their designs.
            _ => at(designs, run.ordinal),
        };
        let of_runs: Vec<usize> = runs.iter().map(of_run).collect::<Option<_>>()?;
        let mut counts = vec![0; labels.len()];
        for (run, &combination) in runs.iter().zip(&of_runs) {
            if counts[combination] == 0 {
                labels[combination].clone_from(&run.label);
            }
            counts[combination] += 1;
        }
        let mut first = 0;
        let firsts = designs.iter().map(|design| {
            let own = first..first + design.combinations();
            first = own.end;
            of_runs.iter().position(|number| own.contains(number))
        });
        Some(Self {
            firsts: firsts.collect(),
            labels,
            counts,
            of_runs,
        })
    }
}

/// The combination of each label; `None` for one that several have.
fn by_label(labels: &[String]) -> BTreeMap<String, Option<usize>> {
    let mut known = BTreeMap::new();
    for (number, label) in labels.iter().enumerate() {
        let alone = !known.contains_key(label);
        known.insert(label.clone(), alone.then_some(number));
    }
    known
}

/// The combination of the run at a place of a job that has every run of its designs, in order.
fn at(designs: &[Design], place: u64) -> Option<usize> {
    let mut place = usize::try_from(place).ok()?;
    let mut first = 0;
    for design in designs {
        let combinations = design.combinations();
        let runs = combinations.checked_mul(design.seeds)?;
        if place < runs {
            return Some(first + place / design.seeds);
        }
        place -= runs;
        first += combinations;
    }
    None
}

/// The run at a place of the job.
pub fn run_at(runs: &[RunView], place: u64) -> Option<&RunView> {
    let found = runs.binary_search_by_key(&place, |run| run.ordinal);
    found.ok().and_then(|index| runs.get(index))
}
