//! Jobs as a user would write them: the runs that they make, and what is said of wrong ones.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use proptest::prelude::*;
use serde_json::{Value, json};

use super::testing::{any_json, refused, resolved, two_rooms};
use super::*;

pub(super) fn check_job(job: Value, pointer: &str, words: &str) {
    refused(expand(&job, &BuiltinArenas).map(drop), pointer, words);
}

#[test]
fn a_job_is_the_product_of_its_matrix_and_seeds_in_a_fixed_order() {
    let job = json!({
        "name": "first job",
        "base": { "epochs": 20 },
        "matrix": { "controller.method": ["im", "ev-iter-c"], "arena": ["maze", two_rooms()] },
        "seeds": { "first": 5, "count": 2 }
    });
    let expanded = expand(&job, &BuiltinArenas).unwrap();
    assert_eq!(expanded.name, "first job");
    let seen: Vec<_> = expanded
        .runs
        .iter()
        .map(|run| {
            (
                run.arena().name().to_owned(),
                run.method().name(),
                run.seed(),
            )
        })
        .collect();
    let mut expected = Vec::new();
    for arena in ["maze", "two-rooms"] {
        for method in ["im", "ev-iter-c"] {
            expected.extend([5, 6].map(|seed| (arena.to_owned(), method, seed)));
        }
    }
    assert_eq!(seen, expected);
    assert!(expanded.runs.iter().all(|run| run.run_spec().epochs == 20));
    assert_eq!(expanded.runs[3].run_spec().seed, 6);
    assert!(expanded.runs[3].canonical_json().contains("\"seed\": 6,"));
}

#[test]
fn a_job_of_nothing_is_one_run() {
    let runs = expand(&json!({}), &BuiltinArenas).unwrap().runs;
    assert_eq!(runs.len(), 1);
    assert_eq!(runs[0].key(), resolved(json!({})).key());
    let with_seed = expand(&json!({ "base": { "seed": 9 } }), &BuiltinArenas)
        .unwrap()
        .runs;
    assert_eq!(with_seed[0].seed(), 9);
}

#[test]
fn every_template_is_a_valid_job() {
    for template in templates() {
        let runs = expand(&template.job, &BuiltinArenas).unwrap().runs;
        assert_eq!(runs.len() as u64, template.runs, "{}", template.name);
        let job = json!({ "template": template.name, "seeds": [4] });
        let by_name = expand(&job, &BuiltinArenas).unwrap();
        assert_eq!(by_name.name, template.name);
        assert!(by_name.runs.iter().all(|run| run.seed() == 4));
    }
}

#[test]
fn wrong_jobs_are_refused_where_they_are_wrong() {
    check_job(json!(null), "", "must be an object, not null");
    check_job(json!({ "matrx": {} }), "/matrx", "did you mean \"matrix\"?");
    check_job(json!({ "name": 3 }), "/name", "must be a string");
    check_job(
        json!({ "name": "x".repeat(201) }),
        "/name",
        "201 characters",
    );
    check_job(
        json!({ "template": "chapter-6" }),
        "/template",
        "did you mean \"chapter-5\"?",
    );
    check_job(json!({ "base": [] }), "/base", "must be an object");
    check_job(
        json!({ "base": { "epochs": 0 } }),
        "/base/epochs",
        "0 is not",
    );
    check_job(
        json!({ "base": { "seed": 1 }, "seeds": [1] }),
        "/base/seed",
        "seeds of its own",
    );
    check_job(json!({ "seeds": 3 }), "/seeds", "an object or a list");
    check_job(json!({ "seeds": [] }), "/seeds", "0 seeds");
    check_job(json!({ "seeds": [1, "2"] }), "/seeds/1", "is no seed");
    check_job(json!({ "seeds": [1, 1] }), "/seeds/1", "twice");
    check_job(
        json!({ "seeds": { "count": 0 } }),
        "/seeds/count",
        "0 is not",
    );
    check_job(
        json!({ "seeds": { "first": MAX_SEED, "count": 2 } }),
        "/seeds",
        "too large",
    );
}

