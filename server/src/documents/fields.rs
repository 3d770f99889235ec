//! Reads the fields of a JSON object and collects every error on the way.

use api::FieldError;
use serde_json::{Map, Value};

use super::domains::{Choice, Flag, SCHEMA_LINK, Whole};

/// Errors that are listed; the others are counted.
pub const LISTED_ERRORS: usize = 100;
/// Most characters of a pointer, a message or what is allowed.
const MAX_CHARACTERS: usize = 2_000;
/// Most characters of a name that is repeated to its sender, or looked for among those known.
const MAX_NAME: usize = 64;
/// How the error that stands for those not listed begins and ends.
const REST: [&str; 2] = ["and ", " wrong fields more"];

/// The errors found so far, as many as are listed.
#[derive(Debug, Default)]
pub struct Errors {
    listed: Vec<FieldError>,
    more: u64,
}

impl Errors {
    /// Adds one.
    pub fn add(
        &mut self,
        pointer: impl Into<String>,
        message: impl Into<String>,
        allowed: impl Into<String>,
    ) {
        self.extend([FieldError::new(pointer, message, allowed)]);
    }

    /// Adds some.
    pub fn extend(&mut self, errors: impl IntoIterator<Item = FieldError>) {
        for mut error in errors {
            if let Some(more) = rest(&error) {
                self.more += more;
            } else if self.is_full() {
                self.more += 1;
            } else {
                for text in [&mut error.pointer, &mut error.message, &mut error.allowed] {
                    cut(text, MAX_CHARACTERS);
                }
                self.listed.push(error);
            }
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }

    /// Whether more are only counted.
    pub fn is_full(&self) -> bool {
        self.listed.len() >= LISTED_ERRORS
    }

    /// Them in the order in which they were found; the last one says how many more there are.
    pub fn into_vec(mut self) -> Vec<FieldError> {
        if self.more > 0 {
            let message = format!("{}{}{}", REST[0], self.more, REST[1]);
            self.listed.push(FieldError::new("", message, ""));
        }
        self.listed
    }
}

/// How many errors this one stands for, if it is the last of a list that was cut.
fn rest(error: &FieldError) -> Option<u64> {
    let number = error.message.strip_prefix(REST[0])?.strip_suffix(REST[1])?;
    error.allowed.is_empty().then(|| number.parse().ok())?
}

/// Cuts a text behind this many characters.
fn cut(text: &mut String, most: usize) {
    if text.len() > most
        && let Some((end, _)) = text.char_indices().nth(most)
    {
        text.truncate(end);
        text.push('…');
    }
}

/// A name as it is, or its beginning.
fn in_short(name: &str) -> String {
    let mut name = name.to_owned();
    cut(&mut name, MAX_NAME);
    name
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
            if errors.is_full() {
                errors.more += 1;
                continue;
            }
            errors.add(
                join(pointer, name),
                format!(
                    "there is no field {:?} here{}",
                    in_short(name),
                    did_you_mean(name, &known)
                ),
                known.join(", "),
            );
        }
        if known.contains(&SCHEMA_LINK)
            && let Some(link) = map.get(SCHEMA_LINK).filter(|link| !link.is_string())
        {
            let message = format!("must be a string, not {}", kind(link));
            let allowed = "where an editor finds the JSON Schema, or nothing";
            errors.add(join(pointer, SCHEMA_LINK), message, allowed);
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

    /// A whole number; its default when absent or wrong.
    pub fn whole(&self, field: &Whole, errors: &mut Errors) -> u64 {
        let Some(value) = self.get(field.name) else {
            return field.default;
        };
        let allowed = format!("a whole number from {} to {}", field.min, field.max);
        match read_whole(value) {
            Some(number) if (field.min..=field.max).contains(&number) => number,
            _ => {
                let message = match value {
                    Value::Number(number) => format!("{number} is not {allowed}"),
                    _ => format!("must be a number, not {}", kind(value)),
                };
                errors.add(self.pointer(field.name), message, allowed);
                field.default
            }
        }
    }

    /// `true` or `false`; its default when absent or wrong.
    pub fn flag(&self, field: &Flag, errors: &mut Errors) -> bool {
        match self.get(field.name) {
            None => field.default,
            Some(Value::Bool(flag)) => *flag,
            Some(value) => {
                let message = format!("must be true or false, not {}", kind(value));
                errors.add(self.pointer(field.name), message, "true, false");
                field.default
            }
        }
    }

    /// What one of some names stands for; its default when absent or wrong.
    pub fn choice<T: Copy>(&self, field: &Choice<T>, errors: &mut Errors) -> T {
        let name = field.name;
        let Some(value) = self.get(name) else {
            return field.default;
        };
        let message = match value {
            Value::String(text) => match (field.read)(text) {
                Some(choice) => return choice,
                None => format!(
                    "there is no {name} {:?}{}",
                    in_short(text),
                    did_you_mean(text, field.names)
                ),
            },
            _ => format!("must be a string, not {}", kind(value)),
        };
        errors.add(self.pointer(name), message, field.names.join(", "));
        field.default
    }
}

/// The whole number that a JSON number stands for, `3.0` included.
pub fn read_whole(value: &Value) -> Option<u64> {
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
    if name.len() > MAX_NAME {
        return String::new();
    }
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

/// An error of the `swarm` crate as one of the service's.
pub fn field_error(error: swarm::spec::FieldError) -> FieldError {
    FieldError::new(error.pointer, error.message, error.allowed)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn errors_are_listed_up_to_a_number_and_then_counted() {
        let mut errors = Errors::default();
        let map: Map<String, Value> = (0..300_000)
            .map(|n| (format!("x{n}"), Value::Null))
            .collect();
        Object::open(&Value::Object(map), "/here", ["epochs"], &mut errors);
        let told = errors.into_vec();
        assert_eq!(told.len(), LISTED_ERRORS + 1);
        assert_eq!(told.last().unwrap().message, "and 299900 wrong fields more");
        // Taken over into another list, the count stays what it is.
        let mut all = Errors::default();
        all.add("/a", "is wrong", "right");
        all.extend(told);
        let told = all.into_vec();
        assert_eq!(told.len(), LISTED_ERRORS + 1);
        assert_eq!(told.last().unwrap().message, "and 299901 wrong fields more");
    }

    #[test]
    fn what_is_told_of_an_endless_name_ends() {
        let name = "é".repeat(1_000_000);
        let mut errors = Errors::default();
        let map = Map::from_iter([(name, Value::Null)]);
        Object::open(&Value::Object(map), "", ["epochs"], &mut errors);
        let told = errors.into_vec();
        assert!(told[0].pointer.chars().count() <= MAX_CHARACTERS + 1);
        assert!(told[0].message.chars().count() < 200);
    }
}
