//! Which runs the experiments need: the template `chapter-5` cut to the settings.

use anyhow::Context;
use api::{FieldError, RunSpec};
use serde_json::{Map, Value};
use swarm::spec::EngineKind;

use crate::documents::{
    self, BuiltinArenas, ExpandedJob, ResolvedRun, SHORT_PHASE_METHOD, SHORT_PHASES, chapter_5,
};
use crate::store::{JobKey, RunView, Store};

/// Most runs of a stored job that is looked at.
const MAX_RUNS: usize = 20_000;

/// What to reproduce.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Runs of each method on each arena; seeds count from 1.
    pub seeds: u32,
    /// Counted epochs of a run.
    pub epochs: u32,
    /// Steps of an epoch; 2,000 in the thesis.
    pub steps_per_epoch: u32,
    /// Names of built-in arenas, each once.
    pub arenas: Vec<String>,
    /// Seeds of the main comparison under the engine rapier; 0 leaves it out.
    pub rapier_seeds: u32,
}

/// All runs, in the order of the report.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What was asked for.
    pub settings: Settings,
    /// The runs; no two with the same key.
    pub runs: Vec<PlannedRun>,
    /// Fields that every run has beside the settings.
    pub base: Map<String, Value>,
}

/// One run and where it belongs.
#[derive(Clone, Debug)]
pub struct PlannedRun {
    /// The arena's name.
    pub arena: String,
    /// The method's name; with a shorter first phase its epochs after a colon.
    pub method: String,
    /// Which physics moved its robot.
    pub engine: EngineKind,
    /// The run.
    pub spec: ResolvedRun,
}

/// Label of Ev-ITER-C with a first phase of so many epochs.
pub(super) fn short_phase_label(epochs: u32) -> String {
    format!("{SHORT_PHASE_METHOD}:{epochs}")
}

impl Settings {
    /// The job of these settings.
    ///
    /// # Errors
    /// Every setting that cannot be used, with its place in the job.
    pub fn job(&self) -> Result<ExpandedJob, Vec<FieldError>> {
        self.job_over(&Map::new())
    }

    /// The job of these settings with other fields of every run, as a run spec has them.
    ///
    /// # Errors
    /// As [`Settings::job`].
    pub fn job_over(&self, fields: &Map<String, Value>) -> Result<ExpandedJob, Vec<FieldError>> {
        documents::expand(&self.document(fields), &BuiltinArenas)
    }

    /// That job as it would be posted.
    pub fn document(&self, fields: &Map<String, Value>) -> Value {
        let arenas: Vec<&str> = self.arenas.iter().map(String::as_str).collect();
        let mut base = Value::Object(fields.clone());
        base["epochs"] = self.epochs.into();
        base["steps_per_epoch"] = self.steps_per_epoch.into();
        let mut job = chapter_5(&arenas, base, self.seeds, self.rapier_seeds);
        job["name"] = documents::CHAPTER_5.into();
        job
    }

    /// The settings of which these could be the runs, in the order of the job.
    pub fn of_runs(runs: &[RunSpec]) -> Option<Self> {
        let mut settings = Self {
            seeds: 0,
            epochs: runs.first()?.epochs?,
            steps_per_epoch: runs.first()?.steps_per_epoch?,
            arenas: Vec::new(),
            rapier_seeds: 0,
        };
        for run in runs {
            let Some(api::ArenaRef::Name(arena)) = &run.arena else {
                return None;
            };
            let seed = u32::try_from(run.seed?).ok()?;
            let rapier = run.engine.as_deref() == Some(EngineKind::Rapier.name());
            let seeds = if rapier {
                &mut settings.rapier_seeds
            } else {
                &mut settings.seeds
            };
            *seeds = seed.max(*seeds);
            if !settings.arenas.contains(arena) {
                settings.arenas.push(arena.clone());
            }
        }
        // Every seed from 1 on has a run: more cannot be.
        let most = settings.seeds.max(settings.rapier_seeds) as usize;
        (most <= runs.len()).then_some(settings)
    }
}

impl Plan {
    /// The plan that a stored job carried out; `None` if its runs are not exactly those of one.
    ///
    /// # Errors
    /// When the store fails or holds what cannot be read.
    pub fn of_job(job: JobKey, runs: &[RunView], store: &Store) -> anyhow::Result<Option<Self>> {
        if runs.len() > MAX_RUNS {
            return Ok(None);
        }
        let spec = |run: &RunView| {
            let text = store.spec(run.seq)?.context("a run is gone")?;
            serde_json::from_str(&text).context("a stored spec cannot be read")
        };
        let specs = runs.iter().map(spec).collect::<anyhow::Result<Vec<_>>>()?;
        let Some(settings) = Settings::of_runs(&specs) else {
            return Ok(None);
        };
        let document = store.document(job)?;
        let bases = [Map::new(), document.map(fields_of_all).unwrap_or_default()];
        for base in bases {
            let Ok(job) = settings.job_over(&base) else {
                continue;
            };
            let keys = job.runs.iter().map(ResolvedRun::key);
            if keys.eq(runs.iter().map(|run| run.id.as_str())) {
                return Ok(Some(Self::new(settings, &job).over(base)));
            }
        }
        Ok(None)
    }

    /// The runs of a job of these settings.
    pub fn new(settings: Settings, job: &ExpandedJob) -> Self {
        let runs = job.runs.iter().map(|spec| PlannedRun {
            arena: spec.arena().name().to_owned(),
            method: label(spec),
            engine: spec.engine(),
            spec: spec.clone(),
        });
        Self {
            runs: runs.collect(),
            settings,
            base: Map::new(),
        }
    }

    /// The same, made with other fields of every run ([`Settings::job_over`]).
    #[must_use]
    pub fn over(self, base: Map<String, Value>) -> Self {
        Self { base, ..self }
    }

