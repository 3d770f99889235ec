//! Listeners hear every change of state, in order, whether they are slow or come back.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::events::{Event, StateChange};
use api::{Job, State};
use serde_json::json;
use tests::events::Heard;
use tests::server::Server;
use tests::{job, small_spec};

fn changes(heard: &[Heard]) -> Vec<StateChange> {
    heard
        .iter()
        .filter_map(|heard| match &heard.event {
            Event::State(change) => Some(change.clone()),
            _ => None,
        })
        .collect()
}

fn is_done(event: &Event) -> bool {
    matches!(event, Event::Run(run) if run.state == State::Done)
}

#[test]
fn a_run_is_followed_to_its_result() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = small_spec();
    spec["epochs"] = json!(3_000);
    spec["steps_per_epoch"] = json!(4_000);
    let posted = server.submit(&job(spec, 1));
    let run = server.only_run(&posted);
    let mut listener = server.listen(&format!("/v1/runs/{}/events", run.id), None);
    let heard = listener.until(is_done);
    assert!(matches!(&heard[0].event, Event::Run(first) if first.id == run.id));
    assert!(
        !heard[0].id.is_empty(),
        "the first event says where it stands"
    );
    let count = |name| {
        heard
            .iter()
            .filter(|heard| heard.event.name() == name)
            .count()
    };
    assert!(count("progress") >= 1 && count("coverage") >= 1 && count("metrics") >= 1);
    let states: Vec<State> = changes(&heard).iter().map(|change| change.state).collect();
    assert_eq!(states.last(), Some(&State::Done));
    let Event::Run(last) = &heard.last().unwrap().event else {
        panic!("{heard:?}");
    };
    assert_eq!(last.result, server.only_run(&posted).result);
}

/// Two runs that do not end by themselves.
fn endless(server: &Server) -> Job {
    let mut spec = small_spec();
    spec["epochs"] = json!(100_000);
    spec["steps_per_epoch"] = json!(2_000);
    server.submit(&job(spec, 2))
}

#[test]
fn whoever_comes_back_misses_no_change() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_with(home.path(), &["--threads", "1"]);
    let posted = endless(&server);
    let path = format!("/v1/jobs/{}/events", posted.id);
    let first = server.listen(&path, None).next().unwrap();
    assert!(matches!(&first.event, Event::Job(shown) if shown.id == posted.id));

    // While nobody listens: paused, resumed, cancelled.
    for what in ["pause", "resume", "cancel"] {
        let path = format!("/v1/jobs/{}/{what}", posted.id);
        let answer = server.send("POST", &path, &[], b"");
        assert_eq!(answer.status, 200, "{what}: {}", answer.text());
    }
    let is_over =
        |event: &Event| matches!(event, Event::Job(shown) if shown.state == State::Cancelled);
    let heard = server.listen(&path, Some(&first.id)).until(is_over);
    let of_second: Vec<State> = changes(&heard)
        .iter()
        .filter(|change| change.index == 1)
        .map(|change| change.state)
        .collect();
    assert_eq!(of_second, [State::Paused, State::Queued, State::Cancelled]);
    let ids: Vec<u64> = heard
        .iter()
        .filter_map(|heard| heard.id.parse().ok())
        .collect();
    assert!(ids.is_sorted(), "{ids:?}");
}

#[test]
fn a_slow_listener_hears_every_change_of_three_hundred_runs() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = small_spec();
    spec["epochs"] = json!(1);
    spec["steps_per_epoch"] = json!(10);
    let posted = server.submit(&job(spec, 300));
    let mut listener = server.listen(&format!("/v1/jobs/{}/events", posted.id), None);
    let first = listener.next().unwrap();
    let Event::Job(begun) = first.event else {
        panic!("{first:?}");
    };
    server.wait_for(&posted);
    // Only now does it read on.
    let heard = listener
        .until(|event| matches!(event, Event::Job(shown) if shown.runs.done == shown.runs.total));
    let done = changes(&heard)
        .iter()
        .filter(|change| change.state == State::Done)
        .count() as u64;
    assert_eq!(done, 300 - begun.runs.done);
}

/// Whether a job of this id has come so far.
fn is_job(event: &Event, id: &str, state: State) -> bool {
    matches!(event, Event::Job(shown) if shown.id == id && shown.state == state)
}

#[test]
fn whoever_listens_to_all_hears_of_every_job_and_of_one_run_more() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_with(home.path(), &["--threads", "1"]);
    let old = server.submit(&job(small_spec(), 1));
    server.wait_for(&old);
    let mut listener = server.listen("/v1/events", None);
    let first = listener.next().unwrap();
    assert!(is_job(&first.event, &old.id, State::Done), "{first:?}");
    assert!(!first.id.is_empty(), "it says where to go on from");

    let mut spec = small_spec();
    spec["epochs"] = json!(1_000_000);
    let long = server.submit(&job(spec, 1));
    let run = server.only_run(&long);
    // The progress of what runs is heard of, again and again.
    listener.until(|event| is_job(event, &long.id, State::Running));
    let further = |event: &Event| matches!(event, Event::Job(job) if job.progress > 0.0);
    listener.until(further);
    let path = format!("/v1/events?run={}", run.id);
    let mut nearer = server.listen(&path, Some(&first.id));
    let heard = nearer.until(|event| matches!(event, Event::Progress(_)));
    let begun = |heard: &Heard| matches!(&heard.event, Event::Run(shown) if shown.id == run.id);
    assert!(heard.iter().any(begun), "{heard:?}");
    assert!(
        changes(&heard)
            .iter()
            .any(|change| change.state == State::Running)
    );

    let cancel = format!("/v1/jobs/{}/cancel", long.id);
    assert_eq!(server.send("POST", &cancel, &[], b"").status, 200);
    let heard = listener.until(|event| is_job(event, &long.id, State::Cancelled));
    assert!(
        changes(&heard)
            .iter()
            .any(|change| change.run_id == run.id && change.state == State::Cancelled)
    );
    nearer.until(|event| matches!(event, Event::Run(shown) if shown.state == State::Cancelled));
    for gone in [&old, &long] {
        let path = format!("/v1/jobs/{}", gone.id);
        assert_eq!(server.send("DELETE", &path, &[], b"").status, 204);
        let heard = listener.until(|event| is_gone(event, &gone.id));
        assert!(!heard[heard.len() - 1].id.is_empty(), "{heard:?}");
    }
}

