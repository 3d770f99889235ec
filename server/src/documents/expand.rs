//! A job: the product of a matrix over a base run and of seeds; or several such parts.

use std::collections::{BTreeMap, BTreeSet};

use api::FieldError;
use serde_json::{Map, Value};

use super::arena::{ArenaSource, Arenas};
use super::design::{Design, in_part};
use super::domains::{SCHEMA_LINK, Whole};
use super::fields::{Errors, Object, join, kind};
use super::labels::labels;
use super::limits::MAX_SEED;
use super::matrix::{Axis, Target, axes, combination, place_of};
use super::method_parameters::has_parameter;
use super::parts::{Part, parts};
use super::placement::misfits;
use super::resolve::{VERSION, resolve_with};
use super::resolved::ResolvedRun;
use super::templates::with_template;
use crate::asked::is_given_up;

/// Most runs of a job.
pub const MAX_RUNS: usize = 100_000;
/// Longest name of a job, in characters.
pub(super) const MAX_NAME: usize = 200;
/// Most bytes of JSON that expanding goes through: each combination is read anew.
const MAX_BYTES: usize = 256 << 20;
/// Wrong fields after which no more combinations are tried.
const ENOUGH_ERRORS: usize = 100;

pub(super) const FIELDS: [&str; 8] = [
    SCHEMA_LINK,
    "schema",
    "name",
    "base",
    "matrix",
    "seeds",
    "parts",
    "template",
];
pub(super) const FIRST_SEED: Whole = Whole {
    name: "first",
    min: 0,
    max: MAX_SEED,
    default: 1,
};
pub(super) const SEED_COUNT: Whole = Whole {
    name: "count",
    min: 1,
    max: MAX_RUNS as u64,
    default: 1,
};

/// A job's runs.
#[derive(Clone, Debug, Default)]
pub struct ExpandedJob {
    /// Its name; empty when none was given.
    pub name: String,
    /// Its runs, no two with the same key: part by part, combinations in order of the axes' names
    /// with the last axis fastest, and within each the seeds as given.
    pub runs: Vec<ResolvedRun>,
    /// What of its matrix each run has, in words; empty when nothing varies.
    pub labels: Vec<String>,
    /// What varies, part by part.
    pub designs: Vec<Design>,
}

/// How many runs a job has, without making them: 0 for one that is wrong or has too many.
pub fn run_count(job: &Value) -> u64 {
    let mut errors = Errors::default();
    let job = with_template(job, &mut errors);
    let count = match parts(&job, &mut errors) {
        None => 0,
        Some(parts) if parts.is_empty() => product_count(&job, &mut errors),
        Some(parts) => parts
            .iter()
            .map(|part| product_count(&part.job, &mut errors))
            .fold(0, usize::saturating_add),
    };
    if errors.is_empty() && count <= MAX_RUNS {
        count as u64
    } else {
        0
    }
}

/// Runs of a job without parts.
fn product_count(job: &Value, errors: &mut Errors) -> usize {
    let count = Object::open(job, "", FIELDS, errors).and_then(|object| {
        let empty = Value::Object(Map::new());
        let base = object.get("base").unwrap_or(&empty);
        let seeds = seeds(&object, base, errors)?;
        let axes = axes(object.get("matrix").unwrap_or(&empty), errors)?;
        combinations(&axes)?.checked_mul(seeds.len())
    });
    count.unwrap_or(usize::MAX)
}

