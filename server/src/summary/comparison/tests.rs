//! Comparisons of made-up runs, worked out by hand.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use serde_json::{Value, json};

use super::*;
use crate::summary::tests::{axis, finished, input};

/// A job of methods with a value of p1 for each seed, of a hundred reachable squares.
fn job(methods: &[(&str, &[f64])]) -> Input {
    let seeds = methods[0].1.len();
    let mut runs = Vec::new();
    for (number, (_, shares)) in methods.iter().enumerate() {
        for (seed, &share) in shares.iter().enumerate() {
            let mut run = finished((number * seeds + seed) as u64, 1 + seed as u64, None, share);
            run.result.fractions.p1 = share;
            runs.push(run);
        }
    }
    let names: Vec<Value> = methods.iter().map(|(name, _)| json!([name])).collect();
    let mut job = input(
        seeds,
        vec![axis(&["controller.method"], json!(names))],
        runs,
    );
    job.labels = methods.iter().map(|(name, _)| (*name).to_owned()).collect();
    job
}

const GOOD: [f64; 10] = [0.71, 0.74, 0.69, 0.80, 0.77, 0.72, 0.75, 0.79, 0.70, 0.73];
const POOR: [f64; 10] = [0.52, 0.57, 0.60, 0.61, 0.58, 0.55, 0.66, 0.60, 0.49, 0.62];

#[test]
fn a_clear_difference_is_said() {
    let compared = comparison(
        &job(&[("im", &POOR), ("ev-iter-c", &GOOD)]),
        DEFAULT_MEASURE,
        None,
    );
    let compared = compared.unwrap();
    let [pair] = &compared.pairs[..] else {
        panic!()
    };
    assert!(pair.paired && pair.differs && pair.n == 10);
    assert!((pair.difference.unwrap() + 0.16).abs() < 1e-9);
    // All ten differences are negative: 2 of 1,024 ways.
    assert_eq!(pair.p, Some(2.0 / 1_024.0));
    assert_eq!(pair.improvement, Some(0.0));
    assert_eq!(
        pair.sentence,
        "ev-iter-c covers more than im: +16 % of what can be reached [13, 19], n = 10 pairs, p = 0.0020"
    );
    assert_eq!((compared.best, compared.runs_needed), (Some(1), None));
    assert!(
        compared
            .verdict
            .starts_with("ev-iter-c is best: ev-iter-c covers more")
    );
    let profile = &compared.groups[1].profile;
    assert_eq!((profile[0], profile[compared.taus.len() - 1]), (1.0, 0.0));
}

#[test]
fn three_seeds_say_nothing_yet_and_how_many_would() {
    let compared = comparison(
        &job(&[("im", &POOR[..3]), ("ev-iter-c", &GOOD[..3])]),
        DEFAULT_MEASURE,
        None,
    );
    let compared = compared.unwrap();
    let pair = &compared.pairs[0];
    assert_eq!(
        (pair.p, pair.differs, compared.best),
        (Some(0.25), false, None)
    );
    assert_eq!(pair.runs_needed, Some(6));
    assert!(
        pair.sentence
            .starts_with("im against ev-iter-c: cannot be said yet: -15 % of what")
            && pair
                .sentence
                .ends_with("n = 3 pairs, p = 0.25; about 6 seeds would"),
        "{}",
        pair.sentence
    );
    assert_eq!(
        compared.verdict,
        "which is best by p1_fraction cannot be said yet: ev-iter-c leads, but is not told from im; \
         about 6 seeds would"
    );
}

#[test]
fn of_groups_with_the_same_mean_none_leads() {
    let compared = comparison(
        &job(&[("a", &GOOD[..3]), ("b", &POOR[..3]), ("c", &GOOD[..3])]),
        DEFAULT_MEASURE,
        None,
    );
    let compared = compared.unwrap();
    assert_eq!(compared.best, None);
    let said = "which is best by p1_fraction cannot be said yet: a and c have the same mean; ";
    assert!(compared.verdict.starts_with(said), "{}", compared.verdict);
}