fn is_gone(event: &Event, id: &str) -> bool {
    matches!(event, Event::Gone(gone) if gone.job_id == id)
}

/// Deletions had no id, and whoever was away did not hear of them.
#[test]
fn whoever_comes_back_hears_of_jobs_that_were_deleted_meanwhile() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let [kept, gone] = [1, 2].map(|runs| server.submit(&job(small_spec(), runs)));
    server.wait_for(&kept);
    server.wait_for(&gone);
    let first = server.listen("/v1/events", None);
    let heard: Vec<Heard> = first.take(2).collect();
    let since = &heard[1].id;
    assert!(!since.is_empty(), "{heard:?}");
    let mut of_job = server.listen(&format!("/v1/jobs/{}/events", gone.id), None);
    let path = format!("/v1/jobs/{}", gone.id);
    assert_eq!(server.send("DELETE", &path, &[], b"").status, 204);
    assert!(
        of_job
            .by_ref()
            .all(|heard| !matches!(heard.event, Event::Gone(_)))
    );
    assert_eq!(server.get(&format!("{path}/events")).status, 404);
    assert_eq!(server.terminate().code(), Some(0));

    let server = Server::start(home.path());
    let mut back = server.listen("/v1/events", Some(since));
    let heard = back.until(|event| is_gone(event, &gone.id));
    let id = &heard[heard.len() - 1].id;
    assert!(id.parse::<u64>().unwrap() > since.parse().unwrap());
    // Once.
    let again = server.listen("/v1/events", Some(id));
    let mut spec = small_spec();
    spec["epochs"] = json!(2);
    let next = server.submit(&job(spec, 1));
    for mut listener in [back, again] {
        let heard = listener.until(|event| is_job(event, &next.id, State::Done));
        let is_told_again = heard.iter().any(|heard| is_gone(&heard.event, &gone.id));
        assert!(!is_told_again, "{heard:?}");
    }
}

#[test]
fn a_slow_listener_to_all_hears_every_change_of_six_hundred_runs() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut listener = server.listen("/v1/events", None);
    let first = {
        let posted = server.submit(&job(small_spec(), 1));
        let heard = listener.until(|event| is_job(event, &posted.id, State::Done));
        heard
            .iter()
            .rev()
            .find_map(|heard| Some(heard.id.clone()).filter(|id| !id.is_empty()))
    };
    let mut spec = small_spec();
    spec["epochs"] = json!(1);
    let posted = [10, 11].map(|steps| {
        spec["steps_per_epoch"] = json!(steps);
        server.submit(&job(spec.clone(), 300))
    });
    for job in &posted {
        server.wait_for(job);
    }
    // Only now does one read on, and another come back.
    for mut listener in [listener, server.listen("/v1/events", first.as_deref())] {
        let mut done = 0;
        while done < 600 {
            let heard = listener.next().unwrap();
            done += changes(&[heard])
                .iter()
                .filter(|change| change.state == State::Done)
                .count();
        }
        assert_eq!(done, 600);
    }
}

#[test]
fn what_cannot_be_listened_to_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    server.get("/v1/jobs/7/events").problem(404);
    server.get("/v1/runs/7/events").problem(404);
    server.get("/v1/events?run=7").problem(404);
    server.get("/v1/events?job=7").problem(400);
    let posted = server.submit(&job(small_spec(), 1));
    for another in ["+1", "01", "1x"] {
        server.get(&format!("/v1/jobs/{another}")).problem(404);
    }
    let path = format!("/v1/jobs/{}/events", posted.id);
    for wrong in ["x", "-1", "+1", ""] {
        let heard = [("last-event-id", wrong)];
        server
            .send("GET", &path, &heard, b"")
            .refused("a `Last-Event-ID` that is no number");
    }
}

#[test]
fn the_stream_of_a_deleted_run_ends() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start_with(home.path(), &["--threads", "1"]);
    // One that is stepped, and one that waits.
    let posted = endless(&server);
    for run in server.runs(&posted) {
        let mut listener = server.listen(&format!("/v1/runs/{}/events", run.id), None);
        assert!(listener.next().is_some());
        let answer = server.send("DELETE", &format!("/v1/runs/{}", run.id), &[], b"");
        assert_eq!(answer.status, 204, "{}", answer.text());
        while listener.next().is_some() {}
    }
}

/// As of another data directory: an older backup, for one.
#[test]
fn whoever_comes_back_with_a_number_from_the_future_hears_of_what_comes() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut listener = server.listen("/v1/events", Some("1000000"));
    let posted = server.submit(&job(small_spec(), 1));
    let run = server.only_run(&posted).id;
    let is_done = |event: &Event| matches!(event, Event::State(change) if change.run_id == run && change.state == State::Done);
    listener.until(is_done);
}
