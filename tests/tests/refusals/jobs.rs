//! Jobs that are wrong around their base run.

use serde_json::{Value, json};
use tests::server::Server;
use tests::{job, small_spec};

use super::has;

#[test]
fn wrong_jobs_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let cases = [
        (
            json!({ "matrix": { "controller..alpha": [1] } }),
            "/matrix/controller..alpha",
        ),
        (
            json!({ "matrix": { "epochs.x": [1] }, "base": { "epochs": 3 } }),
            "/matrix/epochs.x",
        ),
        (json!({ "matrix": { "epohcs": [1] } }), "/matrix/epohcs/0"),
        (json!({ "matrix": { "epochs": [] } }), "/matrix/epochs"),
        (json!({ "matrix": { "epochs": 3 } }), "/matrix/epochs"),
        (
            json!({ "matrix": { "epochs": [3, 3] } }),
            "/matrix/epochs/1",
        ),
        (
            json!({ "matrix": { "robots+epochs": [[1, 2], [3]] } }),
            "/matrix/robots+epochs/1",
        ),
        (json!({ "matrix": { "seed": [1, 2] } }), "/matrix/seed"),
        (json!({ "parts": [{}], "matrix": {} }), "/matrix"),
        (json!({ "parts": [{}, {}] }), "/parts/1"),
        (
            json!({ "parts": [{ "base": { "epochs": 0 } }] }),
            "/parts/0/base/epochs",
        ),
        (json!({ "seeds": [1, 2, 1] }), "/seeds/2"),
        (json!({ "seeds": [] }), "/seeds"),
        (json!({ "seeds": 3 }), "/seeds"),
        (json!({ "seeds": [1], "base": { "seed": 1 } }), "/base/seed"),
        (
            json!({ "seeds": { "first": 1, "count": 100_001 } }),
            "/seeds/count",
        ),
        (
            json!({ "seeds": { "first": 1, "count": 100_000 }, "matrix": { "epochs": [1, 2] } }),
            "",
        ),
        (json!({ "template": "chapter-55" }), "/template"),
        (json!({ "name": "x".repeat(201) }), "/name"),
        (json!([]), ""),
    ];
    for (wrong, pointer) in cases {
        let problem = server.post("/v1/jobs", &wrong).problem(422);
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
    keyed(&job(small_spec(), 2)).problem(422);
}
