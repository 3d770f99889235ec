//! The field `placement`, and whether the robots of a job's runs can be put into their arenas, found
//! before it is stored.

use std::collections::BTreeMap;

use api::PlacementSpec;
use serde_json::Value;
use swarm::run::check_placement;
use swarm::spec::{Placement, RunSpec};

use super::domains::{Choice, Flag};
use super::fields::{Errors, Object, field_error};
use super::resolved::ResolvedRun;

/// Robots that are placed to check a job, and walls that are looked at for that, at least;
/// combinations beyond show when their runs begin.
const ENOUGH_PARTS: u64 = 1_000_000;
/// Wrong combinations after which no more are looked for.
const ENOUGH_ERRORS: usize = 100;

/// A kind of placement, as the field itself or within its object.
const fn kinds(name: &'static str) -> Choice<Placement> {
    Choice {
        name,
        names: &Placement::KINDS,
        read: |text| Placement::from_name(text).filter(|placement| !placement.is_anywhere()),
        shown: Placement::kind,
        default: Placement::Start,
    }
}
pub(super) const KIND_ALONE: Choice<Placement> = kinds("placement");
pub(super) const KIND: Choice<Placement> = kinds("kind");
pub(super) const ANYWHERE: Flag = Flag {
    name: "anywhere",
    default: false,
};

/// Reads `placement`: one of its kinds, or `{"kind": "random", "anywhere": true}`.
pub fn read(spec: &Object<'_>, errors: &mut Errors) -> Placement {
    let Some(value @ Value::Object(_)) = spec.get("placement") else {
        return spec.choice(&KIND_ALONE, errors);
    };
    let pointer = spec.pointer("placement");
    let Some(object) = Object::open(value, &pointer, ["kind", "anywhere"], errors) else {
        return Placement::Start;
    };
    let placement = object.choice(&KIND, errors);
    if !object.flag(&ANYWHERE, errors) {
        return placement;
    }
    placement.anywhere().unwrap_or_else(|| {
        let message = "start poses are where they are";
        let allowed = "true with kind \"grid\" or \"random\"";
        errors.add(object.pointer("anywhere"), message, allowed);
        placement
    })
}

/// How a placement is shown.
pub fn shown(placement: Placement) -> PlacementSpec {
    let kind = placement.kind().to_owned();
    if placement.is_anywhere() {
        PlacementSpec::Said {
            kind,
            anywhere: true,
        }
    } else {
        PlacementSpec::Kind(kind)
    }
}

/// The combinations whose robots do not fit, with the index of each in `runs`. Placement is tried
/// once for each arena, body and way of placing, with the most robots: fewer fit where more do.
pub fn misfits(runs: &[ResolvedRun], seed: u64) -> Vec<(usize, api::FieldError)> {
    let mut numbers = BTreeMap::new();
    let mut groups: Vec<Vec<(usize, u32)>> = Vec::new();
    for (place, run) in runs.iter().enumerate() {
        let spec = run.common_spec();
        if spec.robots > 1 {
            let number = *numbers.entry(key(spec)).or_insert(groups.len());
            if number == groups.len() {
                groups.push(Vec::new());
            }
            groups[number].push((place, spec.robots));
        }
    }
    let mut misfits: Vec<(usize, api::FieldError)> = Vec::new();
    let mut placed = 0;
    for mut group in groups {
        group.sort_by_key(|&(place, robots)| (std::cmp::Reverse(robots), place));
        for same in group.chunk_by(|(_, one), (_, other)| one == other) {
            let (first, robots) = same[0];
            if placed >= ENOUGH_PARTS || misfits.len() >= ENOUGH_ERRORS {
                return misfits;
            }
            let walls = runs[first].common_spec().arena.walls().len();
            placed += u64::from(robots) + 2 * walls as u64;
            match check_placement(&runs[first].with_seed(seed).run_spec()) {
                Ok(()) => break,
                Err(error) => {
                    let error = field_error(error);
                    misfits.extend(same.iter().map(|&(place, _)| (place, error.clone())));
                }
            }
        }
    }
    misfits
}

/// What placement depends on, but for robots and seed. An arena of a job is read once, so its
/// address stands for it.
fn key(spec: &RunSpec) -> (usize, Option<usize>, String) {
    let training = spec.controller.training.as_ref();
    (
        std::sync::Arc::as_ptr(&spec.arena) as usize,
        training.map(|training| std::sync::Arc::as_ptr(&training.arena) as usize),
        format!(
            "{:?} {:?} {:?}",
            spec.placement, spec.controller.method, spec.robot
        ),
    )
}
