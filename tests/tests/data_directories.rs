//! Data directories of earlier programs, made by `tests/data_directories/make.sh`: today's program
//! opens each, answers what that program answered, and brings its unfinished run to the same end.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::path::{Path, PathBuf};

use rusqlite::Connection;
use serde_json::Value;
use tests::command;
use tests::readme;
use tests::server::Server;
use tests::wait;

/// The job that is half done, with a checkpoint.
const UNDER_WAY: &str = "/v1/jobs/4";

fn directories() -> Vec<PathBuf> {
    let root = readme::root().join("tests/data_directories");
    let entries = fs::read_dir(root).unwrap();
    let mut found: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_dir())
        .collect();
    found.sort();
    assert!(!found.is_empty());
    found
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy(&from, &to);
        } else {
            fs::copy(from, to).unwrap();
        }
    }
}

/// The route that a file of expected answers is about; `None` for one that is looked at apart.
fn route(name: &str) -> Option<String> {
    let (stem, extension) = name.split_once('.').unwrap_or((name, ""));
    let mut parts = stem.split('-');
    match (parts.next().unwrap(), parts.next(), parts.next()) {
        ("jobs", None, None) => Some("/v1/jobs".into()),
        ("arena", None, None) => Some("/v1/arenas/cell".into()),
        ("job", Some(job), None) => Some(format!("/v1/jobs/{job}")),
        ("job", Some(job), Some("runs")) => Some(format!("/v1/jobs/{job}/runs")),
        ("job", Some(job), Some(file)) => Some(format!("/v1/jobs/{job}/{file}.{extension}")),
        ("run", Some(_), Some("result")) if stem.ends_with("-when-done") => None,
        ("run", Some(run), Some(file)) if extension.is_empty() => {
            Some(format!("/v1/runs/{run}/{file}"))
        }
        ("run", Some(run), Some(file)) => Some(format!("/v1/runs/{run}/{file}.{extension}")),
        other => panic!("what is {other:?}?"),
    }
}

/// Whether all that the old program said is said still; there may be more.
fn assert_holds(old: &Value, new: &Value, at: &str) {
    match (old, new) {
        (Value::Object(old), Value::Object(new)) => {
            for (key, value) in old {
                let found = new.get(key).unwrap_or_else(|| panic!("{at}/{key} is gone"));
                assert_holds(value, found, &format!("{at}/{key}"));
            }
        }
        (Value::Array(old), Value::Array(new)) => {
            assert_eq!(old.len(), new.len(), "{at}");
            for (place, (old, new)) in old.iter().zip(new).enumerate() {
                assert_holds(old, new, &format!("{at}/{place}"));
            }
        }
        (old, new) => assert_eq!(old, new, "{at}"),
    }
}

/// Whether a summary has every row that it had, with the same counts, means, deviations and medians.
/// There may be more rows and columns; intervals are made anew by whatever method holds best.
fn assert_summary_holds(old: &str, new: &str, at: &str) {
    let columns = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<String>>();
    let row = |line: &str| columns(line)[..9].to_vec();
    let (old_head, new_head) = (old.lines().next().unwrap(), new.lines().next().unwrap());
    assert!(new_head.starts_with(old_head), "{at}: {new_head}");
    let rows: Vec<Vec<String>> = new.lines().map(row).collect();
    assert!(old.lines().count() > 10, "{at}");
    for line in old.lines() {
        assert!(rows.contains(&row(line)), "{at}: {line}");
    }
}

/// A table with every number as it was written before whole ones had a point: the same number, in
/// other digits.
fn table(bytes: &[u8]) -> String {
    let text = std::str::from_utf8(bytes).unwrap();
    let cell = |cell: &str| match cell.parse::<f64>() {
        Ok(number) => number.to_string(),
        Err(_) => cell.to_owned(),
    };
    let line = |line: &str| line.split(',').map(cell).collect::<Vec<_>>().join(",");
    text.lines().map(|text| line(text) + "\n").collect()
}

