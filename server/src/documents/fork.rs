//! What is posted to fork a run: `{"epoch": 3, "changes": {"controller.eta": 0.1}}`.

use api::{FieldError, Fork};
use serde_json::Value;

use super::domains::Whole;
use super::fields::{Errors, Object, kind};
use super::limits::MAX_EPOCHS;

const EPOCH: Whole = Whole {
    name: "epoch",
    min: 0,
    max: MAX_EPOCHS,
    default: 0,
};

/// The fork that a document asks for; what is changed is checked with the run.
///
/// # Errors
/// What is wrong with the document.
pub fn fork(document: &Value) -> Result<Fork, Vec<FieldError>> {
    let mut errors = Errors::default();
    let mut fork = Fork::default();
    if let Some(object) = Object::open(document, "", ["epoch", "changes"], &mut errors) {
        if object.get("epoch").is_some() {
            // The cap is of 32 bits.
            fork.epoch = Some(object.whole(&EPOCH, &mut errors) as u32);
        }
        match object.get("changes") {
            None => {}
            Some(Value::Object(changes)) => fork.changes.extend(changes.clone()),
            Some(value) => errors.add(
                object.pointer("changes"),
                format!("must be an object, not {}", kind(value)),
                "dotted paths with values",
            ),
        }
    }
    let errors = errors.into_vec();
    if errors.is_empty() {
        Ok(fork)
    } else {
        Err(errors)
    }
}
