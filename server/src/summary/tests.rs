//! Tests of summaries against figures worked out by hand.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::{ClusterCounts, Fractions, MetricValues, RunResult};
use serde_json::{Value, json};

use super::*;
use crate::documents::{Design, DesignAxis};

pub fn finished(place: u64, seed: u64, t90: Option<u64>, mean_coverage: f64) -> FinishedRun {
    FinishedRun {
        id: format!("run {place}"),
        place,
        combination: 0,
        seed,
        result: RunResult {
            schema: SCHEMA,
            p1: 10 * seed as u32,
            p2: 0,
            p5: 0,
            p10: 0,
            reachable: 100,
            fractions: Fractions::default(),
            metrics: Some(MetricValues(
                [
                    ("t90_steps".to_owned(), t90.map(Into::into)),
                    (
                        "mean_coverage".to_owned(),
                        serde_json::Number::from_f64(mean_coverage),
                    ),
                ]
                .into(),
            )),
            dwell: None,
            steps: 100,
            collisions: 25,
            clusters: ClusterCounts::default(),
            model: None,
            bytes: 0,
            memory: api::Memory::default(),
            objects: Vec::new(),
            state_sha256: String::new(),
        },
        cpu_ns_per_robot_step: Some(100.0),
    }
}

pub fn axis(paths: &[&str], values: Value) -> DesignAxis {
    DesignAxis {
        paths: paths.iter().map(|&path| path.to_owned()).collect(),
        values: serde_json::from_value(values).unwrap(),
    }
}

/// A job that has all its runs, in order.
pub fn input(seeds: usize, axes: Vec<DesignAxis>, mut finished: Vec<FinishedRun>) -> Input {
    for run in &mut finished {
        run.combination = run.place as usize / seeds;
    }
    let design = Design {
        part: None,
        seeds,
        axes,
    };
    Input {
        job_id: "1".to_owned(),
        name: "a job".to_owned(),
        counts: vec![seeds as u64; design.combinations()],
        designs: vec![design],
        runs: finished.len() as u64,
        labels: Vec::new(),
        robots: vec![1],
        finished,
        told: std::collections::BTreeMap::new(),
    }
}

#[test]
fn seeds_are_pooled_by_combination() {
    let runs = vec![
        finished(0, 1, Some(10), 0.5),
        finished(1, 2, None, 0.5),
        finished(3, 3, Some(30), 0.5),
    ];
    let input = input(2, vec![axis(&["epochs"], json!([[5], [6]]))], runs);
    let summary = summary(&input, |_| None);
    assert!(summary.scaling.is_empty() && summary.sharing.is_empty());
    let [first, second] = &summary.groups[..] else {
        panic!("{summary:?}")
    };
    assert_eq!(first.values["epochs"], json!(5));
    assert_eq!((first.runs, first.runs_done, second.runs_done), (2, 2, 1));
    let measure = |group: &api::summary::Group, name: &str| {
        let found = group.measures.iter().find(|measure| measure.name == name);
        found.unwrap().clone()
    };
    let p1 = measure(first, "p1");
    assert_eq!((p1.n, p1.mean, p1.median), (2, Some(15.0), Some(15.0)));
    assert!((p1.sd.unwrap() - 50.0_f64.sqrt()).abs() < 1e-9);
    // Two values: Student's t with one degree of freedom, 12.706 standard errors.
    let interval = p1.interval.unwrap();
    assert!((interval.high - 15.0 - 12.706 * 5.0).abs() < 0.01);
    assert_eq!((interval.level, interval.method.as_str()), (0.95, "t"));
    assert_eq!((p1.missed, p1.iqm), (None, Some(15.0)));
    let t90 = measure(first, "t90_steps");
    assert_eq!(
        (t90.n, t90.missed, t90.mean, t90.sd, t90.interval),
        (1, Some(1), Some(10.0), None, None)
    );
    assert_eq!(measure(second, "t50_steps").mean, None);
    let collisions = measure(second, "collisions_per_robot_step");
    assert_eq!(collisions.mean, Some(0.25));
    let csv = csv(&summary);
    assert_eq!(
        csv.lines().count(),
        1 + 2 * groups::known_measures().count()
    );
    let line = csv.lines().nth(1).unwrap();
    assert!(
        line.starts_with("0,\"\",1,p1,2,2,15.0,7.0710678118654755,15.0,-48.5310")
            && line.contains(",78.5310")
            && line.contains(",0.95,t,,15.0,"),
        "{line}"
    );
    assert!(
        csv.contains("t90_steps,2,1,10.0,,10.0,,,,,1,10.0,,,\n"),
        "{csv}"
    );
    assert!(markdown(&summary).contains("3 of 3 runs done"));
}

