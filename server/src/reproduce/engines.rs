//! Whether the order of the methods hinges on the engine: the main comparison under both.

use schemars::JsonSchema;
use serde::Serialize;
use swarm::spec::EngineKind;

use super::document::{Block, Table};
use super::plan::Settings;
use super::results::{Finding, Findings};
use crate::documents::ENGINE_METHODS;
use crate::statistics::{compare, summary};

/// Both engines, that of all other experiments first.
const ENGINES: [EngineKind; 2] = [EngineKind::Kinematic, EngineKind::Rapier];

/// One pair of methods on one arena under both engines, over the seeds that both have.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EnginePair {
    arena: String,
    /// The method that the thesis finds better.
    better: &'static str,
    worse: &'static str,
    /// Runs of each sample.
    n: usize,
    /// What is compared: `p1` or `p10`.
    level: &'static str,
    kinematic: Side,
    rapier: Side,
    /// Whether A is above 0.5, at it or below under both.
    same_direction: bool,
}

/// The comparison under one engine.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
struct Side {
    /// Vargha and Delaney's A: probability that a run of `better` is above one of `worse`.
    a: f64,
    /// One-sided Mann-Whitney, not corrected: few seeds, no verdict.
    p: f64,
    median_difference: f64,
}

/// Seeds that both engines have: 1 to so many.
fn common_seeds(settings: &Settings) -> u32 {
    settings.rapier_seeds.min(settings.seeds)
}

const LEVELS: [&str; 2] = ["p1", "p10"];

fn level(run: &Finding, level: &str) -> f64 {
    f64::from(match level {
        "p1" => run.result.p1,
        _ => run.result.p10,
    })
}

/// A level of every run, over the seeds that were run under both engines.
fn values(
    settings: &Settings,
    findings: &Findings,
    (arena, method, engine): (&str, &str, EngineKind),
    name: &str,
) -> Vec<f64> {
    let seeds = u64::from(common_seeds(settings));
    findings
        .under(engine, arena, method)
        .filter(|run| run.seed <= seeds)
        .map(|run| level(run, name))
        .collect()
}

/// Every pair on every arena; empty without runs under rapier.
pub fn compare_engines(settings: &Settings, findings: &Findings) -> Vec<EnginePair> {
    let [one, two, three] = ENGINE_METHODS;
    let mut pairs = Vec::new();
    for arena in &settings.arenas {
        for (better, worse) in [(two, one), (one, three), (two, three)] {
            for name in LEVELS {
                let side = |engine| {
                    let x = values(settings, findings, (arena, better, engine), name);
                    let y = values(settings, findings, (arena, worse, engine), name);
                    (!x.is_empty() && !y.is_empty()).then(|| {
                        let found = compare(&x, &y);
                        let side = Side {
                            a: found.a,
                            p: found.p_greater,
                            median_difference: found.median_difference,
                        };
                        (x.len(), side)
                    })
                };
                let [kinematic, rapier] = ENGINES.map(side);
                if let (Some((_, kinematic)), Some((n, rapier))) = (kinematic, rapier) {
                    let direction = |side: Side| (side.a - 0.5).partial_cmp(&0.0);
                    pairs.push(EnginePair {
                        arena: arena.clone(),
                        better,
                        worse,
                        n,
                        level: name,
                        kinematic,
                        rapier,
                        same_direction: direction(kinematic) == direction(rapier),
                    });
                }
            }
        }
    }
    pairs
}

