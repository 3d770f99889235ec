//! The report's sections of words and numbers: coverage tables, claims, settings.

use super::claims::{ALPHA, Claim, Claims, Test, Verdict};
use super::document::{Block, Table};
use super::plan::Plan;
use super::published::{Published, published};
use super::results::{Finding, Findings};
use crate::documents::CHAPTER_5_METHODS;
use crate::statistics::{Summary, summary};

/// Epochs and runs of the thesis.
const THESIS: (u32, u32) = (2_000, 15);

fn paragraph(text: impl Into<String>) -> Block {
    Block::Paragraph(text.into())
}

/// Title, what was run, and how far the runs can carry.
pub fn opening(plan: &Plan, claims: &Claims) -> Vec<Block> {
    let settings = &plan.settings;
    let (epochs, seeds) = (settings.epochs, settings.seeds);
    let mut blocks = vec![
        Block::Heading(1, "Ev-ITER: the experiments of chapter 5 again".to_owned()),
        paragraph(format!(
            "{} methods on {}, {seeds} independent runs each, {epochs} epochs of {} steps. \
             Evolution and phase 1 happen in the arena easy; visits count in the arena named. \
             p1, p2, p5 and p10 are the squares of a 100 x 100 grid that the robot's centre \
             entered at least 1, 2, 5 and 10 times over the whole run. The thesis prints its \
             arenas as pictures only; those here are drawn to its description, so that order and \
             size of differences are to be compared, not absolute counts.",
            CHAPTER_5_METHODS.len(),
            settings.arenas.join(", "),
            settings.steps_per_epoch
        )),
    ];
    if (epochs, seeds) != THESIS {
        blocks.push(paragraph(format!(
            "These are not the thesis's {} epochs and {} runs: figures and verdicts are a rehearsal.",
            THESIS.0, THESIS.1
        )));
    }
    let least_p = least_p(seeds);
    if least_p * claims.tests as f64 >= ALPHA {
        blocks.push(paragraph(format!(
            "With {seeds} runs a side no Mann-Whitney p is below {}, which the correction for {} \
             tests raises above {ALPHA}: no verdict but inconclusive can come of these tests.",
            p_value(least_p),
            claims.tests
        )));
    }
    blocks
}

/// Smallest p of a one-sided Mann-Whitney test of `n` against `n`: one over 2n choose n.
fn least_p(n: u32) -> f64 {
    (1..=n).map(|i| f64::from(i) / f64::from(n + i)).product()
}

fn in_words(verdict: Verdict) -> String {
    match verdict {
        Verdict::NotTested => "-".to_owned(),
        verdict => verdict.name().to_owned(),
    }
}

/// One row a claim.
pub fn verdicts(claims: &Claims) -> Vec<Block> {
    let count = |claim: &Claim, verdict| {
        let tests = claim.tests.iter().filter(|test| test.verdict == verdict);
        tests.count().to_string()
    };
    let rows = claims.claims.iter().map(|claim| {
        vec![
            claim.claim.to_string(),
            claim.text.to_owned(),
            claim.verdict.name().to_owned(),
            in_words(claim.verdict_p10),
            in_words(claim.verdict_over_time),
            count(claim, Verdict::Reproduced),
            count(claim, Verdict::Inconclusive),
            count(claim, Verdict::Contradicted),
        ]
    });
    vec![
        Block::Heading(2, "Claims and verdicts".to_owned()),
        Block::Table(Table {
            caption: format!(
                "Ten claims of the thesis. A claim is reproduced if all its tests are significant \
                 at {ALPHA} after Holm's correction over all {} tests, contradicted if the \
                 opposite of one of them is, and otherwise inconclusive. Claims that compare \
                 coverage have three verdicts: at p1, the squares entered at all; at p10, those \
                 entered at least ten times; and over time, p1 averaged over the epochs. Where \
                 methods end with all squares, as on graph, p1 cannot tell them apart, and over \
                 time is what the claim means: who is everywhere sooner. The last three columns \
                 count tests of all three.",
                claims.tests
            ),
            head: words(&[
                "",
                "claim",
                "verdict",
                "at p10",
                "over time",
                "reproduced",
                "inconclusive",
                "contradicted",
            ]),
            rows: rows.collect(),
            words: 5,
        }),
    ]
}