#[test]
fn turning_groups_about_turns_every_sign_and_no_verdict() {
    let jobs = [
        job(&[("a", &GOOD), ("b", &POOR)]),
        job(&[("b", &POOR), ("a", &GOOD)]),
    ];
    let [one, other] = jobs.map(|job| comparison(&job, DEFAULT_MEASURE, None).unwrap());
    let (pair, turned) = (&one.pairs[0], &other.pairs[0]);
    assert_eq!(
        pair.difference,
        turned.difference.map(|difference| -difference)
    );
    assert_eq!((pair.p, pair.p_holm), (turned.p, turned.p_holm));
    assert_eq!(
        pair.improvement,
        turned.improvement.map(|share| 1.0 - share)
    );
    assert_eq!(pair.sentence, turned.sentence);
    assert_eq!((one.best, other.best), (Some(0), Some(1)));
    assert_eq!(one.verdict, other.verdict);
}

#[test]
fn all_pairs_are_corrected_together() {
    let middle: Vec<f64> = POOR.iter().map(|share| share + 0.001).collect();
    let compared = comparison(
        &job(&[("a", &POOR), ("b", &middle), ("c", &GOOD)]),
        DEFAULT_MEASURE,
        None,
    );
    let compared = compared.unwrap();
    assert_eq!(compared.pairs.len(), 3);
    for pair in &compared.pairs {
        assert!((pair.p_holm.unwrap() - 3.0 * 2.0 / 1_024.0).abs() < 1e-12 && pair.differs);
    }
    assert_eq!(compared.best, Some(2));
    assert!(
        compared.verdict.contains("each of the other 2"),
        "{}",
        compared.verdict
    );
}

#[test]
fn a_run_that_never_got_there_is_slower_than_any_that_did() {
    let mut runs = Vec::new();
    for seed in 0..8 {
        runs.push(finished(seed, seed, Some(100 + seed), 0.5));
        let late = (seed > 2).then_some(300 + seed);
        runs.push(finished(8 + seed, seed, late, 0.5));
    }
    let mut job = input(8, vec![axis(&["robots"], json!([[4], [1]]))], runs);
    job.labels = vec!["robots 4".to_owned(), "robots 1".to_owned()];
    let compared = comparison(&job, "t90_steps", None).unwrap();
    let pair = &compared.pairs[0];
    assert_eq!((pair.n, pair.missed, pair.difference), (8, 3, Some(-200.0)));
    assert_eq!(
        (pair.test.as_deref(), pair.p),
        (Some("sign test"), Some(2.0 / 256.0))
    );
    assert_eq!((pair.improvement, compared.best), (Some(1.0), Some(0)));
    assert!(
        pair.sentence
            .starts_with("robots 4 is faster than robots 1: -200 steps")
            && pair
                .sentence
                .contains("n = 8 pairs (3 with a run that never got there)"),
        "{}",
        pair.sentence
    );
    assert_eq!(compared.groups[1].missed, Some(3));
    // Within the longest time five of eight got there.
    assert_eq!(compared.groups[1].profile.last(), Some(&0.625));
}

#[test]
fn groups_are_pooled_by_a_field_and_paired_within_what_else_varies() {
    let mut runs = Vec::new();
    // On the second arena everything is 0.3 lower; the better method leads by 0.1 on both.
    for place in 0..12_u64 {
        let (arena, method, seed) = (place / 6, place / 3 % 2, place % 3);
        let mut run = finished(place, seed, None, 0.5);
        run.result.fractions.p1 =
            0.8 - 0.3 * arena as f64 - 0.1 * method as f64 + 0.01 * (seed * (1 + method)) as f64;
        runs.push(run);
    }
    let axes = vec![
        axis(&["arena"], json!([["easy"], ["maze"]])),
        axis(&["controller.method"], json!([["im"], ["brownian"]])),
    ];
    let mut job = input(3, axes, runs);
    job.labels = ["a", "b", "c", "d"].map(str::to_owned).into();
    let compared = comparison(&job, DEFAULT_MEASURE, Some("controller.method")).unwrap();
    let labels: Vec<&str> = compared
        .groups
        .iter()
        .map(|group| group.label.as_str())
        .collect();
    assert_eq!((labels, compared.groups[0].n), (vec!["im", "brownian"], 6));
    let pair = &compared.pairs[0];
    assert_eq!(pair.n, 6);
    let interval = pair.interval.clone().unwrap();
    assert!(interval.high - interval.low < 0.03, "{interval:?}");
    assert_eq!(pair.improvement, Some(1.0));
    assert_eq!(
        comparison(&job, DEFAULT_MEASURE, None).unwrap().pairs.len(),
        6
    );
    let refused = comparison(&job, DEFAULT_MEASURE, Some("robots")).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "by: the job does not vary \"robots\"; it varies arena, controller.method"
    );
    let refused = comparison(&job, "beauty", None).unwrap_err();
    assert!(
        refused
            .to_string()
            .starts_with("measure: \"beauty\" is none; it is one of p1,")
    );
}

