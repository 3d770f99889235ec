//! The matrix of a job: axes of dotted paths, and the spec of each combination.

use api::FieldError;
use serde_json::{Map, Value};

use super::fields::{Errors, join, kind};

/// One axis: a place in the run spec and the values to put there.
#[derive(Debug)]
pub struct Axis<'a> {
    /// Dotted path, as in the job.
    pub path: &'a str,
    /// The same place as a JSON pointer into a run spec.
    pub pointer: String,
    /// At least one.
    pub values: &'a [Value],
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
    (axes.len() == map.len()).then_some(axes)
}

fn axis<'a>(path: &'a str, values: &'a Value, errors: &mut Errors) -> Option<Axis<'a>> {
    let place = join("/matrix", path);
    if path.split('.').any(str::is_empty) {
        errors.add(place, "is no dotted path", "such as controller.alpha");
        return None;
    }
    if path == "seed" {
        errors.add(place, "seeds are no axis", "the job's field seeds");
        return None;
    }
    match values {
        Value::Array(values) if !values.is_empty() => {
            let pointer = path
                .split('.')
                .fold(String::new(), |pointer, name| join(&pointer, name));
            Some(Axis {
                path,
                pointer,
                values,
            })
        }
        Value::Array(_) => {
            errors.add(place, "holds no value", "a list of at least one value");
            None
        }
        _ => {
            let message = format!("must be a list, not {}", kind(values));
            errors.add(place, message, "a list of at least one value");
            None
        }
    }
}

/// The index into each axis of the combination at `place`; the last axis is the fastest.
pub fn place_of(axes: &[Axis<'_>], place: usize) -> Vec<usize> {
    let mut rest = place;
    let mut indices: Vec<usize> = axes
        .iter()
        .rev()
        .map(|axis| {
            let index = rest % axis.values.len();
            rest /= axis.values.len();
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
        put(&mut spec, axis, &axis.values[index])?;
    }
    Ok(spec)
}

fn put(spec: &mut Value, axis: &Axis<'_>, value: &Value) -> Result<(), FieldError> {
    let mut place = spec;
    for name in axis.path.split('.') {
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
    *place = value.clone();
    Ok(())
}