#[test]
fn wrong_matrices_are_refused_where_they_are_wrong() {
    let check = |matrix: Value, pointer: &str, words: &str| {
        check_job(
            json!({ "matrix": matrix }),
            &format!("/matrix{pointer}"),
            words,
        );
    };
    check(json!([]), "", "must be an object");
    check(
        json!({ "controller.alpha": 0.5 }),
        "/controller.alpha",
        "must be a list",
    );
    check(
        json!({ "controller.alpha": [] }),
        "/controller.alpha",
        "no value",
    );
    check(
        json!({ "controller..alpha": [1] }),
        "/controller..alpha",
        "no dotted path",
    );
    check(json!({ "seed": [1, 2] }), "/seed", "seeds are no axis");
    check(
        json!({ "controller.alpha": [0.5, 7] }),
        "/controller.alpha/1",
        "from 0 to 1",
    );
    check(
        json!({ "controller.alhpa": [0.5] }),
        "/controller.alhpa/0",
        "\"alpha\"?",
    );
    check(json!({ "a/b": [1] }), "/a~1b/0", "there is no field");
    check(json!({ "seed.first": [1] }), "/seed.first/0", "");
    check(
        json!({ "epochs": [5], "epochs.x": [1] }),
        "/epochs.x",
        "of a number",
    );
    check(
        json!({ "controller.alpha": [0.5, 0.50] }),
        "/controller.alpha/1",
        "already has",
    );
    check(
        json!({ "arena": ["maze", {}] }),
        "/arena/1/width_m",
        "missing",
    );
    let many: Vec<u32> = (1..=1_000).collect();
    check_job(
        json!({ "matrix": { "epochs": many, "steps_per_epoch": many } }),
        "",
        "make 1000000 runs",
    );
}

#[test]
fn robots_that_do_not_fit_are_told_with_the_most_that_do() {
    let job = |robots: &[u32], placement: &str| {
        json!({
            "base": {
                "arena": two_rooms(), "placement": placement,
                "controller": { "method": "brownian" }
            },
            "matrix": { "robots": robots, "epochs": [3, 4] }, "seeds": [7, 8]
        })
    };
    for placement in ["grid", "random"] {
        let errors = expand(&job(&[2, 9_000, 8_000], placement), &BuiltinArenas).unwrap_err();
        let pointers: Vec<&str> = errors.iter().map(|error| error.pointer.as_str()).collect();
        assert_eq!(pointers, ["/matrix/robots/1", "/matrix/robots/2"]);
        assert!(errors[0].message.contains("9000 robots do not fit"));
        let words: Vec<&str> = errors[0].allowed.split(' ').collect();
        let most: u32 = words[2].parse().unwrap();
        assert_eq!(words[..2], ["at", "most"]);
        assert!((10..100).contains(&most), "{errors:?}");
        assert!(expand(&job(&[2, most], placement), &BuiltinArenas).is_ok());
        assert!(expand(&job(&[2, most + 1], placement), &BuiltinArenas).is_err());
    }
    let hall = json!({
        "name": "hall", "width_m": 2.0, "height_m": 2.0, "walls_m": [],
        "starts": [{ "x_m": 1.0, "y_m": 1.0, "heading_rad": 0.0 }]
    });
    let trained = json!({ "base": {
        "arena": hall, "robots": 60, "placement": "grid",
        "controller": { "method": "ev-iter-c", "train": { "arena": two_rooms(), "epochs": 2 } }
    }});
    check_job(trained, "/base/robots", "(training arena)");
}