#[test]
fn parts_are_summed_up_apart() {
    let mut input = input(2, vec![axis(&["epochs"], json!([[5], [6]]))], Vec::new());
    input.designs[0].part = Some("first".to_owned());
    input.designs.push(Design {
        part: Some("second".to_owned()),
        seeds: 1,
        axes: vec![axis(&["robots"], json!([[1], [2]]))],
    });
    input.robots.push(7);
    input.labels = ["a", "b", "c", "d"].map(str::to_owned).into();
    // Places 0 to 3 are the first part's, 4 and 5 the second's.
    input.counts = vec![2, 2, 1, 1];
    let place = |(place, combination)| FinishedRun {
        combination,
        ..finished(place, place, Some(10 * (place + 1)), 0.5)
    };
    input.finished = [(1, 0), (3, 1), (4, 2), (5, 3)].map(place).into();
    let summary = summary(&input, |_| None);
    let done = summary.groups.iter().map(|group| {
        (
            group.label.as_str(),
            group.runs,
            group.runs_done,
            group.robots,
        )
    });
    assert_eq!(
        done.collect::<Vec<_>>(),
        [
            ("a", 2, 1, 1),
            ("b", 2, 1, 1),
            ("c", 1, 1, 1),
            ("d", 1, 1, 2)
        ]
    );
    assert_eq!(summary.groups[3].values["part"], json!("second"));
    assert_eq!(summary.scaling.len(), 1);
    assert_eq!(summary.scaling[0].points[1].times[1].mean_steps, Some(60.0));
}

#[test]
fn times_that_halve_with_twice_the_robots_have_exponent_one() {
    let mut runs = Vec::new();
    for (combination, steps) in [800, 400, 200].into_iter().enumerate() {
        for seed in 0..2 {
            let place = 2 * combination as u64 + seed;
            runs.push(finished(place, seed, Some(steps), 0.5));
        }
    }
    let axes = vec![axis(&["robots"], json!([[1], [2], [4]]))];
    // Two single robots: one enters nine of ten squares after 1 to 9 steps, the other the same
    // squares the other way round.
    let singles = |place: u64| {
        let forth: Vec<u64> = (2..=10).chain([0]).collect();
        let back: Vec<u64> = (2..=10).rev().chain([0]).collect();
        Some((if place == 0 { forth } else { back }, 10))
    };
    let summary = summary(&input(2, axes, runs), singles);
    let [scaling] = &summary.scaling[..] else {
        panic!("{summary:?}")
    };
    let [fit] = &scaling.fits[..] else {
        panic!("{scaling:?}")
    };
    assert!((fit.a - 800.0).abs() < 1e-6 && (fit.b - 1.0).abs() < 1e-12);
    let interval = fit.b_interval.clone().unwrap();
    let (low, high) = (interval.low, interval.high);
    assert!((low - 1.0).abs() < 1e-9 && (high - 1.0).abs() < 1e-9);
    assert_eq!((fit.n, fit.missed), (6, 0));
    let time = |point: usize| &scaling.points[point].times[1];
    assert_eq!(time(2).name, "t90_steps");
    assert_eq!(
        (time(2).speed_up, time(2).efficiency),
        (Some(4.0), Some(1.0))
    );
    let ratio = time(2).speed_up_interval.clone().unwrap();
    assert_eq!((ratio.low, ratio.high), (4.0, 4.0));
    // One alone takes nine steps to nine squares, both together five.
    assert_eq!(time(0).independent_steps, Some(9.0));
    assert_eq!(time(1).independent_steps, Some(5.0));
    assert_eq!(time(1).against_independent, Some(5.0 / 400.0));
    assert_eq!(time(2).independent_steps, None, "four of two");
}

