//! Recording as a run's owner asks for it: one that cannot be had is a warning, and a run whose
//! recording does not reach to its checkpoint begins again.

use recording::Header;
use swarm::run::Run;

use super::open::OpenError;
use super::paths::Paths;
use super::recorder::{Recorder, SharedRecorder};

/// A run that is recorded.
pub struct Begun {
    /// The run, which may have begun again.
    pub run: Run,
    /// Who records it, if anybody.
    pub recorder: SharedRecorder,
}

/// Records a run from where it stands, in at most so many bytes. `again` makes the run anew, for one that stands further on
/// than its recording.
///
/// # Errors
/// When it cannot be made anew.
pub fn begin<E>(
    run: Run,
    header: Header,
    paths: &Paths,
    most_bytes: u64,
    again: impl FnOnce() -> Result<Run, E>,
) -> Result<Begun, E> {
    let nobody = |run| {
        let recorder = SharedRecorder::new(None);
        Ok(Begun { run, recorder })
    };
    if paths.whole.exists() {
        return nobody(run);
    }
    let (run, opened) = match Recorder::open(header.clone(), paths, &run, most_bytes) {
        Err(error @ OpenError::Short) => {
            tracing::warn!("{error}: it starts again");
            let run = again()?;
            let opened = Recorder::open(header, paths, &run, most_bytes);
            (run, opened)
        }
        opened => (run, opened),
    };
    match opened {
        Ok(recorder) => Ok(Begun {
            run,
            recorder: SharedRecorder::new(Some(recorder)),
        }),
        Err(error) => {
            tracing::warn!(%error, "the run goes on without a recording");
            nobody(run)
        }
    }
}

/// Ends the recording of a run that is done.
///
/// # Errors
/// Why it is not whole.
pub fn finish(recorder: &SharedRecorder) -> Result<(), String> {
    recorder.take().map_or(Ok(()), Recorder::finish)
}
