//! Documents of one field, a whole number: `{"epochs": 3}`.

use api::FieldError;
use serde_json::Value;

use super::fields::{Errors, Object, kind};

/// The number of a document that has this field alone.
///
/// # Errors
/// What is wrong with the document.
pub fn one_number(
    document: &Value,
    field: &str,
    (min, max): (i64, i64),
) -> Result<i64, Vec<FieldError>> {
    let mut errors = Errors::default();
    let number = Object::open(document, "", [field], &mut errors).and_then(|object| {
        let allowed = format!("a whole number from {min} to {max}");
        let message = match object.get(field) {
            None => "is missing".to_owned(),
            Some(value) => match value.as_i64().filter(|n| (min..=max).contains(n)) {
                Some(number) => return Some(number),
                None if value.is_number() => format!("{value} is not {allowed}"),
                None => format!("must be a number, not {}", kind(value)),
            },
        };
        errors.add(object.pointer(field), message, allowed);
        None
    });
    number
        .filter(|_| errors.is_empty())
        .ok_or(errors.into_vec())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::json;

    use super::*;

    #[test]
    fn the_number_and_nothing_else() {
        let read = |document: Value| one_number(&document, "epochs", (-5, 9));
        assert_eq!(read(json!({ "epochs": 9 })), Ok(9));
        assert_eq!(read(json!({ "epochs": -5 })), Ok(-5));
        for (document, pointer) in [
            (json!({}), "/epochs"),
            (json!({ "epochs": 10 }), "/epochs"),
            (json!({ "epochs": 1.5 }), "/epochs"),
            (json!({ "epochs": "3" }), "/epochs"),
            (json!({ "epochs": 3, "epohcs": 3 }), "/epohcs"),
            (json!([3]), ""),
        ] {
            let errors = read(document.clone()).unwrap_err();
            assert_eq!(
                (errors.len(), errors[0].pointer.as_str()),
                (1, pointer),
                "{document}"
            );
        }
    }
}
