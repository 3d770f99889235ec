//! The README's way through the service: post a job, see it move, read what it found in every form.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use api::{Coverage, CurveRow, Job, RunResult, RunSpec, RunSummary, State};
use serde_json::{Value, json};
use tests::files::npy;
use tests::server::Server;
use tests::{readme, wait};

#[test]
fn the_first_job_of_the_readme_is_the_one_that_make_run_posts() {
    let file = std::fs::read_to_string(readme::root().join("experiments/first-job.json")).unwrap();
    assert!(readme::text().contains(file.trim()));
    let mut job: Value = serde_json::from_str(&file).unwrap();

    // The same, only shorter.
    job["base"]["epochs"] = json!(20);
    job["base"]["controller"]["train"]["epochs"] = json!(10);
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let answer = server.post("/v1/jobs", &job);
    assert_eq!(answer.status, 201, "{}", answer.text());
    let posted: Job = answer.json();
    assert_eq!(answer.header("location"), format!("/v1/jobs/{}", posted.id));
    assert_eq!((posted.name.as_str(), posted.runs.total), ("first job", 3));

    let done = server.wait_for(&posted);
    assert_eq!((done.progress, done.runs.done), (1.0, 3));
    assert_eq!(done.created_at, posted.created_at);
    let runs = server.runs(&done);
    assert_eq!(
        runs.iter().map(|run| run.seed).collect::<Vec<_>>(),
        [1, 2, 3]
    );
    for run in &runs {
        agrees_with_itself(&server, run, 20);
    }
    let states: Vec<_> = runs.iter().map(sha256).collect();
    assert!(
        states[0] != states[1] && states[1] != states[2],
        "seeds differ"
    );
}

fn sha256(run: &RunSummary) -> String {
    run.result.as_ref().unwrap().state_sha256.clone()
}

/// Everything that can be asked of a finished run tells the same.
fn agrees_with_itself(server: &Server, run: &RunSummary, epochs: u32) {
    let path = |suffix: &str| format!("/v1/runs/{}{suffix}", run.id);
    assert_eq!(server.read::<RunSummary>(&path("")), *run);
    assert_eq!(run.state, State::Done);
    let progress = run.progress.as_ref().unwrap();
    assert_eq!((progress.fraction, progress.epochs_done), (1.0, epochs));

    let result: RunResult = server.read(&path("/result"));
    assert_eq!(Some(&result), run.result.as_ref());
    assert_eq!(result.steps, progress.robot_steps_total);
    assert!(result.p1 > result.p10 && result.p10 > 0, "{result:?}");
    assert!(result.p1 <= 10_000 && result.reachable > 3_000);
    let share = f64::from(result.p1) / f64::from(result.reachable);
    assert!(result.fractions.p1 <= share.min(1.0), "{result:?}");
    // Squares at walls of which the centre can only be in a part are entered and may not count.
    assert!(result.fractions.p1 > 0.8 * share, "{result:?}");
    assert_eq!(result.state_sha256.len(), 64);
    let spec: RunSpec = server.read(&path("/spec"));
    assert_eq!((spec.seed, spec.epochs), (Some(run.seed), Some(epochs)));
    assert!(spec.controller.unwrap().parameters.contains_key("alpha"));

    let curve: Vec<CurveRow> = server.read(&path("/curve"));
    assert_eq!(curve.len(), epochs as usize);
    let last = curve.last().unwrap();
    let counts = (result.p1, result.p2, result.p5, result.p10);
    assert_eq!((last.p1, last.p2, last.p5, last.p10), counts);
    assert!(curve.is_sorted_by_key(|row| (row.epoch, row.p1, row.p10)));
    let csv = server.get(&path("/curve.csv"));
    let written: Vec<String> = std::iter::once("epoch,p1,p2,p5,p10".to_owned())
        .chain(curve.iter().map(
            |CurveRow {
                 epoch,
                 p1,
                 p2,
                 p5,
                 p10,
             }| { format!("{epoch},{p1},{p2},{p5},{p10}") },
        ))
        .collect();
    assert_eq!(csv.text().lines().collect::<Vec<_>>(), written);

    let coverage: Coverage = server.read(&path("/coverage"));
    assert_eq!(
        (coverage.p1, coverage.p2, coverage.p5, coverage.p10),
        counts
    );
    assert_eq!(
        (coverage.reachable, coverage.fractions),
        (result.reachable, result.fractions)
    );
    let visits: Vec<u32> = coverage.visits.concat();
    assert_eq!(npy(&server.get(&path("/coverage.npy")).body, 100), visits);
    let from = |least: u32| visits.iter().filter(|&&count| count >= least).count();
    assert_eq!(
        (from(1), from(10)),
        (result.p1 as usize, result.p10 as usize)
    );
    let dwell = npy(&server.get(&path("/dwell.npy")).body, 100);
    let steps: u64 = dwell.iter().map(|&steps| u64::from(steps)).sum();
    assert_eq!(steps, u64::from(epochs) * 2_000);

    let csv = server.get(&path("/coverage.csv"));
    let mut written = vec![0; visits.len()];
    for line in csv.text().lines().skip(1) {
        let numbers: Vec<usize> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        written[numbers[1] * 100 + numbers[0]] = u32::try_from(numbers[2]).unwrap();
    }
    assert_eq!(written, visits);
    assert!(colours(&server.get(&path("/coverage.png")).body) > 4);
    let svg = server.get(&path("/coverage.svg"));
    assert!(svg.header("content-type").starts_with("image/svg+xml"));
    assert!(svg.text().trim_end().ends_with("</svg>"));
}

/// How many colours a picture has.
fn colours(png: &[u8]) -> usize {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let bytes = info.color_type.samples();
    let colours: std::collections::BTreeSet<&[u8]> =
        pixels[..info.buffer_size()].chunks_exact(bytes).collect();
    colours.len()
}

#[test]
fn a_running_run_shows_progress_and_a_curve_that_grows() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::start(home.path());
    let mut spec = tests::small_spec();
    spec["epochs"] = json!(100_000);
    spec["steps_per_epoch"] = json!(2_000);
    let job = server.submit(&tests::job(spec, 1));
    let seen = |least: usize| {
        wait::until("a longer curve", || {
            let run = server.only_run(&job);
            let curve: Vec<CurveRow> = server.read(&format!("/v1/runs/{}/curve", run.id));
            (curve.len() > least).then_some((run, curve))
        })
    };
    let (_, first) = seen(0);
    let (run, second) = seen(first.len());
    assert_eq!(second[..first.len()], first);
    let progress = run.progress.unwrap();
    assert_eq!((run.state, run.result), (State::Running, None));
    assert!(progress.fraction > 0.0 && progress.fraction < 1.0);
    assert_eq!(progress.phase, "exploration");
    let job: Job = wait::until("an estimate", || {
        let job: Job = server.read(&format!("/v1/jobs/{}", job.id));
        job.eta_s.is_some().then_some(job)
    });
    assert!(job.progress > 0.0 && job.eta_s.unwrap() > 0.0);
    assert!(job.robot_steps_per_s.unwrap() > 10_000.0);
    let thin: Vec<CurveRow> = server.read(&format!("/v1/runs/{}/curve?points=2", run.id));
    assert_eq!(thin.len(), 2);
}
