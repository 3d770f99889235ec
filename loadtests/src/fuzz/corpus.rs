//! Right documents, which changes begin with: the experiments, templates, built-in arenas, and one
//! of every form besides.

use serde_json::{Value, json};

const EXPERIMENTS: [&str; 7] = [
    include_str!("../../../experiments/first-job.json"),
    include_str!("../../../experiments/memory.json"),
    include_str!("../../../experiments/pushing-boxes.json"),
    include_str!("../../../experiments/rapier-friction.json"),
    include_str!("../../../experiments/sharing-im.json"),
    include_str!("../../../experiments/sharing.json"),
    include_str!("../../../experiments/ten-thousand.json"),
];

fn is_job(document: &Value) -> bool {
    ["base", "parts", "template"]
        .iter()
        .any(|field| document.get(field).is_some())
}

fn experiments() -> Vec<Value> {
    // They are tested to be JSON.
    EXPERIMENTS
        .iter()
        .filter_map(|text| serde_json::from_str(text).ok())
        .collect()
}

/// Jobs.
pub fn jobs() -> Vec<Value> {
    let mut all: Vec<Value> = experiments().into_iter().filter(is_job).collect();
    all.extend(
        server::documents::templates()
            .into_iter()
            .map(|template| template.job),
    );
    let base = json!({ "arena": "easy", "controller": { "method": "brownian" }, "epochs": 2 });
    all.extend([
        json!({ "template": "chapter-5", "base": { "epochs": 200 }, "seeds": { "count": 3 } }),
        json!({ "name": "linked", "base": base, "seeds": [4, 1],
            "matrix": { "robots+arena.tile": [[1, [1, 1]], [4, [2, 2]]], "arena": [{ "from": "easy" }] } }),
        json!({ "$schema": "job.json", "base": base, "seeds": { "first": 1, "count": 5 },
            "parts": [{ "name": "a", "base": { "epochs": 5 }, "matrix": { "robot.step_s": [0.03, 0.06] } },
                { "base": { "controller": { "method": "im" } }, "seeds": [9] }] }),
        json!({ "base": { "robots": 8, "arena": "maze", "placement": { "kind": "random", "anywhere": true } },
            "matrix": { "robots": [1, 2, 4], "sharing.mode": ["none", "radio"], "controller.method": ["im"] } }),
    ]);
    all
}

/// Run specs.
pub fn runs() -> Vec<Value> {
    let mut all: Vec<Value> = experiments();
    all.retain(|document| !is_job(document));
    // Under rapier, since some arenas have movable objects.
    all.extend(
        arenas()
            .into_iter()
            .map(|arena| json!({ "arena": arena, "epochs": 3, "engine": "rapier" })),
    );
    all.extend([
        json!({ "schema": 1, "seed": 7, "epochs": 3.0, "robots": 4, "placement": "grid" }),
        json!({ "arena": { "from": { "from": "easy", "tile": [2, 1] }, "tile": [2, 2], "doorway_m": 0.1 } }),
        json!({ "controller": { "method": "ev-iter-c", "alpha": 0.5, "train": { "arena": "easy", "epochs": 20 } } }),
        json!({ "controller": { "method": "levy" }, "robot": { "preset": "epuck2", "body_radius_m": 0.05 } }),
        json!({ "memory_budget_bytes": "e-puck", "episodes": "continue", "engine": "rapier" }),
        json!({ "sharing": { "mode": "radio", "range_m": null, "bytes_per_step": 64 }, "robots": 9,
            "arena": "easy", "placement": "random", "controller": { "method": "im" } }),
    ]);
    all
}

/// Arenas.
pub fn arenas() -> Vec<Value> {
    let built_in = arenas::builtin_names().iter().filter_map(|name| {
        let mut format = arenas::builtin(name)?.to_format();
        format.name = Some(format!("my-{name}"));
        serde_json::to_value(format).ok()
    });
    let kinds = arenas::GeneratorKind::ALL.iter();
    let generated = kinds.map(|kind| {
        json!({ "width_m": 1.2, "height_m": 0.9, "squares": [60, 45],
            "generate": { "kind": kind.as_str(), "seed": 3 } })
    });
    let yard = json!({
        "name": "yard", "width_m": 0.6, "height_m": 0.6, "walls_m": [[0.3, 0.0, 0.3, 0.4]],
        "starts": [{ "x_m": 0.1, "y_m": 0.1, "heading_rad": 0.8 }],
        "objects": [
            { "kind": "box", "x_m": 0.2, "y_m": 0.2, "width_m": 0.06, "height_m": 0.04 },
            { "kind": "disc", "x_m": 0.45, "y_m": 0.3, "radius_m": 0.03, "mass_kg": 0.1 }
        ]
    });
    built_in.chain(generated).chain([yard]).collect()
}
