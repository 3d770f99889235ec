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

/// Proxies were asked for the way to this very machine, and not named when they failed.
#[test]
fn this_machine_is_reached_without_a_proxy_and_a_proxy_that_fails_is_named() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    // Nobody listens on the port that is for discarding.
    let proxy = "http://127.0.0.1:9";
    let variables: Vec<(&str, &str)> = ["HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY"]
        .map(|name| (name, proxy))
        .to_vec();
    let local = server.url().replace("127.0.0.1", "localhost");
    for url in [server.url(), &local] {
        let done = evswarm_in(&["status", "--server", url], "", &variables);
        assert_eq!(done.code, Some(0), "{url}: {done:?}");
    }
    // An address that is nobody's.
    let failed = evswarm_in(&["status", "--server", "http://192.0.2.1"], "", &variables);
    assert_eq!(failed.code, Some(1));
    assert!(
        failed.stderr.contains("through the proxy 127.0.0.1:9"),
        "{failed:?}"
    );
}

#[test]
fn the_server_can_stand_in_the_environment() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    server.submit(&job(small_spec(), 1));
    let variables = [("EVSWARM_SERVER", server.url())];
    let done = evswarm_in(&["status"], "", &variables);
    assert_eq!(
        (done.code, done.stdout.lines().count()),
        (Some(0), 1),
        "{done:?}"
    );
}

#[test]
fn the_catalogue_needs_no_server() {
    let listed = evswarm(&["controllers", "--json"], "");
    let listing: ControllerListing = serde_json::from_str(&listed.stdout).unwrap();
    assert_eq!(listing.methods.len(), 13);
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