/// Coverage as in the thesis's tables 5.3 and 5.4, ours below the published figures.
pub fn coverage(plan: &Plan, findings: &Findings) -> Vec<Block> {
    let published = published();
    let mut blocks = vec![
        Block::Heading(2, "Coverage".to_owned()),
        paragraph(format!(
            "Mean ± standard deviation (median) over runs. Published: {}; {}. {}",
            published.source, published.columns, published.left_out
        )),
    ];
    for arena in &plan.settings.arenas {
        blocks.push(Block::Table(coverage_table(
            plan, findings, &published, arena,
        )));
    }
    blocks
}

fn coverage_table(plan: &Plan, findings: &Findings, published: &Published, arena: &str) -> Table {
    let mut rows = Vec::new();
    let mut reachable = 0;
    for method in plan.methods() {
        let Some(counts) = findings.summaries(arena, method, Finding::counts) else {
            continue;
        };
        reachable = findings
            .of(arena, method)
            .next()
            .map_or(0, |run| run.result.reachable);
        let row = |first: &str, what: &str, cells: [String; 4]| {
            let mut row = vec![first.to_owned(), what.to_owned()];
            row.extend(cells);
            row
        };
        let squares = |Summary { mean, sd, median }| format!("{mean:.0} ± {sd:.0} ({median:.0})");
        let theirs = match published.row(arena, method) {
            Some(row) => row.map(|[mean, sd, median]| format!("{mean} ± {sd} ({median})")),
            None => std::array::from_fn(|_| "-".to_owned()),
        };
        rows.push(row(method, "thesis", theirs));
        rows.push(row("", "here", counts.map(squares)));
        let told = findings
            .of(arena, method)
            .all(|run| run.result.dwell.is_some());
        if let Some(by_steps) = findings
            .summaries(arena, method, Finding::dwell)
            .filter(|_| told)
        {
            rows.push(row("", "by steps", by_steps.map(squares)));
        }
        if let Some(shares) = findings.summaries(arena, method, Finding::fractions) {
            let percent = |Summary { mean, sd, median }| {
                let [mean, sd, median] = [mean, sd, median].map(|share| 100.0 * share);
                format!("{mean:.1} ± {sd:.1} ({median:.1}) %")
            };
            rows.push(row("", "of reachable", shares.map(percent)));
        }
    }
    let epochs = plan.settings.epochs;
    Table {
        caption: format!(
            "Arena {arena}: squares entered at least 1, 2, 5 and 10 times after {epochs} epochs, \
             and their share of the {reachable} squares that a robot of this size can reach. By \
             steps: squares in which at least so many steps were spent, the other reading of a \
             visit. A number after a colon: epochs of phase 1 instead of 200."
        ),
        head: words(&["method", "", "p1", "p2", "p5", "p10"]),
        rows,
        words: 2,
    }
}

/// How soon each method has been nearly everywhere: tells methods apart where all end there.
pub fn time_to_coverage(plan: &Plan, findings: &Findings) -> Vec<Block> {
    const SHARES: [(&str, f64); 2] = [("t50", 0.5), ("t90", 0.9)];
    let arenas = &plan.settings.arenas;
    let mut head = words(&["method"]);
    for arena in arenas {
        head.extend(SHARES.map(|(name, _)| format!("{arena}, {name}")));
        head.push(format!("{arena}, p1 over time"));
    }
    let row = |method: &&str| {
        let mut row = vec![(*method).to_owned()];
        for arena in arenas {
            for (_, share) in SHARES {
                let mut epochs: Vec<Option<usize>> = findings
                    .of(arena, method)
                    .map(|run| run.epochs_to(share))
                    .collect();
                row.push(median_time(&mut epochs));
            }
            let squares = findings.values(arena, method, Finding::p1_over_time);
            row.push(if squares.is_empty() {
                "-".to_owned()
            } else {
                let Summary { mean, sd, .. } = summary(&squares);
                format!("{mean:.0} ± {sd:.0}")
            });
        }
        row
    };
    vec![
        Block::Heading(2, "Time to coverage".to_owned()),
        Block::Table(Table {
            caption: format!(
                "Epochs until {} % (t50) and {} % (t90) of the reachable squares had been entered: \
                 median over runs (the upper of two), and how many runs got there; p1 averaged \
                 over the epochs, mean ± standard deviation. Where all methods end with all \
                 squares, p1 no longer tells them apart, and this does.",
                100.0 * SHARES[0].1,
                100.0 * SHARES[1].1
            ),
            head,
            rows: plan.methods().iter().map(row).collect(),
            words: 1,
        }),
    ]
}