#[test]
fn an_arena_that_grows_along_has_no_independent_robots() {
    let axes = vec![axis(
        &["robots", "arena.tile"],
        json!([[1, [1, 1]], [4, [2, 2]]]),
    )];
    let runs = vec![
        finished(0, 1, Some(100), 0.5),
        finished(1, 1, Some(200), 0.5),
    ];
    let summary = summary(&input(1, axes, runs), |_| Some((vec![1], 1)));
    let point = &summary.scaling[0].points[1];
    assert_eq!((point.robots, point.times[1].speed_up), (4, Some(0.5)));
    assert_eq!(point.times[1].independent_steps, None);
    assert_eq!(summary.scaling[0].paths, ["robots", "arena.tile"]);
    assert!(summary.scaling[0].fits[0].b < 0.0);
}

#[test]
fn sharing_is_judged_by_pairs_of_equal_seed() {
    // robots 2 and 4, modes arena and none, three seeds. At 2 robots one seed is worse.
    let gains = [[0.1, 0.2, -0.2], [0.18, 0.2, 0.22]];
    let mut runs = Vec::new();
    for (robots, gains) in gains.iter().enumerate() {
        for mode in 0..2 {
            for (seed, gain) in gains.iter().enumerate() {
                let place = (robots * 2 + mode) * 3 + seed;
                let gain = if mode == 0 { *gain } else { 0.0 };
                let alone = 0.1 * seed as f64;
                runs.push(finished(place as u64, seed as u64, None, alone + gain));
            }
        }
    }
    let axes = vec![
        axis(&["robots"], json!([[2], [4]])),
        axis(&["sharing.mode"], json!([["arena"], ["none"]])),
    ];
    let told = summary(&input(3, axes.clone(), runs.clone()), |_| None);
    let [sharing] = &told.sharing[..] else {
        panic!("{told:?}")
    };
    let [two, four] = &sharing.points[..] else {
        panic!("{sharing:?}")
    };
    assert_eq!(
        (two.robots, two.verdict.as_str()),
        (2, "no difference found")
    );
    assert_eq!((four.pairs, four.verdict.as_str()), (3, "helps"));
    assert!((four.difference.unwrap() - 0.2).abs() < 1e-12);
    assert!(
        sharing.verdict.contains("helps from 4 robots on"),
        "{}",
        sharing.verdict
    );
    assert!(markdown(&told).contains("helps from 4 robots on"));

    // Without the third seed nothing is said.
    runs.retain(|run| run.seed < 2);
    let told = summary(&input(3, axes, runs), |_| None);
    assert_eq!(told.sharing[0].points[1].verdict, "too few seeds");
    assert!(told.sharing[0].verdict.starts_with("no N"));
}

#[test]
fn runs_that_stand_out_are_listed_the_least_first() {
    let squares = [50, 52, 4, 49, 51, 50, 95, 48, 52, 50];
    let mut runs = Vec::new();
    for (place, p1) in squares.into_iter().enumerate() {
        let mut run = finished(place as u64, place as u64, None, 0.5);
        run.result.p1 = p1;
        runs.push(run);
    }
    let mut job = input(10, Vec::new(), runs);
    job.labels = vec!["all of them".to_owned()];
    let told = |is_odd| Told {
        is_odd,
        sentence: "It stood.".to_owned(),
    };
    job.told = [(2, told(true)), (4, told(false)), (5, told(true))].into();
    let odd = summary(&job, |_| None).odd_runs;
    let listed: Vec<(u64, bool, bool)> = odd
        .iter()
        .map(|run| (run.index, run.is_outlier, run.explanation.is_some()))
        .collect();
    // Place 4 was explained and is not odd; place 5 covered what the others did.
    assert_eq!(
        listed,
        [(2, true, true), (5, false, true), (6, true, false)]
    );
    assert_eq!(
        (odd[0].median_p1, odd[0].label.as_str()),
        (50.0, "all of them")
    );
    assert_eq!(odd[0].run_id, "run 2");
    // Distances from the median: 0 0 0 1 1 2 2 2 45 46, of which the median is 1.5.
    assert!((odd[0].score.unwrap() - 0.6745 * -46.0 / 1.5).abs() < 1e-12);
    let text = markdown(&summary(&job, |_| None));
    let (first, table) = (
        text.find("stand out").unwrap(),
        text.find("| group").unwrap(),
    );
    assert!(first < table && text.contains("It stood."), "{text}");
    // Of four runs it cannot be said.
    let mut few = input(4, Vec::new(), job.finished[..4].to_vec());
    few.told.clear();
    assert!(summary(&few, |_| None).odd_runs.is_empty());
}
