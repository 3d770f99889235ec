//! Reads the fields of a JSON object and collects every error on the way.

use api::FieldError;
use serde_json::{Map, Value};

/// Every error found so far.
#[derive(Debug, Default)]
pub struct Errors(Vec<FieldError>);

impl Errors {
    /// Adds one.
    pub fn add(
        &mut self,
        pointer: impl Into<String>,
        message: impl Into<String>,
        allowed: impl Into<String>,
    ) {
        self.0.push(FieldError::new(pointer, message, allowed));
    }

    /// Adds some.
    pub fn extend(&mut self, errors: impl IntoIterator<Item = FieldError>) {
        self.0.extend(errors);
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All of them, in the order in which they were found.
    pub fn into_vec(self) -> Vec<FieldError> {
        self.0
    }
}

/// A JSON object at a place in a document.
pub struct Object<'a> {
    map: &'a Map<String, Value>,
    pointer: String,
}

impl<'a> Object<'a> {
    /// The object at `pointer`, which may hold the `known` fields only. Adds an error for each other
    /// field, or one if the value is no object.
    pub fn open<'k>(
        value: &'a Value,
        pointer: &str,
        known: impl IntoIterator<Item = &'k str>,
        errors: &mut Errors,
    ) -> Option<Self> {
        let Value::Object(map) = value else {
            errors.add(
                pointer,
                format!("must be an object, not {}", kind(value)),
                "an object",
            );
            return None;
        };
        let known: Vec<&str> = known.into_iter().collect();
        for name in map.keys().filter(|name| !known.contains(&name.as_str())) {
            errors.add(
                join(pointer, name),
                format!(
                    "there is no field {name:?} here{}",
                    did_you_mean(name, &known)
                ),
                known.join(", "),
            );
        }
        Some(Self {
            map,
            pointer: pointer.to_owned(),
        })
    }

    /// The value of a field.
    pub fn get(&self, name: &str) -> Option<&'a Value> {
        self.map.get(name)
    }

    /// The JSON pointer of a field.
    pub fn pointer(&self, name: &str) -> String {
        join(&self.pointer, name)
    }

    /// A whole number in `min..=max`; `default` when absent or wrong.
    pub fn whole(&self, name: &str, min: u64, max: u64, default: u64, errors: &mut Errors) -> u64 {
        let Some(value) = self.get(name) else {
            return default;
        };
        let allowed = format!("a whole number from {min} to {max}");
        match read_whole(value) {
            Some(number) if (min..=max).contains(&number) => number,
            _ => {
                let message = match value {
                    Value::Number(number) => format!("{number} is not {allowed}"),
                    _ => format!("must be a number, not {}", kind(value)),
                };
                errors.add(self.pointer(name), message, allowed);
                default
            }
        }
    }

    /// `true` or `false`; `default` when absent or wrong.
    pub fn flag(&self, name: &str, default: bool, errors: &mut Errors) -> bool {
        match self.get(name) {
            None => default,
            Some(Value::Bool(flag)) => *flag,
            Some(value) => {
                let message = format!("must be true or false, not {}", kind(value));
                errors.add(self.pointer(name), message, "true, false");
                default
            }
        }
    }

    /// One of `names`, turned into a value by `read`; `default` when absent or wrong.
    pub fn choice<T>(
        &self,
        name: &str,
        names: &[&str],
        read: impl Fn(&str) -> Option<T>,
        default: T,
        errors: &mut Errors,
    ) -> T {
        let Some(value) = self.get(name) else {
            return default;
        };
        let message = match value {
            Value::String(text) => match read(text) {
                Some(choice) => return choice,
                None => format!("there is no {name} {text:?}{}", did_you_mean(text, names)),
            },
            _ => format!("must be a string, not {}", kind(value)),
        };
        errors.add(self.pointer(name), message, names.join(", "));
        default
    }
}

/// The whole number that a JSON number stands for, `3.0` included.
fn read_whole(value: &Value) -> Option<u64> {
    value.as_u64().or_else(|| {
        // 2^53: beyond it a JSON number with a fraction part no longer counts exactly.
        let number = value.as_f64()?;
        (number.fract() == 0.0 && (0.0..=9_007_199_254_740_992.0).contains(&number))
            .then_some(number as u64)
    })
}

/// What a JSON value is, with its article.
pub fn kind(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a truth value",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}

/// `; did you mean "..."?` when a known name is near, else nothing.
pub fn did_you_mean<S: AsRef<str>>(name: &str, known: &[S]) -> String {
    known
        .iter()
        .map(|candidate| {
            (
                strsim::damerau_levenshtein(name, candidate.as_ref()),
                candidate,
            )
        })
        .filter(|(distance, candidate)| *distance <= 1 + candidate.as_ref().len() / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| format!("; did you mean {:?}?", candidate.as_ref()))
        .unwrap_or_default()
}

/// The pointer of a member, escaped after RFC 6901.
pub fn join(pointer: &str, name: &str) -> String {
    format!("{pointer}/{}", name.replace('~', "~0").replace('/', "~1"))
}
