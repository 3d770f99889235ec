//! A job over numbers of robots in an arena that grows along: from one post to its summary.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::{JobSummary, Metrics, RunResult};
use serde_json::json;
use tests::command::evswarm;
use tests::server::Server;

#[test]
fn a_job_over_robots_is_summed_up() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let job = server.submit(&json!({
        "name": "density kept",
        "base": {
            "arena": { "from": "easy", "squares": 10 }, "controller": { "method": "brownian" },
            "epochs": 60, "steps_per_epoch": 2_000, "episodes": "continue"
        },
        "matrix": { "robots+arena.tile": [[1, [1, 1]], [2, [2, 1]], [4, [2, 2]]] },
        "seeds": { "first": 1, "count": 3 }
    }));
    let done = server.wait_for(&job);
    assert_eq!(done.runs.done, 9);
    for run in server.runs(&job) {
        let result: RunResult = server.read(&format!("/v1/runs/{}/result", run.id));
        let metrics: Metrics = server.read(&format!("/v1/runs/{}/metrics", run.id));
        let swarm = result.metrics.unwrap();
        let last = metrics.rows.last().unwrap();
        assert_eq!((last.steps, last.fractions), (120_000, result.fractions));
        // The time to half of the squares lies between the rows before and after.
        let reached = metrics.rows.iter().find(|row| row.fractions.p1 >= 0.5);
        match (swarm.get("t50_steps"), reached) {
            (Some(steps), Some(row)) => assert!(steps <= row.steps as f64),
            (steps, row) => assert_eq!((steps, row), (None, None)),
        }
        assert_eq!(
            swarm.get("overlap").is_some(),
            !run.label.starts_with("robots+tile 1 ")
        );
    }

    let path = format!("/v1/jobs/{}/summary", job.id);
    let summary: JobSummary = server.read(&path);
    let robots: Vec<u32> = summary.groups.iter().map(|group| group.robots).collect();
    assert_eq!(robots, [1, 2, 4]);
    assert_eq!(summary.groups[1].values["arena.tile"], json!([2, 1]));
    for group in &summary.groups {
        assert_eq!((group.runs, group.runs_done), (3, 3));
        let p1 = &group.measures[0];
        let interval = p1.interval.clone().unwrap();
        let (low, high) = (interval.low, interval.high);
        let mean = p1.mean.unwrap();
        assert!(
            p1.name == "p1" && low <= mean && mean <= high && low < high,
            "{p1:?}"
        );
    }
    let [scaling] = &summary.scaling[..] else {
        panic!("{summary:?}")
    };
    assert_eq!(scaling.paths, ["robots", "arena.tile"]);
    let fit = &scaling.fits[0];
    assert_eq!((fit.name.as_str(), fit.n + fit.missed), ("t50_steps", 9));
    // Robots and room grow together: the time to cover half stays of one order.
    assert!(fit.b.abs() < 1.0, "{fit:?}");
    assert!(summary.sharing.is_empty());

    let csv = server.get(&format!("{path}.csv"));
    assert_eq!(
        csv.text().lines().count(),
        1 + 3 * summary.groups[0].measures.len()
    );
    let shown = evswarm(&["summary", &job.id, "--server", server.url()], "");
    assert_eq!(shown.code, Some(0), "{shown:?}");
    assert_eq!(
        shown.stdout.trim(),
        server.get(&format!("{path}.md")).text().trim()
    );
    assert!(shown.stdout.contains("9 of 9 runs done"), "{shown:?}");
    let compared = evswarm(
        &[
            "compare",
            &job.id,
            "--by",
            "robots",
            "--server",
            server.url(),
        ],
        "",
    );
    assert_eq!(compared.code, Some(0), "{compared:?}");
    assert!(compared.stdout.contains("n = 3 pairs"), "{compared:?}");
    let refused = evswarm(
        &[
            "compare",
            &job.id,
            "--measure",
            "a&b",
            "--server",
            server.url(),
        ],
        "",
    );
    assert_eq!(refused.code, Some(1), "{refused:?}");
    assert!(refused.stderr.contains("\"a&b\" is none"), "{refused:?}");
    assert_eq!(
        evswarm(&["summary", "99", "--server", server.url()], "").code,
        Some(1)
    );
}
