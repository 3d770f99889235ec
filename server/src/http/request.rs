//! What routes read from a request: JSON bodies, page queries, idempotency keys.

use api::{FieldError, ProblemCode};
use axum::http::header::CONTENT_TYPE;
use axum::http::{HeaderMap, Uri};
use serde_json::Value;

use super::refusal::Refusal;

const MAX_KEY_BYTES: usize = 200;
const DEFAULT_PAGE: u32 = 50;
const MAX_PAGE: u32 = 200;

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

/// The body as JSON.
///
/// # Errors
/// 400 that says where the text stops being JSON.
pub fn parse(body: &[u8]) -> Result<Value, Refusal> {
    let not_json = |message: String| {
        let errors = vec![FieldError::new("", message, "a JSON object")];
        Refusal::new(ProblemCode::InvalidJson, "the body is not JSON").with_errors(errors)
    };
    let text =
        std::str::from_utf8(body).map_err(|error| not_json(format!("not UTF-8: {error}")))?;
    crate::documents::parse(text).map_err(|errors| {
        Refusal::new(ProblemCode::InvalidJson, "the body is not JSON").with_errors(errors)
    })
}

fn is_json(headers: &HeaderMap) -> bool {
    let Some(Ok(value)) = headers.get(CONTENT_TYPE).map(|value| value.to_str()) else {
        return false;
    };
    let essence = value
        .split(';')
        .next()
        .unwrap_or_default()
        .trim()
        .to_ascii_lowercase();
    essence == "application/json"
        || (essence.starts_with("application/") && essence.ends_with("+json"))
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

/// Which page of a list is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page {
    /// Most items.
    pub limit: u32,
    /// Where it starts, as an earlier page said.
    pub cursor: Option<i64>,
}

/// The query `limit` and `cursor`.
///
/// # Errors
/// 400 when either cannot be used.
pub fn page(uri: &Uri) -> Result<Page, Refusal> {
    let mut page = Page {
        limit: DEFAULT_PAGE,
        cursor: None,
    };
    if let Some(limit) = number(uri, "limit", 1, i64::from(MAX_PAGE))? {
        page.limit = u32::try_from(limit).unwrap_or(MAX_PAGE);
    }
    page.cursor = number(uri, "cursor", 0, i64::MAX)?;
    Ok(page)
}

/// A whole number of the query.
///
/// # Errors
/// 400 when it is no number from `min` to `max`.
pub fn number(uri: &Uri, name: &str, min: i64, max: i64) -> Result<Option<i64>, Refusal> {
    let pairs = uri
        .query()
        .unwrap_or_default()
        .split('&')
        .filter_map(|pair| pair.split_once('='));
    let Some((_, text)) = pairs.into_iter().find(|(key, _)| *key == name) else {
        return Ok(None);
    };
    match text.parse() {
        Ok(number) if (min..=max).contains(&number) => Ok(Some(number)),
        _ if max == i64::MAX => Err(Refusal::new(
            ProblemCode::InvalidQuery,
            format!("{name} is not one that an earlier page gave"),
        )),
        _ => Err(Refusal::new(
            ProblemCode::InvalidQuery,
            format!("{name} is a whole number from {min} to {max}"),
        )),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn pages_are_read_or_refused() {
        let read = |text: &str| page(&text.parse().unwrap()).ok();
        assert_eq!(
            read("/v1/jobs"),
            Some(Page {
                limit: 50,
                cursor: None
            })
        );
        assert_eq!(
            read("/v1/jobs?cursor=7&limit=3"),
            Some(Page {
                limit: 3,
                cursor: Some(7)
            })
        );
        for wrong in [
            "limit=0",
            "limit=201",
            "limit=x",
            "limit=",
            "cursor=-1",
            "cursor=1e3",
        ] {
            assert_eq!(read(&format!("/v1/jobs?{wrong}")), None, "{wrong}");
        }
    }
}