#[test]
fn runs_are_counted_without_making_them() {
    let count = |job: Value| run_count(&job);
    assert_eq!(count(json!({})), 1);
    let matrix = json!({ "epochs": [1, 2, 3], "controller.alpha": [0.5, 7] });
    let seeds = json!({ "first": 1, "count": 5 });
    assert_eq!(count(json!({ "matrix": matrix, "seeds": seeds })), 30);
    assert_eq!(count(json!({ "template": "chapter-5" })), 450 + 30 + 45);
    assert_eq!(count(json!({ "parts": [{ "seeds": [1, 2] }, {}] })), 3);
    assert_eq!(
        count(json!({ "parts": [{}, { "matrix": { "epochs": [] } }] })),
        0
    );
    assert_eq!(count(json!({ "matrix": { "epochs": [] } })), 0);
    assert_eq!(count(json!({ "seeds": { "count": 100_001 } })), 0);
}

#[test]
fn a_run_is_labelled_with_what_varies() {
    let job = json!({
        "matrix": { "controller.alpha": [0.5, 0.7], "arena": ["maze"] }, "seeds": [4, 5]
    });
    let expanded = expand(&job, &BuiltinArenas).unwrap();
    assert_eq!(
        expanded.labels,
        ["alpha 0.5", "alpha 0.5", "alpha 0.7", "alpha 0.7"]
    );
    for run in &expanded.runs {
        let text = run.canonical_json();
        let spec: api::RunSpec = serde_json::from_str(&text).unwrap();
        assert_eq!(spec, run.canonical());
        assert_eq!(
            text,
            serde_json::to_string_pretty(&spec).unwrap() + "\n",
            "seeds are put into a text that is made once"
        );
    }
    assert_eq!(expand(&json!({}), &BuiltinArenas).unwrap().labels, [""]);
}

#[test]
fn parts_are_made_one_after_the_other() {
    let brownian = json!({ "controller": { "method": "brownian" }, "epochs": 1 });
    let expanded = expand(
        &json!({ "name": "two", "base": brownian, "seeds": [3, 4], "parts": [
            { "matrix": { "arena": ["easy", "maze"] } },
            { "name": "crowd", "base": { "robots": 2, "placement": "grid" }, "seeds": [9] }
        ] }),
        &BuiltinArenas,
    )
    .unwrap();
    let labels = ["part 1: arena easy", "part 1: arena maze", "crowd"];
    assert_eq!(expanded.name, "two");
    assert_eq!(expanded.labels, [0, 0, 1, 1, 2].map(|place| labels[place]));
    let robots = expanded
        .runs
        .iter()
        .map(|run| (run.seed(), run.run_spec().robots));
    assert_eq!(
        robots.collect::<Vec<_>>(),
        [(3, 1), (4, 1), (3, 1), (4, 1), (9, 2)]
    );
    let seeds = expanded
        .designs
        .iter()
        .map(|design| (design.part.as_deref(), design.seeds));
    assert_eq!(
        seeds.collect::<Vec<_>>(),
        [(Some("part 1"), 2), (Some("crowd"), 1)]
    );

    let check = |parts: Value, pointer: &str, words: &str| {
        check_job(json!({ "base": brownian, "parts": parts }), pointer, words);
    };
    check(json!([{}, {}]), "/parts/1", "part \"part 1\" already has");
    check(
        json!([{}, { "base": { "epochs": 0 } }]),
        "/parts/1/base/epochs",
        "0 is not",
    );
    check(
        json!([{ "matrix": { "epochs": [1, 0] } }]),
        "/parts/0/matrix/epochs/1",
        "0 is not",
    );
    check(
        json!([{ "seeds": { "count": 60_000 } }, { "seeds": { "first": 60_001, "count": 60_000 } }]),
        "/parts",
        "more than",
    );
}

#[test]
fn what_a_job_says_takes_the_place_of_what_its_template_says() {
    let runs = |job: Value| expand(&job, &BuiltinArenas).unwrap().runs;
    let base = json!({ "epochs": 2, "controller": { "method": "im" } });
    let job =
        json!({ "template": "chapter-5", "base": base, "matrix": { "arena": ["easy", "maze"] } });
    assert_eq!(runs(job).len(), 2 * 15);
    let job = json!({ "template": "chapter-5", "seeds": [1, 2], "base": { "epochs": 3 } });
    let runs = runs(job);
    assert_eq!(runs.len(), 2 * (30 + 2 + 9));
    assert!(runs.iter().all(|run| run.epochs() == 3));
}