/// The median of times, of which those that never came are the longest, and how many came.
fn median_time(epochs: &mut [Option<usize>]) -> String {
    epochs.sort_by_key(|epoch| epoch.unwrap_or(usize::MAX));
    let Some(median) = epochs.get(epochs.len() / 2) else {
        return "-".to_owned();
    };
    let median = median.map_or_else(|| "never".to_owned(), |epoch| epoch.to_string());
    let there = epochs.iter().flatten().count();
    format!("{median} ({there} of {})", epochs.len())
}

/// How well each method knows its arena in the end (section 4.3.4).
pub fn model_accuracy(plan: &Plan, findings: &Findings) -> Vec<Block> {
    let mut head = words(&["method"]);
    head.extend(plan.settings.arenas.iter().cloned());
    let row = |method: &&str| {
        let cells: Vec<String> = plan
            .settings
            .arenas
            .iter()
            .map(|arena| {
                let values = findings.divergence_a_pair(arena, method);
                if values.is_empty() {
                    return "-".to_owned();
                }
                let Summary { mean, sd, median } = summary(&values);
                format!("{mean:.3} ± {sd:.3} ({median:.3})")
            })
            .collect();
        let known = cells.iter().any(|cell| cell != "-");
        known.then(|| [vec![(*method).to_owned()], cells].concat())
    };
    let rows = plan.methods().iter().filter_map(row).collect();
    vec![
        Block::Heading(2, "Accuracy of the transition models".to_owned()),
        Block::Table(Table {
            caption: "Kullback-Leibler divergence of the final transition table from a reference, \
                      in nats a pair of state and action that the table knows: mean ± standard \
                      deviation (median) over runs, smaller is better. The reference has the same \
                      states and actions, and counts 200,000 steps (no more than the run itself \
                      counts) of uniformly random actions in the target arena (0.5 added to each \
                      count). The thesis defines the measure \
                      in section 4.3.4 and publishes no figures of it."
                .to_owned(),
            head,
            rows,
            words: 1,
        }),
    ]
}

/// Every test of every claim.
pub fn test_tables(claims: &Claims) -> Vec<Block> {
    let mut blocks = vec![
        Block::Heading(2, "Tests".to_owned()),
        paragraph(
            "Mann-Whitney tests are one-sided and exact up to 100 values (ties included). A is \
             Vargha and Delaney's: the probability that a run of the first sample is above one of \
             the second, 0.5 without a difference. The difference is that of the medians. p \
             opposite is that of the opposite hypothesis, corrected over all opposites. Runs of \
             one seed share phase 1 between arenas, which the tests of claim 2 between arenas \
             leave out of account.",
        ),
    ];
    for claim in &claims.claims {
        blocks.push(Block::Heading(
            3,
            match (claim.verdict_p10, claim.verdict_over_time) {
                (Verdict::NotTested, Verdict::NotTested) => {
                    format!("Claim {}: {}", claim.claim, claim.verdict.name())
                }
                (at_p10, over_time) => format!(
                    "Claim {}: {}; at p10 {}; over time {}",
                    claim.claim,
                    claim.verdict.name(),
                    at_p10.name(),
                    over_time.name()
                ),
            },
        ));
        let reason = claim
            .reason
            .as_ref()
            .map_or(String::new(), |reason| format!(" Left out: {reason}."));
        blocks.push(paragraph(format!("{}. {}{reason}", claim.text, claim.how)));
        if claim.tests.is_empty() {
            continue;
        }
        blocks.push(Block::Table(Table {
            caption: captioned(&claim.tests),
            head: words(&[
                "arena",
                "hypothesis",
                "verdict",
                "n",
                "statistic",
                "p",
                "p Holm",
                "p opposite",
                "effect",
                "difference",
            ]),
            rows: claim.tests.iter().map(test_row).collect(),
            words: 3,
        }));
    }
    blocks
}

