//! Runs that are recorded: robots that learn, in the arenas of the scaling benchmarks, stepped on
//! and on.

use std::path::Path;

use anyhow::{Result, anyhow, bail};
use serde_json::{Value, json};
use server::documents::{BuiltinArenas, ResolvedRun, asked_recording, resolve};
use server::recording::{Paths, Recorder, SharedRecorder, finish, header};
use server::runner::{self, Ended, PauseAt};
use swarm::run::{Phase, Run};

use crate::cases::scaled_arena;

/// Steps of an epoch.
pub const STEPS: u32 = 500;

/// A run that stands at the beginning of an epoch.
pub struct Subject {
    pub spec: ResolvedRun,
    pub run: Run,
}

impl Subject {
    /// So many robots, which explore by what they have learnt.
    pub fn new(robots: u64) -> Result<Self> {
        let arena = serde_json::to_value(scaled_arena(robots)?.to_format())?;
        let spec = json!({
            "arena": arena, "robots": robots, "steps_per_epoch": STEPS, "epochs": 1_000_000,
            "placement": if robots == 1 { "start" } else { "random" }, "seed": 1,
            "controller": { "method": "im", "babbling_epochs": 1, "sample": 1_024 },
        });
        let spec = resolve(&spec, &BuiltinArenas).map_err(|errors| anyhow!("{errors:?}"))?;
        let mut run = Run::new(spec.run_spec()).map_err(|errors| anyhow!("{errors:?}"))?;
        while run.progress().phase != Phase::Exploration {
            run.advance(u64::from(STEPS));
        }
        if run.place().step != 0 {
            bail!("the run does not stand at the beginning of an epoch");
        }
        Ok(Self { spec, run })
    }

    /// Steps so many epochs, recording nothing.
    pub fn step(&mut self, epochs: u64) -> Result<()> {
        let to = self.run.step() + epochs * u64::from(STEPS);
        let ended = runner::step(&mut self.run, &|| false, &mut [&mut PauseAt(to)]);
        stopped(&ended)
    }

    /// Steps so many epochs and records them, to the last byte written; how many bytes.
    pub fn record(&mut self, epochs: u64, asked: &Value, folder: &Path) -> Result<u64> {
        let to = self.run.step() + epochs * u64::from(STEPS);
        let mut document = asked.clone();
        document["from_epoch"] = json!(self.run.place().arena_epoch);
        document["epochs"] = json!(epochs);
        let (request, stretch) = asked_recording(&document, &self.spec.run_spec(), 0)
            .map_err(|errors| anyhow!("{errors:?}"))?;
        let paths = Paths::new(folder, "measured");
        let header = header(&self.spec, &request, stretch);
        let recorder = Recorder::open(header, &paths, &self.run, u64::MAX)?;
        let mut recorder = SharedRecorder::new(Some(recorder));
        let observers: &mut [&mut dyn runner::Observer] = &mut [&mut PauseAt(to), &mut recorder];
        stopped(&runner::step(&mut self.run, &|| false, observers))?;
        finish(&recorder).map_err(|why| anyhow!(why))?;
        Ok(std::fs::metadata(&paths.whole)?.len())
    }
}

fn stopped(ended: &Ended) -> Result<()> {
    match ended {
        Ended::Stopped => Ok(()),
        ended => bail!("the run did not stop where it should: {ended:?}"),
    }
}
