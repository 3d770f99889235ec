//! Prepared jobs, by name.

use std::borrow::Cow;

use serde_json::{Value, json};
use swarm::spec::EngineKind;

use super::fields::{Errors, did_you_mean, kind};

/// Name of the template of [`chapter_5`].
pub const CHAPTER_5: &str = "chapter-5";
/// The arenas of the thesis's chapter 5.
const ARENAS: [&str; 3] = ["easy", "graph", "maze"];
/// Where Ev-ITER-C is shown after shorter first phases, and of how many epochs (instead of 200).
pub const SHORT_PHASE_ARENA: &str = "maze";
/// As above.
pub const SHORT_PHASE_METHOD: &str = "ev-iter-c";
/// As above.
pub const SHORT_PHASES: [u32; 2] = [20, 50];
/// The methods of chapter 5.
pub const CHAPTER_5_METHODS: [&str; 10] = [
    "brownian",
    "curiosity",
    "curiosity-a",
    "discovery",
    "discovery-a",
    "im",
    "ev-iter-c",
    "ev-iter-d",
    "ev-iter-ca",
    "ev-iter-da",
];
/// The main comparison, which is repeated under the engine rapier.
pub const ENGINE_METHODS: [&str; 3] = ["im", "ev-iter-c", "curiosity-a"];

/// The experiments of chapter 5 on some arenas: its ten methods; on the maze Ev-ITER-C with shorter
/// first phases; and the main comparison with rigid bodies, where that has seeds.
pub fn chapter_5(arenas: &[&str], base: Value, seeds: u32, rapier_seeds: u32) -> Value {
    let mut parts = vec![json!({
        "name": "methods",
        "matrix": { "arena": arenas, "controller.method": CHAPTER_5_METHODS },
    })];
    if arenas.contains(&SHORT_PHASE_ARENA) {
        parts.push(json!({
            "name": "short phase 1",
            "base": { "arena": SHORT_PHASE_ARENA, "controller": { "method": SHORT_PHASE_METHOD } },
            "matrix": { "controller.train.epochs": SHORT_PHASES },
        }));
    }
    if rapier_seeds > 0 {
        parts.push(json!({
            "name": "rapier",
            "base": { "engine": EngineKind::Rapier.name() },
            "matrix": { "arena": arenas, "controller.method": ENGINE_METHODS },
            "seeds": { "first": 1, "count": rapier_seeds },
        }));
    }
    json!({ "base": base, "seeds": { "first": 1, "count": seeds }, "parts": parts })
}

/// Names of the templates.
pub(super) fn names() -> [&'static str; 2] {
    prepared().map(|(name, ..)| name)
}

/// Every template: its name, what it is about, and the job.
pub(super) fn prepared() -> [(&'static str, &'static str, Value); 2] {
    [
        (
            "first-job",
            "A look at the service: two values of alpha on the maze, three seeds, small runs",
            json!({
                "base": {
                    "arena": "maze",
                    "controller": {
                        "method": "ev-iter-c",
                        "train": { "arena": "easy", "epochs": 20 }
                    },
                    "epochs": 20
                },
                "matrix": { "controller.alpha": [0.5, 0.7] },
                "seeds": { "first": 1, "count": 3 }
            }),
        ),
        (
            CHAPTER_5,
            "The experiments of the thesis's chapter 5: ten methods on three arenas, 15 seeds, \
             2,000 epochs of 2,000 steps; shorter first phases; the main comparison under rapier. \
             Done, the job has a report",
            chapter_5(&ARENAS, json!({}), 15, 5),
        ),
    ]
}

/// The job, or the template that it names with the job's own fields in place of the template's.
pub(super) fn with_template<'a>(job: &'a Value, errors: &mut Errors) -> Cow<'a, Value> {
    let Some((map, wanted)) = job
        .as_object()
        .and_then(|map| Some((map, map.get("template")?)))
    else {
        return Cow::Borrowed(job);
    };
    let templates = prepared();
    let names = templates.each_ref().map(|(name, ..)| *name);
    let message = match wanted {
        Value::String(name) => match templates.iter().find(|(known, ..)| known == name) {
            Some((_, _, job)) => {
                let mut merged = job.clone();
                if let Some(fields) = merged.as_object_mut() {
                    fields.insert("name".to_owned(), Value::from(name.as_str()));
                    // Either of them says what varies.
                    if map.contains_key("matrix") || map.contains_key("parts") {
                        fields.remove("matrix");
                        fields.remove("parts");
                    }
                    // Seeds are those of all parts.
                    let parts = fields.get_mut("parts").and_then(Value::as_array_mut);
                    for part in parts
                        .into_iter()
                        .flatten()
                        .filter(|_| map.contains_key("seeds"))
                    {
                        part.as_object_mut().map(|part| part.remove("seeds"));
                    }
                    fields.extend(map.clone());
                }
                return Cow::Owned(merged);
            }
            None => format!(
                "there is no template {name:?}{}",
                did_you_mean(name, &names)
            ),
        },
        _ => format!("must be a string, not {}", kind(wanted)),
    };
    errors.add("/template", message, names.join(", "));
    Cow::Borrowed(job)
}
