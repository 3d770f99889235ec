//! Runs that behave oddly come first in what a job found, with the reason.

use api::explanation::Explanation;
use api::{JobSummary, State};
use serde_json::json;
use tests::command::evswarm;
use tests::server::Server;
use tests::wait;

#[test]
fn a_run_that_cannot_get_out_comes_first_in_the_summary_with_the_reason() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    // Seed 5 stands in a passage from which no way leads out.
    let seed = 5;
    let job = server.submit(&json!({
        "base": {
            "arena": {
                "name": "passage", "width_m": 1.0, "height_m": 1.0,
                "walls_m": [[0.12, 0.0, 0.12, 1.0]],
                "starts": [{ "x_m": 0.5, "y_m": 0.5, "heading_rad": 0.0 }],
            },
            "placement": { "kind": "random", "anywhere": true },
            "controller": { "method": "brownian" },
            "epochs": 3, "steps_per_epoch": 4_000, "episodes": "continue",
        },
        "seeds": { "first": 1, "count": 12 },
    }));
    server.wait_for(&job);
    let path = format!("/v1/jobs/{}/summary", job.id);
    let first: JobSummary = server.read(&path);
    let odd = first.odd_runs.first().unwrap();
    assert!(odd.seed == seed && odd.is_outlier, "{odd:?}");
    assert!(
        f64::from(odd.p1) < odd.median_p1 && odd.score.unwrap() < -3.5,
        "{odd:?}"
    );
    // Nobody asked why: it is found out all the same.
    let why = wait::until("the reason", || {
        let summary: JobSummary = server.read(&path);
        summary.odd_runs[0].explanation.clone()
    });
    let explanation: Explanation = server.read(&format!("/v1/runs/{}/explain", odd.run_id));
    assert!(explanation.is_odd && explanation.sentence == why);
    let shown = evswarm(&["summary", &job.id, "--server", server.url()], "");
    let (text, at) = (&shown.stdout, |words: &str| shown.stdout.find(words));
    assert!(at("Runs that stand out") < at("| group"), "{text}");
    assert!(text.contains(&why), "{text}");

    // One that is not far from the others comes in by its explanation alone, where that is known.
    let other = server.runs(&job).into_iter().find(|run| run.seed != seed);
    let other = other.unwrap();
    assert_eq!(other.state, State::Done);
    let path = format!("/v1/runs/{}/explain", other.id);
    let explanation: Explanation = wait::until("the explanation", || {
        let answer = server.get(&path);
        (answer.status == 200).then(|| answer.json())
    });
    let summary: JobSummary = server.read(&format!("/v1/jobs/{}/summary", job.id));
    let listed = summary.odd_runs.iter().find(|odd| odd.run_id == other.id);
    assert!(listed.is_some() || !explanation.is_odd, "{summary:?}");
}
