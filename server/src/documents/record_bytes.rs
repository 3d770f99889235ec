//! About how many bytes recordings take, and what would fit where they are too many.

use api::FieldError;
use swarm::ValidSpec;

use super::record::{FIELDS, RecordRequest, Stretch, has};
use super::resolved::ResolvedRun;

/// Most bytes of one recording, about which a spec is refused that would make a larger one.
pub const MOST_RECORDING_BYTES: u64 = 4 << 30;
/// About how many bytes an object takes a sample.
const OBJECT_BYTES: f64 = 2.0;
/// Bytes of a pose that need not be kept where its command is known.
const RECKONED_BYTES: f64 = 3.0;

impl RecordRequest {
    /// About how many bytes it takes, every so many steps of so many robots.
    fn bytes(&self, spec: &ValidSpec, epochs: u64, every: u32, robots: usize) -> f64 {
        let samples = epochs.saturating_mul(1 + u64::from(spec.steps_per_epoch / every.max(1)));
        let fields = FIELDS.iter().zip(has(self.fields));
        let robot: f64 = fields.filter(|(_, has)| *has).map(|((_, b), _)| b).sum();
        let is_reckoned = every == 1 && self.fields.pose && self.fields.command;
        let robot = robot - if is_reckoned { RECKONED_BYTES } else { 0.0 };
        let objects = spec.arena.objects().len() as f64;
        samples as f64 * (robot * robots as f64 + OBJECT_BYTES * objects)
    }

    fn robots_of(&self, spec: &ValidSpec) -> usize {
        self.robots.of(spec.robots).len()
    }

    /// About how many bytes so many epochs of it take.
    pub fn about_bytes(&self, spec: &ValidSpec, epochs: u64) -> u64 {
        self.bytes(spec, epochs, self.every_steps, self.robots_of(spec)) as u64
    }

    /// Whether a recording of so many epochs takes no more than there is for `whose`.
    ///
    /// # Errors
    /// What would fit.
    pub fn check_size(
        &self,
        spec: &ValidSpec,
        epochs: u64,
        most_bytes: u64,
        whose: &str,
    ) -> Result<(), FieldError> {
        let robots = self.robots_of(spec);
        let bytes = |every, robots| self.bytes(spec, epochs, every, robots);
        let most = most_bytes as f64;
        let wanted = bytes(self.every_steps, robots);
        if wanted <= most {
            return Ok(());
        }
        let every = fewer_samples(self.every_steps, spec.steps_per_epoch, |every| {
            bytes(every, robots) <= most
        });
        let fewer = ((robots as f64 * most / wanted).floor() as usize).max(1);
        let fewer = (bytes(self.every_steps, fewer) <= most).then_some(fewer);
        let ways = [
            every.map(|every| format!("every_steps of at least {every}")),
            fewer.map(|fewer| format!("at most {fewer} robots")),
        ];
        Err(too_large(
            format!("the recording would take about {}", size(wanted)),
            format!("more than the {} {whose}", size(most)),
            &ways,
            "fewer epochs, fields, robots and samples",
        ))
    }
}

/// Whether the recordings of runs take no more than those of a run and those of a job may.
///
/// # Errors
/// What would fit.
pub fn check_job_recordings(
    runs: &[ResolvedRun],
    run_bytes: u64,
    job_bytes: u64,
) -> Result<(), FieldError> {
    let recorded: Vec<(&RecordRequest, &ValidSpec, u64)> = runs
        .iter()
        .filter_map(|run| Some((run.record()?, run.common_valid_spec())))
        .map(|(request, spec)| (request, spec, Stretch::whole(spec).epochs))
        .collect();
    for (request, spec, epochs) in &recorded {
        request.check_size(
            spec,
            *epochs,
            run_bytes,
            "that those of a run may take here",
        )?;
    }
    // The sum over runs, each recorded every so many steps or more rarely.
    let bytes = |every: u32| -> f64 {
        let each = recorded.iter().map(|(request, spec, epochs)| {
            let every = request.every_steps.max(every);
            request.bytes(spec, *epochs, every, request.robots_of(spec))
        });
        each.sum()
    };
    let (wanted, most) = (bytes(0), job_bytes as f64);
    if wanted <= most {
        return Ok(());
    }
    let least = recorded
        .iter()
        .map(|(request, ..)| request.every_steps)
        .min();
    let steps = recorded
        .iter()
        .map(|(_, spec, _)| spec.steps_per_epoch)
        .max();
    let every = least
        .zip(steps)
        .and_then(|(least, steps)| fewer_samples(least, steps, |every| bytes(every) <= most));
    let fewer = (recorded.len() as f64 * most / wanted).floor() as u64;
    let ways = [
        every.map(|every| format!("every_steps of at least {every}")),
        (fewer > 0).then(|| format!("about {fewer} runs")),
    ];
    Err(too_large(
        format!(
            "the recordings of {} runs would take about {}",
            recorded.len(),
            size(wanted)
        ),
        format!(
            "more than the {} that those of a job may take here",
            size(most)
        ),
        &ways,
        "fewer runs, epochs, fields, robots and samples",
    ))
}

/// The fewest steps between two samples that fit, up to those of an epoch, by tenths of what is too
/// few.
fn fewer_samples(every: u32, steps: u32, fits: impl Fn(u32) -> bool) -> Option<u32> {
    let all = std::iter::successors(Some(every.max(1)), |every| {
        (*every < steps).then(|| every + every.div_ceil(10))
    });
    all.map(|every| every.min(steps.max(1)))
        .find(|every| fits(*every))
}

fn too_large(takes: String, more: String, ways: &[Option<String>], else_: &str) -> FieldError {
    let ways: Vec<&str> = ways.iter().flatten().map(String::as_str).collect();
    let allowed = match ways.is_empty() {
        true => else_.to_owned(),
        false => ways.join(", or "),
    };
    FieldError::new("/record", format!("{takes}, {more}"), allowed)
}

/// Bytes in words.
fn size(bytes: f64) -> String {
    let gib = bytes / f64::from(1 << 30);
    if gib >= 1.0 {
        format!("{gib:.1} GiB")
    } else {
        format!("{:.1} MiB", bytes / f64::from(1 << 20))
    }
}