/// The kinds of tests, effects and units of a table.
fn captioned(tests: &[Test]) -> String {
    let distinct = |words: Vec<&'static str>| {
        let mut distinct: Vec<&str> = Vec::new();
        for word in words {
            if !distinct.contains(&word) {
                distinct.push(word);
            }
        }
        distinct.join(" or ")
    };
    let kinds = distinct(tests.iter().map(|test| test.test).collect());
    let effects = distinct(tests.iter().map(|test| test.effect_size).collect());
    let units = distinct(tests.iter().filter_map(|test| test.unit).collect());
    let difference = match units.as_str() {
        "" => String::new(),
        units => format!("; difference: {units}"),
    };
    format!("{kinds}; effect: {effects}{difference}.")
}

fn test_row(test: &Test) -> Vec<String> {
    let dash = || "-".to_owned();
    let n: Vec<String> = test.n.iter().map(usize::to_string).collect();
    let p = |p: Option<f64>| p.map_or_else(dash, p_value);
    let difference = test
        .median_difference
        .map_or_else(dash, |difference| match test.unit {
            Some("squares") => format!("{difference:+.0}"),
            _ => format!("{difference:+.3}"),
        });
    vec![
        test.arena.clone(),
        test.hypothesis.clone(),
        test.verdict.name().to_owned(),
        n.join(" + "),
        test.statistic.to_string(),
        p(test.p),
        p(test.p_holm),
        p(test.p_opposite_holm),
        format!("{:.2}", test.effect),
        difference,
    ]
}

/// The command, the version and the resolved spec of one run.
pub fn settings(plan: &Plan) -> Vec<Block> {
    let mut blocks = vec![
        Block::Heading(2, "Settings".to_owned()),
        paragraph(format!(
            "evswarm {}. Seeds count from 1. Every run's spec, result, curve and visits are in \
             runs/, named by its key; runs.csv has one line a run, claims.json every test. \
             timing.json alone says something of time and machine.",
            env!("CARGO_PKG_VERSION")
        )),
        Block::Listing(plan.command()),
    ];
    if !plan.base.is_empty() {
        blocks.push(paragraph("BASE.json, which every run is made over:"));
        let base = serde_json::to_string_pretty(&plan.base);
        blocks.push(Block::Listing(base.unwrap_or_default()));
    }
    let shown = plan.runs.iter().rev().find(|run| run.method == "ev-iter-c");
    if let Some(run) = shown.or(plan.runs.last()) {
        blocks.push(paragraph(format!(
            "The spec of one run with every default filled in ({} on {}, seed {}):",
            run.method,
            run.arena,
            run.spec.seed()
        )));
        blocks.push(Block::Listing(run.spec.canonical_json()));
    }
    blocks
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|&word| word.to_owned()).collect()
}

/// A probability with as many digits as are of use.
fn p_value(p: f64) -> String {
    if p < 1e-4 {
        format!("{p:.1e}")
    } else {
        format!("{p:.4}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_p_is_that_of_a_full_separation() {
        assert!((least_p(3) - 0.05).abs() < 1e-12);
        assert!((least_p(15) * 155_117_520.0 - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_run_that_never_got_there_is_the_slowest() {
        assert_eq!(median_time(&mut [None, Some(7), Some(3)]), "7 (2 of 3)");
        assert_eq!(median_time(&mut [None, Some(7)]), "never (1 of 2)");
        assert_eq!(median_time(&mut []), "-");
    }

    #[test]
    fn probabilities_are_short() {
        assert_eq!(p_value(0.05), "0.0500");
        assert_eq!(p_value(6.4e-9), "6.4e-9");
        assert_eq!(p_value(1.0), "1.0000");
    }
}
