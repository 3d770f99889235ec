//! Prepared jobs, by name.

use api::TemplateListing;
use serde_json::{Value, json};

/// Every template.
pub fn templates() -> Vec<TemplateListing> {
    let methods = swarm::spec::Method::NAMES;
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
            "chapter-5",
            "The experiments of the thesis's chapter 5: every method on three arenas, 15 seeds, \
             2,000 epochs of 2,000 steps",
            json!({
                "base": {},
                "matrix": {
                    "arena": ["easy", "graph", "maze"],
                    "controller.method": methods
                },
                "seeds": { "first": 1, "count": 15 }
            }),
        ),
    ]
    .map(|(name, about, job)| TemplateListing {
        name: name.to_owned(),
        about: about.to_owned(),
        runs: count(&job),
        job,
    })
    .into()
}

/// Runs that a template makes: the product of its axes and seeds.
fn count(job: &Value) -> u64 {
    let axes = job["matrix"].as_object().into_iter().flatten();
    let combinations: usize = axes
        .map(|(_, values)| values.as_array().map_or(0, Vec::len))
        .product();
    combinations as u64 * job["seeds"]["count"].as_u64().unwrap_or(1)
}