/// The section of the report; nothing without runs under rapier.
pub fn section(settings: &Settings, findings: &Findings, pairs: &[EnginePair]) -> Vec<Block> {
    if pairs.is_empty() {
        return Vec::new();
    }
    let seeds = common_seeds(settings);
    let same = pairs.iter().filter(|pair| pair.same_direction).count();
    let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
    vec![
        Block::Heading(2, "The same under another engine".to_owned()),
        Block::Paragraph(format!(
            "All else in this report is the kinematic engine. Here {} are repeated with rigid \
             bodies (rapier), seeds 1 to {seeds}, beside the kinematic runs of the same seeds. \
             {same} of {} comparisons point the same way under both. No verdict depends on these \
             runs.",
            ENGINE_METHODS.join(", "),
            pairs.len()
        )),
        Block::Table(Table {
            caption: format!(
                "Squares entered at least once and ten times: mean ± standard deviation over \
                 {seeds} runs."
            ),
            head: words(&[
                "arena",
                "method",
                "p1 kinematic",
                "p1 rapier",
                "p10 kinematic",
                "p10 rapier",
            ]),
            rows: coverage_rows(settings, findings),
            words: 2,
        }),
        Block::Table(Table {
            caption: "A: probability that a run of the first method is above one of the second; \
                      p: one-sided Mann-Whitney, not corrected."
                .to_owned(),
            head: words(&[
                "arena",
                "hypothesis",
                "same way",
                "A kinematic",
                "A rapier",
                "p kinematic",
                "p rapier",
            ]),
            rows: pairs.iter().map(pair_row).collect(),
            words: 3,
        }),
    ]
}

fn coverage_rows(settings: &Settings, findings: &Findings) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for arena in &settings.arenas {
        for method in ENGINE_METHODS {
            let mut row = vec![arena.clone(), method.to_owned()];
            for name in LEVELS {
                for engine in ENGINES {
                    let values = values(settings, findings, (arena, method, engine), name);
                    row.push(if values.is_empty() {
                        "-".to_owned()
                    } else {
                        let found = summary(&values);
                        format!("{:.0} ± {:.0}", found.mean, found.sd)
                    });
                }
            }
            rows.push(row);
        }
    }
    rows
}

fn pair_row(pair: &EnginePair) -> Vec<String> {
    let EnginePair {
        better,
        worse,
        level,
        kinematic,
        rapier,
        ..
    } = pair;
    vec![
        pair.arena.clone(),
        format!("{level} of {better} > {level} of {worse}"),
        if pair.same_direction { "yes" } else { "no" }.to_owned(),
        format!("{:.2}", kinematic.a),
        format!("{:.2}", rapier.a),
        format!("{:.4}", kinematic.p),
        format!("{:.4}", rapier.p),
    ]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::super::results::testing::finding;
    use super::*;

    fn settings(rapier_seeds: u32) -> Settings {
        Settings {
            seeds: 3,
            epochs: 5,
            steps_per_epoch: 20,
            arenas: vec!["easy".to_owned()],
            rapier_seeds,
        }
    }

    /// Three runs of each method under each engine; under rapier im is best.
    fn findings() -> Findings {
        let mut runs = Vec::new();
        for engine in ENGINES {
            for (place, method) in ENGINE_METHODS.into_iter().enumerate() {
                for seed in 1..=3 {
                    let base = match (engine, place) {
                        (EngineKind::Rapier, 0) => 900,
                        (_, place) => [500, 700, 300][place],
                    };
                    let p1 = base + seed as u32;
                    let run = finding("easy", method, seed, [p1, 20, 15, 10 + seed as u32]);
                    runs.push(Finding { engine, ..run });
                }
            }
        }
        Findings(runs)
    }

    #[test]
    fn a_turned_order_is_seen_and_only_common_seeds_count() {
        let pairs = compare_engines(&settings(2), &findings());
        assert_eq!(pairs.len(), 6);
        let p1 = |better, worse| {
            pairs
                .iter()
                .find(|pair| (pair.better, pair.worse, pair.level) == (better, worse, "p1"))
                .unwrap()
        };
        let turned = p1("ev-iter-c", "im");
        assert_eq!((turned.kinematic.a, turned.rapier.a), (1.0, 0.0));
        assert!(!turned.same_direction && turned.n == 2);
        assert!(p1("im", "curiosity-a").same_direction);
    }

    #[test]
    fn without_runs_under_rapier_there_is_no_section() {
        let (settings, mut findings) = (settings(0), findings());
        findings.0.retain(|run| run.engine == EngineKind::Kinematic);
        let pairs = compare_engines(&settings, &findings);
        assert!(pairs.is_empty() && section(&settings, &findings, &pairs).is_empty());
    }
}