/// Whether metrics over time are the same, but for columns at the end that are new, and
/// empty.
fn assert_metrics_hold(old: &str, new: &str, at: &str) {
    assert_eq!(old.lines().count(), new.lines().count(), "{at}");
    let (head, new_head) = (old.lines().next().unwrap(), new.lines().next().unwrap());
    let columns = |line: &str| line.split(',').count();
    let empty = ",".repeat(columns(new_head) - columns(head));
    assert!(new_head.starts_with(head), "{at}: {new_head}");
    for (old, new) in old.lines().zip(new.lines()).skip(1) {
        assert_eq!(format!("{old}{empty}"), new, "{at}");
    }
}

fn expected(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(directory.join("expected")).unwrap();
    let mut files: Vec<_> = entries
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, fs::read(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

/// The version of the simulation that the results of a directory were made by, and whether it is
/// an older one than today's, by which unfinished runs start again.
fn is_older(server: &Server) -> bool {
    let runs: Value = server.read("/v1/jobs/1/runs");
    let present: Value = server.read(&format!("{UNDER_WAY}/runs"));
    let version = |runs: &Value| runs["items"][0]["results_version"].as_u64().unwrap();
    version(&runs) < version(&present)
}

/// What was paused starts again under today's version.
fn forget_version_of_paused(runs: &mut Value) {
    for run in runs["items"].as_array_mut().unwrap() {
        if run["state"] == "paused" {
            run.as_object_mut().unwrap().remove("results_version");
        }
    }
}

/// Compares every answer, but for those about a run that starts again.
fn assert_answers(server: &Server, directory: &Path) {
    let is_older = is_older(server);
    let mut compared = 0;
    for (name, old) in expected(directory) {
        let Some(route) = route(&name) else { continue };
        let answer = server.get(&route);
        assert_eq!(answer.status, 200, "{name}: {}", answer.text());
        let is_about_it = name.starts_with("job-4") || name.contains(&run_under_way(directory));
        if is_older && is_about_it && !name.ends_with("spec") {
            continue;
        }
        match serde_json::from_slice::<Value>(&old) {
            Ok(mut old) => {
                let mut new: Value = answer.json();
                if is_older && name.ends_with("-runs.json") {
                    forget_version_of_paused(&mut old);
                }
                if is_older && name == "jobs.json" {
                    for page in [&mut old, &mut new] {
                        let jobs = page["items"].as_array_mut().unwrap();
                        jobs.retain(|job| job["id"] != "4");
                    }
                }
                assert_holds(&old, &new, &name);
            }
            Err(_) if name.ends_with("-summary.csv") => {
                assert_summary_holds(&table(&old), &table(&answer.body), &name);
            }
            Err(_) if name.ends_with("-metrics.csv") => {
                assert_metrics_hold(&table(&old), &table(&answer.body), &name);
            }
            Err(_) if name.ends_with(".csv") => {
                assert_eq!(table(&old), table(&answer.body), "{name}");
            }
            Err(_) => assert!(answer.body == old, "{name} has other bytes"),
        }
        compared += 1;
    }
    assert!(compared > 50, "{compared}");
    let job: Value = server.read(UNDER_WAY);
    assert_eq!(job["state"], "paused");
}

/// The file of what the run under way came to.
fn end_expected(directory: &Path) -> (String, Value) {
    let mut files = expected(directory).into_iter();
    let (name, end) = files
        .find(|(name, _)| name.ends_with("-result-when-done"))
        .unwrap();
    (name, serde_json::from_slice(&end).unwrap())
}

fn run_under_way(directory: &Path) -> String {
    let (name, _) = end_expected(directory);
    name.split('-').nth(1).unwrap().to_owned()
}

#[test]
fn directories_of_earlier_programs_answer_as_they_did() {
    for directory in directories() {
        let home = tempfile::tempdir().unwrap();
        copy(&directory.join("data"), &home.path().join("data"));
        // Twice: what is upgraded is opened again.
        for _ in 0..2 {
            let server = Server::start(home.path());
            assert_answers(&server, &directory);
            assert!(server.terminate().success());
        }
        let data = home.path().join("data");
        let checked = command::evswarm(&["check", "--data", data.to_str().unwrap()], "");
        assert_eq!(checked.code, Some(0), "{checked:?}");
    }
}

#[test]
fn the_run_under_way_of_an_earlier_program_comes_to_its_end() {
    for directory in directories() {
        let home = tempfile::tempdir().unwrap();
        copy(&directory.join("data"), &home.path().join("data"));
        let server = Server::start(home.path());
        let is_older = is_older(&server);
        let resumed = server.post(&format!("{UNDER_WAY}/resume"), &Value::Null);
        assert_eq!(resumed.status, 200);
        wait::until("the run under way", || {
            let job: Value = server.read(UNDER_WAY);
            assert!(job["state"] != "failed", "{job}");
            (job["state"] == "done").then_some(())
        });
        let (name, mut end) = end_expected(&directory);
        let run = run_under_way(&directory);
        if is_older {
            // It is what today's program makes of the spec, from the beginning.
            let spec: Value = server.read(&format!("/v1/runs/{run}/spec"));
            let anew = server.submit(&serde_json::json!({ "base": spec }));
            server.wait_for(&anew);
            let id = server.only_run(&anew).id;
            assert_ne!(id, run, "another version, another id");
            end = server.read(&format!("/v1/runs/{id}/result"));
        }
        assert_holds(&end, &server.read(&format!("/v1/runs/{run}/result")), &name);
    }
}

#[test]
fn damaged_findings_answer_as_damaged_and_the_rest_goes_on() {
    let directory = directories().remove(0);
    let home = tempfile::tempdir().unwrap();
    copy(&directory.join("data"), &home.path().join("data"));
    let server = Server::start(home.path());
    let runs: Value = server.read("/v1/jobs/1/runs");
    assert!(server.terminate().success());
    let id = |place: usize| runs["items"][place]["id"].as_str().unwrap();
    let database = Connection::open(home.path().join("data/evswarm.sqlite3")).unwrap();
    let change = |column: &str, new: &str, run: &str| {
        let sql = format!(
            "UPDATE results SET {column} = {new} WHERE run = (SELECT seq FROM runs WHERE id = ?1)"
        );
        assert_eq!(database.execute(&sql, [run]).unwrap(), 1);
    };
    change(
        "coverage",
        "substr(coverage, 1, length(coverage) - 1)",
        id(0),
    );
    change("metrics", "CAST(metrics || x'00' AS BLOB)", id(1));
    change(
        "result",
        "replace(result, '\"steps\":', '\"steps\":1')",
        id(2),
    );
    drop(database);

    let server = Server::start(home.path());
    for (place, file) in [
        (0, "coverage"),
        (0, "curve.csv"),
        (1, "metrics.csv"),
        (2, "result"),
    ] {
        let answer = server.get(&format!("/v1/runs/{}/{file}", id(place)));
        let problem = answer.problem(500);
        assert_eq!(problem.code, "damaged", "{file}");
        let detail = problem.detail.unwrap_or_default();
        assert!(detail.contains(id(place)), "{file}: {detail}");
    }
    let list: Value = server.read("/v1/jobs/1/runs");
    let state = |place: usize| list["items"][place]["state"].as_str().unwrap();
    assert_eq!(
        [state(0), state(1), state(2), state(3)],
        ["done", "done", "failed", "done"]
    );
    assert_eq!(
        server.get(&format!("/v1/runs/{}/coverage", id(3))).status,
        200
    );

    let data = home.path().join("data");
    let checked = command::evswarm(&["check", "--data", data.to_str().unwrap()], "");
    assert_eq!(checked.code, Some(1));
    assert_eq!(checked.stdout.lines().count(), 3, "{checked:?}");
    let copied = home.path().join("copy");
    let (data, copied) = (data.to_str().unwrap(), copied.to_str().unwrap());
    let backed_up = command::evswarm(&["backup", "--data", data, "--to", copied], "");
    assert_eq!(backed_up.code, Some(0), "{backed_up:?}");
    let checked = command::evswarm(&["check", "--data", copied], "");
    assert_eq!(checked.stdout.lines().count(), 3, "{checked:?}");
}
