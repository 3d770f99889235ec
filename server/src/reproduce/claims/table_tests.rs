//! Verdicts on made-up runs in which it is known what is so.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::super::judge;
use super::*;
use crate::reproduce::results::testing::finding;

const RADIUS_M: f64 = 0.037;

fn settings(arenas: &[&str]) -> Settings {
    Settings {
        seeds: 15,
        epochs: 20,
        steps_per_epoch: 2_000,
        arenas: arenas.iter().map(|&name| name.to_owned()).collect(),
        rapier_seeds: 0,
    }
}

/// Runs as the thesis has them: p1 in the order of its claims, the lead growing with the arenas.
fn as_in_the_thesis(settings: &Settings) -> Findings {
    let base = |method: &str, arena: usize| match method {
        "brownian" => 300,
        "discovery" => 1_000,
        "curiosity" => 1_200,
        "discovery-a" => 1_400,
        "curiosity-a" => 1_500,
        "im" => 3_000 - 700 * arena as u32,
        "ev-iter-c:20" => 3_000,
        "ev-iter-c:50" => 3_150,
        _ => 3_300,
    };
    let mut runs = Vec::new();
    for (place, arena) in settings.arenas.iter().enumerate() {
        for method in CHAPTER_5_METHODS
            .into_iter()
            .chain(["ev-iter-c:20", "ev-iter-c:50"])
        {
            for seed in 1..=settings.seeds {
                let p1 = base(method, place) + 3 * (seed * 7 % 15);
                let kept = if method.starts_with("ev-iter") { 9 } else { 6 };
                let p10 = p1 * kept / 10;
                let mut run = finding(arena, method, u64::from(seed), [p1, p1, p10, p10]);
                let level = |epoch: u32| if epoch < 2 { 0.6 } else { 1.0 };
                run.p1_by_epoch = (0..20).map(|epoch| level(epoch) * f64::from(p1)).collect();
                runs.push(run);
            }
        }
    }
    Findings(runs)
}

fn verdicts(settings: &Settings, findings: &Findings) -> Vec<Verdict> {
    let judged = judge(settings, findings, RADIUS_M).unwrap();
    assert_eq!(
        judged
            .claims
            .iter()
            .map(|claim| claim.claim)
            .collect::<Vec<_>>(),
        (1..=10).collect::<Vec<_>>()
    );
    judged.claims.iter().map(|claim| claim.verdict).collect()
}

#[test]
fn runs_as_in_the_thesis_reproduce_every_claim() {
    let settings = settings(&BY_DIFFICULTY);
    let found = verdicts(&settings, &as_in_the_thesis(&settings));
    assert_eq!(found, [Verdict::Reproduced; 10]);
}

#[test]
fn the_opposite_contradicts() {
    let settings = settings(&["easy", "maze"]);
    let mut findings = as_in_the_thesis(&settings);
    for run in &mut findings.0 {
        match run.method.as_str() {
            "discovery" => run.result.p1 += 900,
            "ev-iter-ca" => run.result.p1 -= 1_000,
            _ => {}
        }
    }
    let found = verdicts(&settings, &findings);
    assert_eq!(found[4], Verdict::Contradicted, "curiosity > discovery");
    assert_eq!(found[6], Verdict::Contradicted, "ev-iter-ca = ev-iter-c");
    assert_eq!(
        found[3],
        Verdict::Reproduced,
        "im > curiosity-a, discovery-a"
    );
}

#[test]
fn one_brownian_run_in_the_chamber_contradicts() {
    let settings = settings(&["maze"]);
    let mut findings = as_in_the_thesis(&settings);
    let maze = arenas::builtin("maze").unwrap();
    let far = far_chamber(&maze, RADIUS_M)
        .iter()
        .position(|&far| far)
        .unwrap();
    let brownian = findings.0.iter_mut().find(|run| run.method == "brownian");
    brownian.unwrap().visits[far] = 1;
    let judged = judge(&settings, &findings, RADIUS_M).unwrap();
    assert_eq!(judged.claims[0].verdict, Verdict::Contradicted);
    let count = judged.claims[0].tests.last().unwrap();
    assert_eq!(
        (count.statistic, count.n.as_slice()),
        (1.0, [15].as_slice())
    );
}

#[test]
fn without_the_maze_its_claim_is_not_tested() {
    let settings = settings(&["easy"]);
    let judged = judge(&settings, &as_in_the_thesis(&settings), RADIUS_M).unwrap();
    let ninth = &judged.claims[8];
    assert_eq!(ninth.verdict, Verdict::NotTested);
    assert_eq!(
        ninth.reason.as_deref(),
        Some("no runs on maze were asked for")
    );
    assert_eq!(judged.claims[4].verdict, Verdict::Reproduced);
    assert!(
        judged.claims[4]
            .reason
            .as_deref()
            .unwrap()
            .contains("graph and maze")
    );
}

#[test]
fn three_runs_decide_nothing() {
    let settings = Settings {
        seeds: 3,
        ..settings(&BY_DIFFICULTY)
    };
    let found = verdicts(&settings, &as_in_the_thesis(&settings));
    assert_eq!(found, [Verdict::Inconclusive; 10]);
}

#[test]
fn curves_are_judged_by_their_shape() {
    let straight: Vec<f64> = (1..=100).map(f64::from).collect();
    assert!(!rises(&straight) && !flattens(&straight));
    let abrupt: Vec<f64> = (1..=100).map(|epoch| f64::from(epoch.min(10))).collect();
    assert!(rises(&abrupt) && flattens(&abrupt));
    assert!(rises(&[5.0]) && flattens(&[5.0]));
    assert!(!flattens(&[]));
}
