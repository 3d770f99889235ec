//! Measuring: cases take turns in chunks, so that a drift of the machine's speed meets all alike.

use anyhow::Result;
use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};
use swarm::crew::Crew;

use crate::cases::Case;

/// The figures of one case: CPU time of the stepping thread, nanoseconds a robot-step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Figure {
    /// The case.
    pub name: String,
    /// Least of all chunks.
    pub min_ns: f64,
    /// Median of all chunks.
    pub median_ns: f64,
    /// Ninth decile of all chunks.
    pub p90_ns: f64,
    /// Bytes held a robot, index of walls excluded.
    pub bytes_per_robot: Option<u64>,
    /// Peak resident memory of a process that does nothing else, where measured, bytes.
    pub peak_bytes: Option<u64>,
    /// Goal, microseconds.
    pub goal_us: Option<f64>,
    /// Stretch goal, microseconds.
    pub stretch_us: Option<f64>,
}

/// A quantile of values in ascending order.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let place = ((sorted.len() - 1) as f64 * q).round() as usize;
    sorted[place]
}

/// Measures cases in rounds; `progress` hears of every chunk done.
///
/// # Errors
/// When a case cannot be set up.
pub fn measure(
    cases: &[Case],
    rounds: usize,
    chunk_ms: f64,
    mut progress: impl FnMut(&str),
) -> Result<Vec<Figure>> {
    let (mut setups, alone) = (Vec::new(), Crew::default());
    for case in cases {
        progress(&case.name);
        let mut setup = (case.setup)()?;
        // Warms up, and finds how many steps a chunk takes.
        let mut steps = (2_000 / case.robots).max(2);
        loop {
            let start = ThreadTime::now();
            (setup.chunk)(steps, &alone);
            let ms = start.elapsed().as_secs_f64() * 1e3;
            if ms >= 0.5 * chunk_ms {
                break;
            }
            steps *= if ms < 0.1 * chunk_ms { 4 } else { 2 };
        }
        setups.push((setup, steps));
    }
    let mut figures: Vec<Vec<f64>> = vec![Vec::new(); cases.len()];
    for _ in 0..rounds {
        for (k, (setup, steps)) in setups.iter_mut().enumerate() {
            let start = ThreadTime::now();
            let robot_steps = (setup.chunk)(*steps, &alone);
            figures[k].push(start.elapsed().as_secs_f64() * 1e9 / robot_steps as f64);
            progress(&cases[k].name);
        }
    }
    Ok(cases
        .iter()
        .zip(figures)
        .zip(&setups)
        .map(|((case, mut ns), (setup, _))| {
            ns.sort_by(f64::total_cmp);
            Figure {
                name: case.name.clone(),
                min_ns: ns[0],
                median_ns: quantile(&ns, 0.5),
                p90_ns: quantile(&ns, 0.9),
                bytes_per_robot: setup.bytes_per_robot,
                peak_bytes: None,
                goal_us: case.goal_us,
                stretch_us: case.stretch_us,
            }
        })
        .collect())
}
