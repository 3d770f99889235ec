//! `evswarm submit`, `status`, `cancel`, and the commands that need no server.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::ControllerListing;
use serde_json::json;
use tests::command::{evswarm, evswarm_in};
use tests::server::Server;
use tests::{job, small_spec};

#[test]
fn a_job_is_submitted_watched_and_asked_for() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let url = server.url().to_owned();
    let url = ["--server", &url];
    let with = |arguments: &[&str], input: &str| evswarm(&[arguments, &url].concat(), input);

    let none = with(&["status"], "");
    assert_eq!((none.code, none.stdout.as_str()), (Some(0), ""));
    let mut spec = small_spec();
    spec["epochs"] = json!(200);
    let done = with(
        &["submit", "-", "--watch"],
        &job(spec.clone(), 3).to_string(),
    );
    assert_eq!(done.code, Some(0), "{done:?}");
    let last = done.stdout.lines().last().unwrap();
    assert!(last.contains("done: 100.0 %, 3 of 3 runs done"), "{done:?}");
    let status = with(&["status", "1"], "");
    assert_eq!(status.stdout.trim(), last);

    let mut wrong = job(spec.clone(), 1);
    wrong["base"]["epohcs"] = json!(1);
    wrong["base"]["robots"] = json!(0);
    let refused = with(&["submit", "-"], &wrong.to_string());
    assert_eq!(refused.code, Some(2), "{refused:?}");
    let lines: Vec<&str> = refused.stderr.lines().collect();
    assert!(lines.iter().any(|line| line.starts_with("/base/robots: ")));
    let unknown = lines.iter().find(|line| line.starts_with("/base/epohcs: "));
    assert!(unknown.unwrap().contains("did you mean \"epochs\"?"));

    spec["epochs"] = json!(1_000_000);
    spec["steps_per_epoch"] = json!(10_000);
    assert_eq!(
        with(&["submit", "-"], &job(spec, 1).to_string()).code,
        Some(0)
    );
    let cancelled = with(&["cancel", "2"], "");
    assert!(cancelled.stdout.contains("cancelled"), "{cancelled:?}");
    let newest = with(&["status"], "");
    assert_eq!(newest.stdout.lines().count(), 2);
    assert_eq!(with(&["status", "9"], "").code, Some(1));
    drop(server);
    assert_eq!(with(&["status"], "").code, Some(1));
}

#[test]
fn a_token_opens_a_server_that_asks_for_one() {
    let home = tempfile::tempdir().unwrap();
    let token = "a token of some length";
    let server = Server::start_with_token(home.path(), token);
    let url = server.url().to_owned();
    let mut spec = small_spec();
    spec["epochs"] = json!(1_000_000);
    let job = job(spec, 1).to_string();
    for (command, said) in [
        (&["submit", "-"][..], "0 of 1 runs done"),
        (&["status", "1"], "0 of 1 runs done"),
        (&["cancel", "1"], "cancelled"),
    ] {
        let with = |token: &str| {
            let arguments = [command, &["--server", &url]].concat();
            evswarm_in(&arguments, &job, &[("EVSWARM_TOKEN", token)])
        };
        let refused = with("");
        assert_eq!(refused.code, Some(1), "{refused:?}");
        assert!(refused.stderr.contains("401"), "{refused:?}");
        assert_eq!(with("another of some length").code, Some(1));
        let done = with(token);
        assert_eq!(done.code, Some(0), "{done:?}");
        assert!(done.stdout.contains(said), "{done:?}");
    }
}

#[test]
fn the_catalogue_needs_no_server() {
    let listed = evswarm(&["controllers", "--json"], "");
    let listing: ControllerListing = serde_json::from_str(&listed.stdout).unwrap();
    assert_eq!(listing.methods.len(), 10);
    assert!(
        listing
            .parameters
            .iter()
            .all(|parameter| !parameter.source.is_empty())
    );
    let arenas = evswarm(&["arenas", "list"], "").stdout;
    for name in ["easy", "graph", "maze"] {
        assert!(arenas.contains(name), "{arenas}");
        let drawn = evswarm(&["arenas", "draw", name], "");
        assert!(drawn.stdout.contains("<svg") && drawn.code == Some(0));
    }
    let completions = evswarm(&["completions", "bash"], "");
    assert!(completions.stdout.contains("evswarm"));
    assert_eq!(evswarm(&["--version"], "").code, Some(0));
}
