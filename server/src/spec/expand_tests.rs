//! Jobs as a user would write them: the runs that they make, and what is said of wrong ones.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use serde_json::{Value, json};

use super::testing::{any_json, refused, resolved, two_rooms};
use super::*;

fn check_job(job: Value, pointer: &str, words: &str) {
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
fn a_long_arena_in_many_combinations_is_refused_at_once() {
    let mut arena = two_rooms();
    arena["walls_m"] = vec![json!([0.3, 0.0, 0.3, 0.4]); 10_000].into();
    let epochs: Vec<u32> = (1..=10_000).collect();
    let job = json!({ "base": { "arena": arena }, "matrix": { "epochs": epochs } });
    check_job(job, "", "too much to read");
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
