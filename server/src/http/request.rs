//! What routes read from a request: JSON bodies, idempotency keys.

use std::str::FromStr;

use api::{FieldError, ProblemCode};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, HeaderValue};
use serde_json::Value;

use super::refusal::Refusal;

/// Media type of bytes.
pub const BYTES: &str = "application/octet-stream";
/// Longest idempotency key.
pub const MAX_KEY_BYTES: usize = 200;

/// That the body of a request is said to be JSON; it is not parsed yet, as a large one is work for
/// another thread.
///
/// # Errors
/// 415 when it is said to be something else.
pub fn said_to_be_json(headers: &HeaderMap) -> Result<(), Refusal> {
    if is_json(headers) {
        return Ok(());
    }
    let detail = "send JSON, with the header content-type: application/json";
    Err(Refusal::new(ProblemCode::NotSaidToBeJson, detail))
}

/// That the body of a request is said to be bytes of a kind of our own, or nothing else.
///
/// # Errors
/// 415 when it is said to be something else.
pub fn said_to_be_bytes(headers: &HeaderMap) -> Result<(), Refusal> {
    match headers.get(CONTENT_TYPE) {
        None => return Ok(()),
        Some(value) if essence(value).as_deref() == Some(BYTES) => return Ok(()),
        Some(_) => {}
    }
    let detail = "send the file, with the header content-type: application/octet-stream or none";
    Err(Refusal::new(ProblemCode::NotSaidToBeBytes, detail))
}

/// A number as it is written: without a plus or needless noughts.
pub fn number<T: FromStr + ToString>(text: &str) -> Option<T> {
    let number: T = text.parse().ok()?;
    (number.to_string() == text).then_some(number)
}

/// The body as JSON.
///
/// # Errors
/// 400 that says where the text stops being JSON, 422 for keys that stand twice.
pub fn parse(body: &[u8]) -> Result<Value, Refusal> {
    let not_json = |message: String| {
        let errors = vec![FieldError::new("", message, "a JSON object")];
        Refusal::new(ProblemCode::InvalidJson, "the body is not JSON").with_errors(errors)
    };
    let text =
        std::str::from_utf8(body).map_err(|error| not_json(format!("not UTF-8: {error}")))?;
    crate::documents::parse(text).map_err(|errors| {
        if errors.iter().all(|error| error.pointer.is_empty()) {
            Refusal::new(ProblemCode::InvalidJson, "the body is not JSON").with_errors(errors)
        } else {
            Refusal::fields(errors)
        }
    })
}

fn is_json(headers: &HeaderMap) -> bool {
    let Some(essence) = headers.get(CONTENT_TYPE).and_then(essence) else {
        return false;
    };
    essence == "application/json"
        || (essence.starts_with("application/") && essence.ends_with("+json"))
}

/// A media type without its parameters.
fn essence(value: &HeaderValue) -> Option<String> {
    let essence = value.to_str().ok()?.split(';').next()?;
    Some(essence.trim().to_ascii_lowercase())
}

/// The header `Idempotency-Key`.
///
/// # Errors
/// 400 when it is empty, too long or not of printable ASCII characters.
pub fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Refusal> {
    let Some(value) = headers.get("idempotency-key") else {
        return Ok(None);
    };
    match value.to_str() {
        Ok(key) if (1..=MAX_KEY_BYTES).contains(&key.len()) => Ok(Some(key.to_owned())),
        _ => Err(Refusal::new(
            ProblemCode::InvalidHeader,
            format!("an Idempotency-Key has 1 to {MAX_KEY_BYTES} printable ASCII characters"),
        )),
    }
}