fn combinations(axes: &[Axis<'_>]) -> Option<usize> {
    axes.iter().try_fold(1usize, |product, axis| {
        product.checked_mul(axis.values.len())
    })
}

/// Checks a job and makes its runs. Takes up to some seconds for the largest jobs.
///
/// # Errors
/// Every wrong field, with its JSON pointer into `job`: a value of the matrix that makes a run
/// invalid is pointed at where it stands in the matrix.
pub fn expand(job: &Value, arenas: &dyn ArenaSource) -> Result<ExpandedJob, Vec<FieldError>> {
    let mut errors = Errors::default();
    let job = with_template(job, &mut errors);
    let parts = parts(&job, &mut errors).unwrap_or_default();
    let mut arenas = Arenas::new(arenas);
    let expanded = if parts.is_empty() {
        product(&job, &mut arenas, MAX_BYTES, &mut errors)
    } else {
        together(&job, &parts, &mut arenas, &mut errors)
    };
    match expanded {
        Some(expanded) if errors.is_empty() => Ok(expanded),
        _ => Err(errors.into_vec()),
    }
}

/// All parts, one after the other.
fn together(
    job: &Value,
    parts: &[Part],
    arenas: &mut Arenas<'_>,
    errors: &mut Errors,
) -> Option<ExpandedJob> {
    let object = Object::open(job, "", FIELDS, errors)?;
    let mut all = ExpandedJob {
        name: name(&object, errors),
        ..ExpandedJob::default()
    };
    let mut known = BTreeMap::new();
    for (number, part) in parts.iter().enumerate() {
        let mut wrong = Errors::default();
        let expanded = product(&part.job, arenas, MAX_BYTES / parts.len(), &mut wrong);
        errors.extend(wrong.into_vec().into_iter().map(|error| part.in_job(error)));
        let Some(expanded) = expanded else { continue };
        let labels = expanded.labels.iter();
        all.labels
            .extend(labels.map(|label| in_part(&part.name, label)));
        all.designs
            .extend(expanded.designs.into_iter().map(|design| Design {
                part: Some(part.name.clone()),
                ..design
            }));
        let twin = expanded.runs.iter().find_map(|run| {
            let earlier = known.insert((run.essence(), run.seed()), number)?;
            Some(&parts[earlier].name)
        });
        if let Some(earlier) = twin {
            errors.add(
                format!("/parts/{number}"),
                format!("makes a run that part {earlier:?} already has"),
                "parts that differ",
            );
        }
        all.runs.extend(expanded.runs);
        if all.runs.len() > MAX_RUNS {
            let message = format!("the parts make more than {MAX_RUNS} runs");
            errors.add("/parts", message, format!("at most {MAX_RUNS} runs"));
            return None;
        }
    }
    Some(all)
}

/// A job without parts.
fn product(
    job: &Value,
    arenas: &mut Arenas<'_>,
    max_bytes: usize,
    errors: &mut Errors,
) -> Option<ExpandedJob> {
    let object = Object::open(job, "", FIELDS, errors)?;
    object.whole(&VERSION, errors);
    let name = name(&object, errors);
    let empty = Value::Object(Map::new());
    let base = object.get("base").unwrap_or(&empty);
    let seeds = seeds(&object, base, errors);
    let axes = axes(object.get("matrix").unwrap_or(&empty), errors);
    let (seeds, axes) = (seeds?, axes?);
    let combinations = combinations(&axes);
    let total = combinations.and_then(|number| number.checked_mul(seeds.len()));
    let Some(combinations) = combinations.filter(|_| total.is_some_and(|total| total <= MAX_RUNS))
    else {
        let total = total.map_or("too many".to_owned(), |total| total.to_string());
        let message = format!("matrix and seeds make {total} runs");
        errors.add("", message, format!("at most {MAX_RUNS} runs"));
        return None;
    };
    let longest = |axis: &Axis<'_>| axis.values.iter().map(length).max().unwrap_or(0);
    let bytes = length(base) + axes.iter().map(longest).sum::<usize>();
    if bytes.saturating_mul(combinations) > max_bytes {
        let message = format!("{combinations} runs of {bytes} bytes are too much to read");
        let allowed =
            "a smaller job; an arena that was uploaded can be named instead of written out";
        errors.add("", message, allowed);
        return None;
    }
    let distinct = resolve_all(base, &axes, combinations, arenas, errors)?;
    let misfits = misfits(&distinct, seeds[0]);
    if !misfits.is_empty() {
        // A field of the base run is wrong once, however many combinations have it.
        let mut seen = BTreeSet::new();
        errors.extend(
            misfits
                .into_iter()
                .map(|(place, error)| in_job(error, &axes, place))
                .filter(|error| seen.insert((error.pointer.clone(), error.message.clone()))),
        );
        return None;
    }
    let runs = distinct
        .iter()
        .flat_map(|run| seeds.iter().map(|seed| run.with_seed(*seed)));
    let labels = labels(&axes, combinations).into_iter();
    Some(ExpandedJob {
        name,
        runs: runs.collect(),
        labels: labels
            .flat_map(|label| std::iter::repeat_n(label, seeds.len()))
            .collect(),
        designs: vec![Design::new(&axes, seeds.len())],
    })
}

/// Bytes of a value as text.
fn length(value: &Value) -> usize {
    value.to_string().len()
}

fn name(object: &Object<'_>, errors: &mut Errors) -> String {
    let allowed = format!("a string of at most {MAX_NAME} characters");
    match object.get("name") {
        None => String::new(),
        Some(Value::String(name)) if name.chars().count() <= MAX_NAME => name.clone(),
        Some(Value::String(name)) => {
            let length = name.chars().count();
            errors.add(
                object.pointer("name"),
                format!("has {length} characters"),
                allowed,
            );
            String::new()
        }
        Some(value) => {
            let message = format!("must be a string, not {}", kind(value));
            errors.add(object.pointer("name"), message, allowed);
            String::new()
        }
    }
}

/// The seeds, each once; the base run's own when the job has none.
fn seeds(object: &Object<'_>, base: &Value, errors: &mut Errors) -> Option<Vec<u64>> {
    let allowed =
        format!("{{\"first\": 1, \"count\": 3}} or a list of whole numbers to {MAX_SEED}");
    let own = base.get("seed");
    match object.get("seeds") {
        // A seed of the wrong kind is found with the rest of the base run.
        None => Some(vec![own.and_then(Value::as_u64).unwrap_or(1)]),
        Some(_) if own.is_some() => {
            errors.add(
                "/base/seed",
                "the job has seeds of its own",
                "either this or seeds",
            );
            None
        }
        Some(Value::Array(list)) => {
            if list.is_empty() || list.len() > MAX_RUNS {
                errors.add("/seeds", format!("holds {} seeds", list.len()), allowed);
                return None;
            }
            let mut seen = BTreeSet::new();
            let mut wrong = false;
            let seeds = list.iter().enumerate().filter_map(|(index, value)| {
                let seed = value.as_u64().filter(|seed| *seed <= MAX_SEED);
                let fresh = seed.is_some_and(|seed| seen.insert(seed));
                if !fresh {
                    let reason = if seed.is_some() {
                        "stands there twice"
                    } else {
                        "is no seed"
                    };
                    errors.add(
                        format!("/seeds/{index}"),
                        format!("{value} {reason}"),
                        &allowed,
                    );
                    wrong = true;
                }
                seed
            });
            let seeds = seeds.collect();
            (!wrong).then_some(seeds)
        }
        Some(range @ Value::Object(_)) => {
            let range = Object::open(range, "/seeds", ["first", "count"], errors)?;
            let first = range.whole(&FIRST_SEED, errors);
            let count = range.whole(&SEED_COUNT, errors);
            if first + (count - 1) > MAX_SEED {
                errors.add(
                    "/seeds",
                    "the last seed is too large",
                    format!("up to {MAX_SEED}"),
                );
                return None;
            }
            Some((first..first + count).collect())
        }
        Some(value) => {
            let message = format!("must be an object or a list, not {}", kind(value));
            errors.add("/seeds", message, allowed);
            None
        }
    }
}

/// Where an error was met first, and in how many combinations.
struct Met {
    place: usize,
    times: usize,
}

/// Resolves every combination; an error of many combinations is told once.
fn resolve_all(
    base: &Value,
    axes: &[Axis<'_>],
    combinations: usize,
    arenas: &mut Arenas<'_>,
    errors: &mut Errors,
) -> Option<Vec<ResolvedRun>> {
    let mut runs: Vec<ResolvedRun> = Vec::with_capacity(combinations);
    let mut met: Vec<(FieldError, Met)> = Vec::new();
    let mut first_of = BTreeMap::new();
    let mut tried = 0;
    for place in 0..combinations {
        if met.len() >= ENOUGH_ERRORS {
            break;
        }
        if is_given_up() {
            errors.add("", "was given up", "a client that waits for the answer");
            return None;
        }
        tried += 1;
        let wrong = match combination(base, axes, place) {
            Err(error) => vec![error],
            Ok(spec) => match resolve_with(&spec, arenas) {
                Err(wrong) => wrong.into_iter().map(|e| in_job(e, axes, place)).collect(),
                Ok(run) => {
                    let twin = first_of.insert(run.essence(), place);
                    runs.push(run);
                    let made = runs.last().zip(twin);
                    let same = made.map(|(run, twin)| same_run(run, axes, twin, place));
                    same.into_iter().collect()
                }
            },
        };
        for error in wrong {
            match met.iter_mut().find(|(known, _)| *known == error) {
                Some((_, met)) => met.times += 1,
                None => met.push((error, Met { place, times: 1 })),
            }
        }
    }
    if met.is_empty() {
        return Some(runs);
    }
    errors.extend(met.into_iter().map(|(mut error, met)| {
        if met.times < tried && !error.pointer.starts_with("/matrix") {
            error.message = format!("{} (with {})", error.message, words(axes, met.place));
        }
        error
    }));
    None
}

/// A run's error as one of the job: at the value of the innermost axis that holds the field or
/// leads into it, or in the base run.
fn in_job(error: FieldError, axes: &[Axis<'_>], place: usize) -> FieldError {
    let within = |target: &Target<'_>| match error.pointer.strip_prefix(target.pointer.as_str()) {
        Some(rest) if rest.is_empty() || rest.starts_with('/') => Some(rest.to_owned()),
        // The axis leads into a field that cannot hold it.
        _ if !error.pointer.is_empty() && leads_into(&error.pointer, target) => Some(String::new()),
        _ => None,
    };
    let pointer = axes
        .iter()
        .zip(place_of(axes, place))
        .flat_map(|(axis, index)| {
            let targets = axis.targets.iter().enumerate();
            targets.map(move |(number, target)| (axis.place(index, number), target))
        })
        .filter_map(|(place, target)| Some((place, target, within(target)?)))
        .max_by_key(|(_, target, _)| target.pointer.len())
        .map(|(place, _, rest)| format!("{place}{rest}"))
        .unwrap_or_else(|| format!("/base{}", error.pointer));
    FieldError { pointer, ..error }
}

fn leads_into(pointer: &str, target: &Target<'_>) -> bool {
    target
        .pointer
        .strip_prefix(pointer)
        .is_some_and(|rest| rest.starts_with('/'))
}

/// Two combinations that make one run, told at an axis in which they differ.
fn same_run(run: &ResolvedRun, axes: &[Axis<'_>], first: usize, second: usize) -> FieldError {
    let places = place_of(axes, first)
        .into_iter()
        .zip(place_of(axes, second));
    let differing = axes
        .iter()
        .zip(places)
        .find(|(_, (one, other))| one != other);
    let pointer = match differing {
        Some((axis, (_, index))) => format!("{}/{index}", join("/matrix", axis.path)),
        None => "/matrix".to_owned(),
    };
    let states_from = run.common_spec().controller.parameters.states_from;
    let without = differing.iter().flat_map(|(axis, _)| &axis.targets);
    let without = without
        .filter_map(|target| target.path.strip_prefix("controller."))
        .filter(|name| !has_parameter(run.method(), states_from, name));
    let without: Vec<&str> = without.collect();
    if without.is_empty() {
        let message = "makes a run that the job already has";
        return FieldError::new(pointer, message, "values that differ");
    }
    let (method, names) = (run.method().name(), without.join(", "));
    FieldError::new(
        pointer,
        format!("makes a run that the job already has: {method} has no {names}"),
        format!("{names} only with methods that have it: `parts` have a matrix each"),
    )
}

/// A combination in words.
fn words(axes: &[Axis<'_>], place: usize) -> String {
    let words: Vec<String> = axes
        .iter()
        .zip(place_of(axes, place))
        .map(|(axis, index)| format!("{} = {}", axis.path, axis.values[index]))
        .collect();
    words.join(", ")
}
