//! The matrix of a job: axes of dotted paths, and the spec of each combination.

use std::collections::BTreeSet;

use api::FieldError;
use serde_json::{Map, Value};

use super::fields::{Errors, join, kind};

/// Most names of a dotted path: no field is as deep.
const MOST_NAMES: usize = 16;

/// One axis: a place in the run spec and the values to put there, or several places that vary
/// together (`robots+arena.tile`), each value a list with one entry a place.
#[derive(Debug)]
pub struct Axis<'a> {
    /// Dotted paths with `+` between them, as in the job.
    pub path: &'a str,
    /// The places.
    pub targets: Vec<Target<'a>>,
    /// At least one.
    pub values: &'a [Value],
}

/// A place in the run spec.
#[derive(Debug)]
pub struct Target<'a> {
    /// Dotted path.
    pub path: &'a str,
    /// The same place as a JSON pointer into a run spec.
    pub pointer: String,
}

impl<'a> Axis<'a> {
    /// Whether it has several places.
    pub fn is_linked(&self) -> bool {
        self.targets.len() > 1
    }

    /// The value at `index` for one of the places.
    pub fn value(&self, index: usize, target: usize) -> &'a Value {
        let value = &self.values[index];
        if self.is_linked() {
            &value[target]
        } else {
            value
        }
    }

    /// Where in the job that value stands.
    pub fn place(&self, index: usize, target: usize) -> String {
        let value = format!("{}/{index}", join("/matrix", self.path));
        if self.is_linked() {
            format!("{value}/{target}")
        } else {
            value
        }
    }
}

/// The axes in order of their paths; `None` when any is wrong.
pub fn axes<'a>(matrix: &'a Value, errors: &mut Errors) -> Option<Vec<Axis<'a>>> {
    let Value::Object(map) = matrix else {
        let message = format!("must be an object, not {}", kind(matrix));
        errors.add(
            "/matrix",
            message,
            "an object of dotted paths, each with a list of values",
        );
        return None;
    };
    let mut axes: Vec<Axis<'a>> = map
        .iter()
        .filter_map(|(path, values)| axis(path, values, errors))
        .collect();
    axes.sort_by_key(|axis| axis.path);
    let mut seen = BTreeSet::new();
    let mut twice = false;
    for axis in &axes {
        for target in &axis.targets {
            if !seen.insert(target.path) {
                let message = format!("{} is set twice", target.path);
                errors.add(join("/matrix", axis.path), message, "each path once");
                twice = true;
            }
        }
    }
    (!twice && axes.len() == map.len()).then_some(axes)
}

fn axis<'a>(path: &'a str, values: &'a Value, errors: &mut Errors) -> Option<Axis<'a>> {
    let place = join("/matrix", path);
    let is_wrong = |path: &str| {
        path.split('.').any(str::is_empty) || path.split('.').nth(MOST_NAMES).is_some()
    };
    if path.split('+').any(is_wrong) {
        let allowed = "such as controller.alpha, or robots+arena.tile for two that vary together";
        errors.add(place, "is no dotted path", allowed);
        return None;
    }
    let targets: Vec<Target<'a>> = path.split('+').map(target).collect();
    if targets.iter().any(|target| target.path == "seed") {
        errors.add(place, "seeds are no axis", "the job's field seeds");
        return None;
    }
    let values = match values {
        Value::Array(values) if !values.is_empty() => values,
        Value::Array(_) => {
            errors.add(place, "holds no value", "a list of at least one value");
            return None;
        }
        _ => {
            let message = format!("must be a list, not {}", kind(values));
            errors.add(place, message, "a list of at least one value");
            return None;
        }
    };
    if targets.len() > 1 {
        let wrong = |value: &Value| value.as_array().map(Vec::len) != Some(targets.len());
        let mut any = false;
        for (index, value) in values.iter().enumerate().filter(|(_, value)| wrong(value)) {
            let message = match value.as_array() {
                Some(entries) => {
                    format!("holds {} values for {} paths", entries.len(), targets.len())
                }
                None => format!("must be a list, not {}", kind(value)),
            };
            let allowed = format!("a list of {} values, one a path", targets.len());
            errors.add(format!("{place}/{index}"), message, allowed);
            any = true;
        }
        if any {
            return None;
        }
    }
    Some(Axis {
        path,
        targets,
        values,
    })
}

fn target(path: &str) -> Target<'_> {
    Target {
        path,
        pointer: path
            .split('.')
            .fold(String::new(), |pointer, name| join(&pointer, name)),
    }
}

/// The index into each axis of the combination at `place`; the last axis is the fastest.
pub fn place_of(axes: &[Axis<'_>], place: usize) -> Vec<usize> {
    indices_at(axes.iter().map(|axis| axis.values.len()), place)
}

/// As [`place_of`], from the axes' numbers of values.
pub fn indices_at(lengths: impl DoubleEndedIterator<Item = usize>, place: usize) -> Vec<usize> {
    let mut rest = place;
    let mut indices: Vec<usize> = lengths
        .rev()
        .map(|length| {
            let index = rest % length;
            rest /= length;
            index
        })
        .collect();
    indices.reverse();
    indices
}

/// The base run with the values of one combination put in.
///
/// # Errors
/// An axis leads into a value that is no object.
pub fn combination(base: &Value, axes: &[Axis<'_>], place: usize) -> Result<Value, FieldError> {
    let mut spec = base.clone();
    for (axis, index) in axes.iter().zip(place_of(axes, place)) {
        for number in 0..axis.targets.len() {
            put(&mut spec, axis, index, number)?;
        }
    }
    Ok(spec)
}

fn put(spec: &mut Value, axis: &Axis<'_>, index: usize, number: usize) -> Result<(), FieldError> {
    let mut place = spec;
    for name in axis.targets[number].path.split('.') {
        let found = kind(place);
        let Value::Object(map) = place else {
            let message = format!("leads to a field {name:?} of {found}");
            return Err(FieldError::new(
                join("/matrix", axis.path),
                message,
                "a path into objects",
            ));
        };
        place = map.entry(name).or_insert_with(|| Value::Object(Map::new()));
    }
    *place = axis.value(index, number).clone();
    Ok(())
}
