//! JSON text to a value: a key that stands twice in an object is refused, nesting is bounded.

use std::fmt;

use api::FieldError;
use serde::de::{DeserializeSeed, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use super::fields::{Errors, join};

/// Longest text.
const MAX_BYTES: usize = 64 << 20;
/// Deepest that arrays and objects may hold each other.
const MAX_DEPTH: usize = 64;

/// Most bytes that a document takes once it is read, about, or so many times those of its text if
/// that is more. Small objects take a hundred times as much as their text, those of arenas thirty.
const MAX_READ_BYTES: usize = 128 << 20;
const MAX_READ_TIMES: usize = 32;
/// Longest key.
const MAX_KEY_BYTES: usize = 4_096;
/// What a value, a list, an object and a key of one take.
const VALUE_BYTES: usize = 32;
const LIST_BYTES: usize = 96;
const OBJECT_BYTES: usize = 600;
const KEY_BYTES: usize = 64;

/// Parses JSON text. A byte order mark before it is passed over.
///
/// # Errors
/// One error on the whole document that says where the text stops being JSON, or one for each key
/// that stands in its object twice: JSON leaves open which of the two values counts.
pub fn parse(text: &str) -> Result<Value, Vec<FieldError>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let not_json = |message: String| vec![FieldError::new("", message, "a JSON object")];
    if text.len() > MAX_BYTES {
        let allowed = format!("at most {MAX_BYTES} bytes");
        let message = format!("the document has {} bytes", text.len());
        return Err(vec![FieldError::new("", message, allowed)]);
    }
    let mut place = Place {
        most_bytes: MAX_READ_BYTES.max(MAX_READ_TIMES * text.len()),
        ..Place::default()
    };
    let mut deserializer = serde_json::Deserializer::from_str(text);
    let value = Node(&mut place)
        .deserialize(&mut deserializer)
        .and_then(|value| deserializer.end().map(|()| value))
        .map_err(|error| not_json(format!("not JSON: {error}")))?;
    if place.twice.is_empty() {
        Ok(value)
    } else {
        Err(place.twice.into_vec())
    }
}

/// Where in the document the parser is, and the keys that stood twice.
#[derive(Default)]
struct Place {
    path: Vec<String>,
    twice: Errors,
    /// What was read so far takes, and may take.
    bytes: usize,
    most_bytes: usize,
}

impl Place {
    fn pointer(&self, key: &str) -> String {
        let pointer = self
            .path
            .iter()
            .fold(String::new(), |p, name| join(&p, name));
        join(&pointer, key)
    }

    fn take<E: serde::de::Error>(&mut self, bytes: usize) -> Result<(), E> {
        self.bytes += bytes;
        if self.bytes > self.most_bytes {
            let most = self.most_bytes;
            return Err(E::custom(format!(
                "so many objects and lists that they take more than {most} bytes"
            )));
        }
        Ok(())
    }
}

/// A value at the place.
struct Node<'p>(&'p mut Place);

impl<'de> DeserializeSeed<'de> for Node<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl Node<'_> {
    /// What is inside an array or object.
    fn inside<E: serde::de::Error>(&mut self, name: String) -> Result<Node<'_>, E> {
        if self.0.path.len() >= MAX_DEPTH {
            return Err(E::custom(format!(
                "nested deeper than {MAX_DEPTH} arrays and objects"
            )));
        }
        self.0.take(VALUE_BYTES)?;
        self.0.path.push(name);
        Ok(Node(self.0))
    }
}