    /// Labels of the methods, each once, in the order of the report.
    pub fn methods(&self) -> Vec<&str> {
        let mut methods: Vec<&str> = Vec::new();
        for run in &self.runs {
            if !methods.contains(&run.method.as_str()) {
                methods.push(&run.method);
            }
        }
        methods
    }

    /// The command that makes this plan, without what changes no result.
    pub fn command(&self) -> String {
        let Settings {
            seeds,
            epochs,
            arenas,
            rapier_seeds,
            ..
        } = &self.settings;
        let arenas = arenas.join(",");
        let base = if self.base.is_empty() {
            ""
        } else {
            " --base BASE.json"
        };
        format!(
            "evswarm reproduce --out DIR --seeds {seeds} --epochs {epochs} --arenas {arenas} \
             --rapier-seeds {rapier_seeds}{base}"
        )
    }
}

/// The `base` of a job's document without what settings say or each part has of its own.
fn fields_of_all(document: String) -> Map<String, Value> {
    let Ok(Value::Object(mut document)) = serde_json::from_str(&document) else {
        return Map::new();
    };
    let Some(Value::Object(mut base)) = document.remove("base") else {
        return Map::new();
    };
    base.retain(|field, _| !["epochs", "steps_per_epoch", "arena"].contains(&field.as_str()));
    base
}

fn label(run: &ResolvedRun) -> String {
    let spec = run.run_spec();
    let epochs = spec
        .controller
        .training
        .as_ref()
        .map(|training| training.epochs);
    let short = epochs.filter(|epochs| SHORT_PHASES.contains(epochs));
    match short {
        Some(epochs) if run.method().name() == SHORT_PHASE_METHOD => short_phase_label(epochs),
        _ => run.method().name().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::json;

    use super::*;

    fn settings(arenas: &[&str]) -> Settings {
        Settings {
            seeds: 15,
            epochs: 2_000,
            steps_per_epoch: 2_000,
            arenas: arenas.iter().map(|&name| name.to_owned()).collect(),
            rapier_seeds: 0,
        }
    }

    fn plan(settings: Settings) -> Plan {
        let job = settings.job().unwrap();
        Plan::new(settings, &job)
    }

    #[test]
    fn the_whole_is_the_template() {
        let whole = Settings {
            rapier_seeds: 5,
            ..settings(&["easy", "graph", "maze"])
        };
        let plan = plan(whole.clone());
        assert_eq!(plan.runs.len(), 450 + 30 + 45);
        assert_eq!(plan.methods().len(), 12);
        let template =
            documents::expand(&json!({ "template": "chapter-5" }), &BuiltinArenas).unwrap();
        let keys: Vec<String> = plan.runs.iter().map(|run| run.spec.key()).collect();
        let of_template: Vec<String> = template.runs.iter().map(ResolvedRun::key).collect();
        assert_eq!(keys, of_template);
        let last_short = &plan.runs[479];
        assert_eq!(
            (last_short.arena.as_str(), last_short.method.as_str()),
            ("maze", "ev-iter-c:50")
        );
        let training = last_short
            .spec
            .run_spec()
            .controller
            .training
            .clone()
            .unwrap();
        assert_eq!((training.arena.name(), training.epochs), ("easy", 50));

        let specs: Vec<RunSpec> = template.runs.iter().map(ResolvedRun::canonical).collect();
        assert_eq!(Settings::of_runs(&specs), Some(whole));
        assert_eq!(Settings::of_runs(&[]), None);
        assert_eq!(Settings::of_runs(&specs[14..15]), None, "seed 15 alone");
    }

    #[test]
    fn the_main_comparison_is_repeated_under_rapier() {
        let plan = plan(Settings {
            rapier_seeds: 5,
            ..settings(&["easy", "maze"])
        });
        let rapier = |run: &&PlannedRun| run.engine == EngineKind::Rapier;
        assert_eq!(plan.runs.iter().filter(rapier).count(), 2 * 3 * 5);
        let run = plan.runs.iter().find(rapier).unwrap().spec.run_spec();
        assert_eq!(run.engine, EngineKind::Rapier);
    }

    #[test]
    fn every_run_has_the_fields_of_the_base() {
        let settings = settings(&["easy", "maze"]);
        let base = json!({
            "controller": { "preset": "printed" }, "robot": { "contact_friction": 0.25 }, "epochs": 3
        });
        let base = base.as_object().unwrap();
        let job = settings.job_over(base).unwrap();
        let plain = settings.job().unwrap();
        assert_eq!(job.runs.len(), plain.runs.len());
        for (run, plain) in job.runs.iter().zip(&plain.runs) {
            let spec = run.run_spec();
            assert_eq!(spec.robot.parameters.contact_friction, 0.25);
            assert_eq!(spec.epochs, 2_000, "the settings say how many");
            assert_ne!(run.key(), plain.key());
        }
        let wrong = json!({ "robot": { "friction": 1 } });
        let errors = settings.job_over(wrong.as_object().unwrap()).unwrap_err();
        assert!(errors[0].pointer.ends_with("/robot/friction"), "{errors:?}");
        let command = Plan::new(settings, &job).over(base.clone()).command();
        assert!(
            command.ends_with("--rapier-seeds 0 --base BASE.json"),
            "{command}"
        );
    }

    #[test]
    fn short_phases_belong_to_the_maze() {
        assert_eq!(plan(settings(&["easy"])).runs.len(), 150);
    }

    #[test]
    fn an_arena_that_does_not_exist_is_pointed_at() {
        let errors = settings(&["easy", "amaze"]).job().unwrap_err();
        assert_eq!(errors[0].pointer, "/parts/0/matrix/arena/1");
    }
}