#[test]
fn a_combination_that_does_not_go_together_is_named() {
    let job = json!({
        "base": { "controller": { "train": { "epochs": 3 } } },
        "matrix": { "controller.method": ["im", "ev-iter-c"] }
    });
    check_job(
        job,
        "/base/controller/train",
        "with controller.method = \"im\"",
    );
}

proptest! {
    #[test]
    fn no_json_makes_expanding_panic(value in any_json()) {
        if let Err(errors) = expand(&value, &BuiltinArenas) {
            prop_assert!(!errors.is_empty());
        }
    }
}

#[test]
fn paths_that_vary_together_are_one_axis() {
    let job = |matrix: Value| {
        json!({
            "base": { "controller": { "method": "brownian" }, "arena": { "from": "easy" }, "epochs": 1 },
            "matrix": matrix, "seeds": { "first": 1, "count": 2 }
        })
    };
    let expanded = expand(
        &job(json!({ "robots+arena.tile": [[1, [1, 1]], [4, [2, 2]]] })),
        &BuiltinArenas,
    )
    .unwrap();
    let seen: Vec<_> = expanded
        .runs
        .iter()
        .map(|run| (run.run_spec().robots, run.arena().name().to_owned()))
        .collect();
    assert_eq!(seen[0], (1, "easy-1x1".to_owned()));
    assert_eq!(seen[2], (4, "easy-2x2".to_owned()));
    assert_eq!(seen.len(), 4);
    assert_eq!(expanded.labels[2], "robots+tile 4 + [2,2]");
    let design = &expanded.designs[0];
    assert_eq!((design.seeds, design.axes.len()), (2, 1));
    assert_eq!(design.axes[0].values[1], [json!(4), json!([2, 2])]);

    let check = |matrix: Value, pointer: &str, words: &str| check_job(job(matrix), pointer, words);
    let linked = "/matrix/robots+arena.tile";
    let at = |place: &str| format!("{linked}{place}");
    check(
        json!({ "robots+arena.tile": [[1, [1, 1]], 4] }),
        &at("/1"),
        "must be a list",
    );
    check(
        json!({ "robots+arena.tile": [[1]] }),
        &at("/0"),
        "1 values for 2 paths",
    );
    check(
        json!({ "robots+arena.tile": [[0, [1, 1]]] }),
        &at("/0/0"),
        "0 is not",
    );
    check(
        json!({ "robots+arena.tile": [[1, [1, 99]]] }),
        &at("/0/1/1"),
        "99 rows",
    );
    check(
        json!({ "robots+arena.tile": [[2, [1, 1]]] }),
        &at("/0/0"),
        "at most 1 robots",
    );
    check(
        json!({ "robots+": [[1, 2]] }),
        "/matrix/robots+",
        "vary together",
    );
    check(
        json!({ "robots": [1], "robots+arena.tile": [[1, [1, 1]]] }),
        linked,
        "robots is set twice",
    );
    check(
        json!({ "robots+seed": [[1, 2]] }),
        "/matrix/robots+seed",
        "no axis",
    );
}

#[test]
fn robots_are_an_axis() {
    let job = json!({
        "base": { "controller": { "method": "brownian" }, "placement": "random", "epochs": 1 },
        "matrix": { "robots": [1, 2, 4] }, "seeds": [3, 5]
    });
    let expanded = expand(&job, &BuiltinArenas).unwrap();
    let robots: Vec<u32> = expanded
        .runs
        .iter()
        .map(|run| run.run_spec().robots)
        .collect();
    assert_eq!(robots, [1, 1, 2, 2, 4, 4]);
}