impl<'de> Visitor<'de> for Node<'_> {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_string<E>(self, value: String) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<Value, A::Error> {
        self.0.take(LIST_BYTES)?;
        let mut values = Vec::new();
        loop {
            let node = self.inside(values.len().to_string())?;
            let value = list.next_element_seed(node)?;
            self.0.path.pop();
            match value {
                Some(value) => values.push(value),
                None => return Ok(Value::Array(values)),
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(mut self, mut object: A) -> Result<Value, A::Error> {
        self.0.take(OBJECT_BYTES)?;
        let mut map = Map::new();
        while let Some(name) = object.next_key::<String>()? {
            self.0.take(KEY_BYTES)?;
            if name.len() > MAX_KEY_BYTES {
                return Err(serde::de::Error::custom(format!(
                    "a key of {} bytes, more than {MAX_KEY_BYTES}",
                    name.len()
                )));
            }
            let value = object.next_value_seed(self.inside(name.clone())?)?;
            self.0.path.pop();
            if map.contains_key(&name) {
                // Those that are only counted need none.
                let pointer = match self.0.twice.is_full() {
                    true => String::new(),
                    false => self.0.pointer(&name),
                };
                let message = format!("the key {name:?} stands in its object twice");
                self.0.twice.add(pointer, message, "each key once");
            }
            map.insert(name, value);
        }
        Ok(Value::Object(map))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::json;

    use super::*;

    fn pointers(text: &str) -> Vec<String> {
        let errors = parse(text).unwrap_err();
        errors.into_iter().map(|error| error.pointer).collect()
    }

    #[test]
    fn values_are_those_of_serde_json() {
        let text = r#" {"a": [1, -2, 3.5, 1e300, 18446744073709551615, true, null, "\u00e9\n"],
            "b": {"": {"x~/": []}}, "c": 0.1} "#;
        let expected: Value = serde_json::from_str(text).unwrap();
        assert_eq!(parse(text).unwrap(), expected);
    }

    #[test]
    fn a_key_that_stands_twice_is_told_wherever_it_is() {
        assert_eq!(
            pointers(r#"{"epochs": 1, "x": {}, "epochs": 2}"#),
            ["/epochs"]
        );
        assert_eq!(
            pointers(r#"{"matrix": {"controller.eta": [0.1], "controller.eta": [0.4]}}"#),
            ["/matrix/controller.eta"]
        );
        assert_eq!(
            pointers(r#"{"a": [0, {"b/": 1, "b/": 1}], "c": {"d": 1, "d": 2, "d": 3}}"#),
            ["/a/1/b~1", "/c/d", "/c/d"]
        );
    }

    /// The place of each was put together, however long and however many they were.
    #[test]
    fn many_keys_that_stand_twice_are_no_work() {
        let twice = vec![r#""a":1"#; 200_000].join(",");
        let text = |key: usize| format!("{{\"{}\":{{{twice}}}}}", "k".repeat(key));
        assert_eq!(parse(&text(4_096)).unwrap_err().len(), 101);
        let errors = parse(&text(4_097)).unwrap_err();
        assert!(
            errors[0].message.contains("a key of 4097 bytes"),
            "{errors:?}"
        );
    }

    #[test]
    fn a_byte_order_mark_is_passed_over() {
        assert_eq!(parse("\u{feff}{\"a\": 1}").unwrap(), json!({"a": 1}));
        assert!(parse("{\"a\": \u{feff}1}").is_err());
    }

    #[test]
    fn what_a_text_takes_when_it_is_read_is_bounded() {
        let list_of = |value: &str, count: usize| format!("[{}]", vec![value; count].join(","));
        // Walls and starts of arenas.
        let start = r#"{"x_m": 1.5, "y_m": 1.5, "heading_rad": 0.5}"#;
        for allowed in [list_of("[0.5,0.5,1,1]", 200_000), list_of(start, 400_000)] {
            assert!(parse(&allowed).is_ok());
        }
        for heavy in [list_of("{\"a\":1}", 300_000), list_of("[1]", 1_000_000)] {
            assert!(heavy.len() < 4 << 20);
            let errors = parse(&heavy).unwrap_err();
            assert!(errors[0].message.contains("take more than"), "{errors:?}");
        }
    }

    #[test]
    fn nesting_is_bounded_and_what_is_not_json_told() {
        let nested = |depth: usize| format!("{}{}", "[".repeat(depth), "]".repeat(depth));
        assert!(parse(&nested(MAX_DEPTH)).is_ok());
        for wrong in [
            nested(MAX_DEPTH + 2),
            nested(100_000),
            "{".into(),
            "{} x".into(),
            String::new(),
        ] {
            let errors = parse(&wrong).unwrap_err();
            assert_eq!(errors.len(), 1);
            assert!(errors[0].message.starts_with("not JSON: "), "{errors:?}");
        }
        assert!(
            parse(&nested(MAX_DEPTH + 2)).unwrap_err()[0]
                .message
                .contains("nested deeper")
        );
    }
}
