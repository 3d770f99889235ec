//! Jobs that are wrong around their base run.

use serde_json::{Value, json};
use tests::server::Server;
use tests::{job, small_spec};

use super::has;

#[test]
fn wrong_jobs_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let matrix = "a matrix with a wrong path, no value or twice the same run";
    let parts = "parts beside a matrix, or two that make the same run";
    let seeds = "a seed twice, or seeds beside a seed in the base run";
    let many = "a job of more than 100,000 runs";
    let range = "a number out of range or a value of the wrong kind";
    let cases = [
        (
            matrix,
            json!({ "matrix": { "controller..alpha": [1] } }),
            "/matrix/controller..alpha",
        ),
        (
            matrix,
            json!({ "matrix": { "epochs.x": [1] }, "base": { "epochs": 3 } }),
            "/matrix/epochs.x",
        ),
        (
            matrix,
            json!({ "matrix": { "epohcs": [1] } }),
            "/matrix/epohcs/0",
        ),
        (
            matrix,
            json!({ "matrix": { "epochs": [] } }),
            "/matrix/epochs",
        ),
        (
            matrix,
            json!({ "matrix": { "epochs": 3 } }),
            "/matrix/epochs",
        ),
        (
            matrix,
            json!({ "matrix": { "epochs": [3, 3] } }),
            "/matrix/epochs/1",
        ),
        (
            matrix,
            json!({ "matrix": { "robots+epochs": [[1, 2], [3]] } }),
            "/matrix/robots+epochs/1",
        ),
        (
            matrix,
            json!({ "matrix": { "seed": [1, 2] } }),
            "/matrix/seed",
        ),
        (
            "a parameter varied for a method that does not have it",
            json!({ "matrix": {
                "controller.method": ["im", "brownian"], "controller.eta": [0.1, 0.2]
            } }),
            "/matrix/controller.eta/1",
        ),
        (parts, json!({ "parts": [{}], "matrix": {} }), "/matrix"),
        (parts, json!({ "parts": [{}, {}] }), "/parts/1"),
        (
            range,
            json!({ "parts": [{ "base": { "epochs": 0 } }] }),
            "/parts/0/base/epochs",
        ),
        (seeds, json!({ "seeds": [1, 2, 1] }), "/seeds/2"),
        (seeds, json!({ "seeds": [] }), "/seeds"),
        (range, json!({ "seeds": 3 }), "/seeds"),
        (
            seeds,
            json!({ "seeds": [1], "base": { "seed": 1 } }),
            "/base/seed",
        ),
        (
            many,
            json!({ "seeds": { "first": 1, "count": 100_001 } }),
            "/seeds/count",
        ),
        (
            many,
            json!({ "seeds": { "first": 1, "count": 100_000 }, "matrix": { "epochs": [1, 2] } }),
            "",
        ),
        (range, json!({ "template": "chapter-55" }), "/template"),
        (range, json!({ "name": "x".repeat(201) }), "/name"),
        (range, json!([]), ""),
    ];
    for (row, wrong, pointer) in cases {
        let problem = server.post("/v1/jobs", &wrong).refused(row);
        assert!(has(&problem.errors, pointer, ""), "{wrong}: {problem:?}");
    }

    let keyed = |body: &Value| {
        let headers = [
            ("content-type", "application/json"),
            ("idempotency-key", "a key"),
        ];
        server.send("POST", "/v1/jobs", &headers, body.to_string().as_bytes())
    };
    let first = keyed(&job(small_spec(), 1));
    assert_eq!(first.status, 201);
    let again = keyed(&job(small_spec(), 1));
    assert_eq!(again.header("location"), first.header("location"));
    keyed(&job(small_spec(), 2)).refused("an idempotency key used for another body");
}
