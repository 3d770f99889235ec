//! Which runs the experiments need: the template `chapter-5` cut to the settings, and for claim 9
//! Ev-ITER-C with shorter first phases.

use std::path::{Path, PathBuf};

use api::FieldError;
use serde_json::{Value, json};
use swarm::spec::EngineKind;

use crate::spec::{self, BuiltinArenas, ResolvedRun};

/// The arena, method and first phases of claim 9.
pub(super) const SHORT_PHASE_ARENA: &str = "maze";
/// As above.
pub(super) const SHORT_PHASE_METHOD: &str = "ev-iter-c";
/// As above, epochs; the template has 200.
pub(super) const SHORT_PHASES: [u32; 2] = [20, 50];

/// The main comparison, which is repeated under the engine rapier.
pub(super) const ENGINE_METHODS: [&str; 3] = ["im", "ev-iter-c", "curiosity-a"];

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
    /// Seeds of the main comparison under the engine rapier; at most `seeds`, 0 leaves it out.
    pub rapier_seeds: u32,
}

/// All runs, in the order of the report.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What was asked for.
    pub settings: Settings,
    /// The runs; no two with the same key.
    pub runs: Vec<PlannedRun>,
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

impl PlannedRun {
    /// The run's result directory inside that of the whole.
    pub fn directory(&self, out: &Path) -> PathBuf {
        out.join("runs").join(self.spec.key())
    }
}

/// Label of Ev-ITER-C with a first phase of so many epochs.
pub(super) fn short_phase_label(epochs: u32) -> String {
    format!("{SHORT_PHASE_METHOD}:{epochs}")
}

impl Plan {
    /// The runs of these settings.
    ///
    /// # Errors
    /// Every setting that cannot be used, with its place in the job that it would make.
    pub fn new(settings: Settings) -> Result<Self, Vec<FieldError>> {
        let base = json!({
            "epochs": settings.epochs,
            "steps_per_epoch": settings.steps_per_epoch,
        });
        let seeds = json!({ "first": 1, "count": settings.seeds });
        let job = json!({
            "template": "chapter-5",
            "base": base,
            "matrix": { "arena": settings.arenas, "controller.method": methods() },
            "seeds": seeds,
        });
        let mut runs = expanded(&job, |spec| spec.method().name().to_owned())?;
        if settings.arenas.iter().any(|name| name == SHORT_PHASE_ARENA) {
            for epochs in SHORT_PHASES {
                let mut base = base.clone();
                base["arena"] = Value::from(SHORT_PHASE_ARENA);
                base["controller"] =
                    json!({ "method": SHORT_PHASE_METHOD, "train": { "epochs": epochs } });
                let job = json!({ "base": base, "seeds": seeds });
                runs.extend(expanded(&job, |_| short_phase_label(epochs))?);
            }
        }
        if settings.rapier_seeds > 0 {
            let mut base = base;
            base["engine"] = Value::from(EngineKind::Rapier.name());
            let job = json!({
                "template": "chapter-5",
                "base": base,
                "matrix": { "arena": settings.arenas, "controller.method": ENGINE_METHODS },
                "seeds": { "first": 1, "count": settings.rapier_seeds.min(settings.seeds) },
            });
            runs.extend(expanded(&job, |spec| spec.method().name().to_owned())?);
        }
        Ok(Self { settings, runs })
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
        format!(
            "evswarm reproduce --out DIR --seeds {seeds} --epochs {epochs} --arenas {arenas} \
             --rapier-seeds {rapier_seeds}"
        )
    }
}

/// The methods of the template, in its order.
fn methods() -> Value {
    spec::templates()
        .into_iter()
        .find(|template| template.name == "chapter-5")
        .map_or(Value::Null, |template| {
            template.job["matrix"]["controller.method"].clone()
        })
}

fn expanded(
    job: &Value,
    method: impl Fn(&ResolvedRun) -> String,
) -> Result<Vec<PlannedRun>, Vec<FieldError>> {
    let runs = spec::expand(job, &BuiltinArenas)?.runs;
    Ok(runs
        .into_iter()
        .map(|spec| PlannedRun {
            arena: spec.arena().name().to_owned(),
            method: method(&spec),
            engine: spec.engine(),
            spec,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
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

    #[test]
    fn the_whole_is_the_template_and_the_short_phases() {
        let plan = Plan::new(settings(&["easy", "graph", "maze"])).unwrap();
        assert_eq!(plan.runs.len(), 450 + 30);
        assert_eq!(plan.methods().len(), 12);
        let template = spec::expand(&json!({ "template": "chapter-5" }), &BuiltinArenas).unwrap();
        let keys = |runs: &[PlannedRun]| -> Vec<String> {
            runs.iter().map(|run| run.spec.key()).collect()
        };
        let of_template: Vec<String> = template.runs.iter().map(ResolvedRun::key).collect();
        assert_eq!(keys(&plan.runs[..450]), of_template);
        let mut all = keys(&plan.runs);
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 480);
        let last = plan.runs.last().unwrap();
        assert_eq!(
            (last.arena.as_str(), last.method.as_str()),
            ("maze", "ev-iter-c:50")
        );
        let training = last.spec.run_spec().controller.training.unwrap();
        assert_eq!((training.arena.name(), training.epochs), ("easy", 50));
    }

    #[test]
    fn the_main_comparison_is_repeated_under_rapier() {
        let plan = Plan::new(Settings {
            rapier_seeds: 5,
            ..settings(&["easy", "maze"])
        })
        .unwrap();
        let rapier = |run: &&PlannedRun| run.engine == EngineKind::Rapier;
        assert_eq!(plan.runs.iter().filter(rapier).count(), 2 * 3 * 5);
        assert_eq!(plan.methods().len(), 12);
        let run = plan.runs.iter().find(rapier).unwrap().spec.run_spec();
        assert_eq!(run.engine, EngineKind::Rapier);
    }

    #[test]
    fn short_phases_belong_to_the_maze() {
        assert_eq!(Plan::new(settings(&["easy"])).unwrap().runs.len(), 150);
    }

    #[test]
    fn an_arena_that_does_not_exist_is_pointed_at() {
        let errors = Plan::new(settings(&["easy", "amaze"])).unwrap_err();
        assert_eq!(errors[0].pointer, "/matrix/arena/1");
    }
}