#[test]
fn what_was_not_run_is_not_compared() {
    let none = comparison(&job(&[("a", &[]), ("b", &[])]), DEFAULT_MEASURE, None).unwrap();
    assert_eq!((none.pairs[0].p, none.best), (None, None));
    assert_eq!(none.verdict, "cannot be said yet: no run has the measure");
    let one = comparison(&job(&[("a", &GOOD)]), DEFAULT_MEASURE, None).unwrap();
    assert_eq!(one.verdict, "there is one group: nothing to compare");
    let single = comparison(&job(&[("a", &[0.5]), ("b", &[0.4])]), DEFAULT_MEASURE, None).unwrap();
    let pair = &single.pairs[0];
    assert_eq!((pair.n, &pair.interval, pair.p), (1, &None, Some(1.0)));
    assert!(
        pair.sentence.contains("at least 2 seeds"),
        "{}",
        pair.sentence
    );
    let many = vec![("x", &GOOD[..1]); MOST_GROUPS + 1];
    let refused = comparison(&job(&many), DEFAULT_MEASURE, None).unwrap_err();
    assert!(
        refused.to_string().contains("33 groups, more than 32"),
        "{refused}"
    );
}

#[test]
fn groups_with_other_seeds_are_two_samples() {
    let mut job = job(&[("a", &GOOD), ("b", &POOR)]);
    for run in &mut job.finished[10..] {
        run.seed += 100;
    }
    let pair = &comparison(&job, DEFAULT_MEASURE, None).unwrap().pairs[0];
    assert!(!pair.paired && pair.differs && pair.n == 10);
    assert_eq!(pair.test.as_deref(), Some("Mann-Whitney test"));
    assert_eq!(pair.interval.as_ref().unwrap().method, "Welch's t");
    assert!(
        pair.sentence.contains("n = 10 runs of each"),
        "{}",
        pair.sentence
    );
}

/// The shape of the JSON, and of CSV and Markdown: a change shows here.
#[test]
fn formats_are_as_they_were() {
    let compared = comparison(
        &job(&[("im", &POOR[..3]), ("ev-iter-c", &GOOD[..3])]),
        DEFAULT_MEASURE,
        None,
    );
    let mut compared = compared.unwrap();
    compared.taus.truncate(2);
    compared
        .groups
        .iter_mut()
        .for_each(|group| group.profile.truncate(2));
    // Figures to six digits: the last ones are the platform's.
    fn round(value: &mut Value) {
        match value {
            Value::Number(number) if number.is_f64() => {
                *value = json!((number.as_f64().unwrap() * 1e6).round() / 1e6);
            }
            Value::Array(items) => items.iter_mut().for_each(round),
            Value::Object(fields) => fields.values_mut().for_each(round),
            _ => {}
        }
    }
    let mut document = serde_json::to_value(&compared).unwrap();
    round(&mut document);
    let text = serde_json::to_string_pretty(&document).unwrap() + "\n";
    let snapshot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/src/summary/comparison/snapshot.json"
    );
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(snapshot, &text).unwrap();
    }
    assert_eq!(text, std::fs::read_to_string(snapshot).unwrap());
    let csv = csv(&compared);
    let columns = |line: &str| line.split(',').count();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 2);
    assert_eq!(columns(lines[0]), columns(lines[1]), "{csv}");
    let shown = markdown(&compared);
    assert!(
        shown.contains("| im        | 3 |") && shown.contains("- im against ev-iter-c"),
        "{shown}"
    );
}
