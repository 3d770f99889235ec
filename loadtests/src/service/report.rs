//! What was measured, as a table: the first column is the service without any load.

use std::time::Duration;

use super::probe::{Health, Progress};
use super::tally::Tally;

/// One measurement.
#[derive(Debug)]
pub struct Figures {
    /// Clients that asked.
    pub clients: usize,
    /// Listeners to events.
    pub listeners: usize,
    /// How long it took, seconds.
    pub wall_s: f64,
    /// What requests came to.
    pub tally: Tally,
    /// Events that listeners saw.
    pub events: u64,
    /// Health, asked all along.
    pub health: Health,
    /// The runs that stepped all along.
    pub progress: Progress,
    /// Processor time of the threads that step, seconds.
    pub stepping_cpu_s: f64,
    /// Memory of the server at the end.
    pub resident_bytes: u64,
}

/// The value below which this share of the times lies, milliseconds.
fn quantile_ms(times: &[Duration], share: f64) -> f64 {
    let mut sorted = times.to_vec();
    sorted.sort_unstable();
    let place = ((sorted.len() as f64 * share).ceil() as usize).clamp(1, sorted.len().max(1));
    sorted
        .get(place - 1)
        .map_or(f64::NAN, |time| time.as_secs_f64() * 1e3)
}

/// A row of the table: what it tells, and how.
type Row<'a> = (&'a str, &'a dyn Fn(&Figures) -> String);

/// The table, a line each.
pub fn lines(figures: &[Figures]) -> Vec<String> {
    let quiet = figures.first();
    let rate = |f: &Figures| f.progress.rate();
    let rows: [Row<'_>; 16] = [
        ("listeners to events", &|f| f.listeners.to_string()),
        ("requests/s", &|f| {
            let requests: u64 = f.tally.statuses.values().sum();
            format!("{:.0}", requests as f64 / f.wall_s)
        }),
        ("reads p50, ms", &|f| {
            format!("{:.1}", quantile_ms(&f.tally.reads, 0.5))
        }),
        ("reads p99, ms", &|f| {
            format!("{:.1}", quantile_ms(&f.tally.reads, 0.99))
        }),
        ("writes p50, ms", &|f| {
            format!("{:.1}", quantile_ms(&f.tally.writes, 0.5))
        }),
        ("writes p99, ms", &|f| {
            format!("{:.1}", quantile_ms(&f.tally.writes, 0.99))
        }),
        ("no answer", &|f| {
            f.tally.statuses.get(&0).unwrap_or(&0).to_string()
        }),
        ("503", &|f| {
            f.tally.statuses.get(&503).unwrap_or(&0).to_string()
        }),
        ("other 5xx", &|f| {
            let others = f.tally.statuses.iter();
            let others = others.filter(|(status, _)| **status >= 500 && **status != 503);
            others.map(|(_, count)| count).sum::<u64>().to_string()
        }),
        ("events/s", &|f| {
            format!("{:.0}", f.events as f64 / f.wall_s)
        }),
        ("health: not 200", &|f| {
            format!(
                "{} of {}",
                f.health.failed,
                f.health.took.len() as u64 + f.health.failed
            )
        }),
        ("health: longest, ms", &|f| {
            format!("{:.1}", quantile_ms(&f.health.took, 1.0))
        }),
        ("progress stood still, s", &|f| {
            format!("{:.2}", f.progress.stood_still.as_secs_f64())
        }),
        ("robot-steps/s (of quiet)", &|f| {
            let share = quiet.map_or(f64::NAN, |quiet| rate(f) / rate(quiet));
            format!("{:.2e} ({:.0} %)", rate(f), share * 100.0)
        }),
        ("stepping CPU (of quiet)", &|f| {
            let share = quiet.map_or(f64::NAN, |quiet| {
                (f.stepping_cpu_s / f.wall_s) / (quiet.stepping_cpu_s / quiet.wall_s)
            });
            format!(
                "{:.2} cores ({:.0} %)",
                f.stepping_cpu_s / f.wall_s,
                share * 100.0
            )
        }),
        ("server's memory, MB", &|f| {
            format!("{:.0}", f.resident_bytes as f64 / 1e6)
        }),
    ];
    let head = figures
        .iter()
        .map(|f| format!("{:>22}", format!("{} clients", f.clients)));
    let mut lines = vec![format!("{:<26}{}", "", head.collect::<String>())];
    for (name, value) in rows {
        let values = figures.iter().map(|f| format!("{:>22}", value(f)));
        lines.push(format!("{name:<26}{}", values.collect::<String>()));
    }
    lines
}
