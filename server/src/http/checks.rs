//! `/v1/checks/arena` and `/v1/checks/job`: documents looked at before they are posted.

use api::checks::{ArenaCheck, GateCheck, JobCheck};
use arenas::{Arena, SvgOptions};
use axum::Json;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;

use super::App;
use super::arenas::listing;
use super::operation::{Operation, Shape};
use super::refusal::Refusal;
use super::request::said_to_be_json;
use super::routes::Routes;
use crate::documents::{ExpandedJob, ResolvedRun, expand, read_arena};
use crate::scheduler::{StoredArenas, step_cost};

/// Most walls that are shown.
const MAX_WALLS: usize = 10_000;
/// Most gates that are shown.
const MAX_GATES: usize = 100;
/// How much wider or narrower than the robot a gate is that is shown.
const GATE_WITHIN_M: f64 = 0.005;
/// Most combinations whose memory is looked at.
const MAX_COMBINATIONS: usize = 2_000;
/// Processor time of a robot-step where none was measured, nanoseconds.
const ASSUMED_STEP_NS: f64 = 300.0;
/// Bytes of a robot's body and of a square with what is counted of it.
const BODY_BYTES: u64 = 200;
const SQUARE_BYTES: u64 = 24;

pub fn routes() -> Routes {
    Routes::new()
        .post(
            "/checks/arena",
            arena,
            Operation::new("checkArena", "What an arena is like, without storing it")
                .details("Reach and gates are those of the default robot, from all starts.")
                .takes(Shape::Document("Arena"))
                .shows::<ArenaCheck>("The arena is valid."),
        )
        .post(
            "/checks/job",
            job,
            Operation::new("checkJob", "What a job would take, without storing it")
                .details(
                    "Runs, robot-steps, memory, and about how long: by what runs of the same \
                     methods and engines took here, where there are any.",
                )
                .takes(Shape::Document("JobSpec"))
                .shows::<JobCheck>("The job is valid."),
        )
}

/// `POST /v1/checks/arena`.
async fn arena(
    State(app): State<App>,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Json<ArenaCheck>, Refusal> {
    said_to_be_json(&headers)?;
    app.blocking(move |app| {
        let document = app.read(&body)?;
        let arena = read_arena(&document).map_err(Refusal::fields)?;
        Ok(Json(checked(&arena)))
    })
    .await
}

/// The squares of an arena row by row, `1` where the mask says so.
pub(super) fn rows(mask: &[bool], arena: &Arena) -> Vec<String> {
    let [columns, _] = arena.squares();
    let letter = |&within: &bool| if within { '1' } else { '0' };
    mask.chunks(columns.max(1) as usize)
        .map(|row| row.iter().map(letter).collect())
        .collect()
}

fn checked(arena: &Arena) -> ArenaCheck {
    let radius_m = SvgOptions::default().body_radius_m;
    let starts: Vec<_> = arena
        .starts()
        .iter()
        .map(|start| start.position())
        .collect();
    let reachable = arenas::reachable_from(arena, &starts, radius_m);
    let gates = arenas::gates_at_the_limit(arena, radius_m, GATE_WITHIN_M);
    ArenaCheck {
        arena: listing(arena, false, reachable.count),
        walls_m: arena
            .walls()
            .iter()
            .take(MAX_WALLS)
            .map(|wall| [wall.a.x, wall.a.y, wall.b.x, wall.b.y])
            .collect(),
        reachable_rows: rows(&reachable.mask, arena),
        gates: gates
            .iter()
            .take(MAX_GATES)
            .map(|gate| GateCheck {
                x_m: gate.at.x,
                y_m: gate.at.y,
                width_m: gate.width_m,
                is_open: gate.open,
            })
            .collect(),
    }
}

/// `POST /v1/checks/job`.
async fn job(
    State(app): State<App>,
    headers: HeaderMap,
    body: Bytes,
) -> Result<Json<JobCheck>, Refusal> {
    said_to_be_json(&headers)?;
    app.blocking(move |app| {
        let arenas = StoredArenas::new(&app.store);
        let document = app.read(&body)?;
        let job = expand(&document, &arenas).map_err(Refusal::fields)?;
        let limits = &app.scheduler.config().recordings;
        limits.check_job(&job.runs).map_err(Refusal::fields)?;
        Ok(Json(estimate(app, &job)?))
    })
    .await
}

fn estimate(app: &App, job: &ExpandedJob) -> Result<JobCheck, Refusal> {
    let workers = app.scheduler.worker_count().max(1);
    let (mut robot_steps, mut total_ns, mut longest_ns) = (0_u64, 0.0, 0.0_f64);
    let mut is_measured = true;
    let mut costs = std::collections::BTreeMap::new();
    for run in &job.runs {
        let kind = (run.method().name(), step_cost(run.engine()));
        let cost_ns = match costs.get(&kind) {
            Some(&cost_ns) => cost_ns,
            None => {
                let measured = app.store.recent_cost(kind.0, kind.1)?;
                is_measured &= measured.is_some();
                let cost_ns = measured.unwrap_or(ASSUMED_STEP_NS * f64::from(kind.1));
                *costs.entry(kind).or_insert(cost_ns)
            }
        };
        let run_ns = run.robot_steps() as f64 * cost_ns;
        robot_steps = robot_steps.saturating_add(run.robot_steps());
        total_ns += run_ns;
        longest_ns = longest_ns.max(run_ns);
    }
    let firsts = firsts(job);
    let (mut robots, mut learner_bytes, mut run_bytes) = (0, 0, 0);
    for run in firsts.iter().take(MAX_COMBINATIONS) {
        let spec = run.run_spec();
        let learner = spec.memory_plan().bytes;
        let [columns, rows] = run.arena().squares();
        let squares = u64::from(columns) * u64::from(rows);
        robots = robots.max(spec.robots);
        learner_bytes = learner_bytes.max(learner);
        let of_robots = u64::from(spec.robots).saturating_mul(learner + BODY_BYTES);
        run_bytes = run_bytes.max(of_robots.saturating_add(squares * SQUARE_BYTES));
    }
    Ok(JobCheck {
        runs: job.runs.len() as u64,
        combinations: firsts.len() as u64,
        robot_steps,
        robots,
        learner_bytes,
        run_bytes,
        time_s: (total_ns / workers as f64).max(longest_ns) * 1e-9,
        is_measured,
        workers: workers as u64,
    })
}

/// The first run of each combination.
fn firsts(job: &ExpandedJob) -> Vec<&ResolvedRun> {
    let mut rest = job.runs.as_slice();
    let mut firsts = Vec::new();
    for design in &job.designs {
        let seeds = design.seeds.max(1);
        let (part, after) = rest.split_at((design.combinations() * seeds).min(rest.len()));
        firsts.extend(part.iter().step_by(seeds));
        rest = after;
    }
    firsts
}
