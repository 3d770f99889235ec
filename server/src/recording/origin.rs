//! Where a run begins that goes on from the state of another.

use swarm::run::Run;

use crate::documents::ResolvedRun;
use crate::store::Store;

/// The run as it begins, where it goes on from the state of another.
///
/// # Errors
/// When that state cannot be used.
pub fn begin_at_origin(store: &Store, id: &str, spec: &ResolvedRun) -> Result<Option<Run>, String> {
    let wrong =
        |error: &dyn std::fmt::Display| format!("it cannot go on from where it begins: {error}");
    let Some(origin) = store.origins().read(id).map_err(|error| wrong(&error))? else {
        return Ok(None);
    };
    let run = Run::restore(spec.run_spec(), &origin.snapshot).map_err(|error| wrong(&error))?;
    Ok(Some(run))
}

/// The first epoch that a run does from its beginning to its end, counted from 0 over all phases.
pub fn first_whole_epoch(run: &Run) -> u64 {
    let place = run.place();
    place.arena_epoch + u64::from(place.step > 0)
}
