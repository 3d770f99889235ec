//! Answers that need not be sent again, or not from their beginning: entity tags, `If-None-Match`
//! and `Range` (RFC 9110), for every answer to `GET` that is there as a whole.

use std::ops::Range;

use api::ProblemCode;
use axum::body::{Body, HttpBody, to_bytes};
use axum::extract::Request;
use axum::http::header::{
    ACCEPT_RANGES, CACHE_CONTROL, CONTENT_LENGTH, CONTENT_RANGE, CONTENT_TYPE, ETAG, IF_NONE_MATCH,
    IF_RANGE, RANGE,
};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use sha2::{Digest, Sha256};

use super::refusal::Refusal;

/// Tags an answer, or says that the client has it, or sends the part that is asked for.
pub async fn conditional(request: Request, next: Next) -> Response {
    let is_get = *request.method() == Method::GET;
    let asked = request.headers().clone();
    let response = next.run(request).await;
    // A stream has no exact size, and is not waited for.
    let is_whole = response.body().size_hint().exact().is_some();
    if !is_get || response.status() != StatusCode::OK || !is_whole {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    let body = match to_bytes(body, usize::MAX).await {
        Ok(body) => body,
        Err(error) => return Refusal::internal(&error).into_response(),
    };
    let tag = parts
        .headers
        .entry(ETAG)
        .or_insert_with(|| tag_of(&body))
        .clone();
    parts
        .headers
        .entry(CACHE_CONTROL)
        .or_insert(HeaderValue::from_static("no-cache"));
    parts
        .headers
        .insert(ACCEPT_RANGES, HeaderValue::from_static("bytes"));
    if is_known(&asked, &tag) {
        parts.headers.remove(CONTENT_TYPE);
        parts.headers.remove(CONTENT_LENGTH);
        return (StatusCode::NOT_MODIFIED, parts.headers).into_response();
    }
    let Some(wanted) = wanted(&asked, &tag, body.len()) else {
        return Response::from_parts(parts, Body::from(body));
    };
    let length = body.len();
    let (mut response, range) = match wanted {
        Some(Range { start, end }) => {
            parts.status = StatusCode::PARTIAL_CONTENT;
            parts.headers.remove(CONTENT_LENGTH);
            // Copied, as all of it would be held otherwise until a small part is taken.
            let part = Body::from(Bytes::copy_from_slice(&body[start..end]));
            let range = format!("bytes {start}-{}/{length}", end - 1);
            (Response::from_parts(parts, part), range)
        }
        None => {
            let detail = format!("there are {length} bytes");
            let refusal = Refusal::new(ProblemCode::RangeNotSatisfiable, detail);
            (refusal.into_response(), format!("bytes */{length}"))
        }
    };
    // Digits and separators: a header can hold them.
    if let Ok(range) = HeaderValue::try_from(range) {
        response.headers_mut().insert(CONTENT_RANGE, range);
    }
    response
}

/// The tag of these bytes.
pub fn tag_of(body: &[u8]) -> HeaderValue {
    let digest = Sha256::digest(body);
    let digits = hex::encode(&digest[..16]);
    // Hexadecimal digits in quotes: a header can hold them.
    HeaderValue::try_from(format!("\"{digits}\"")).unwrap_or(HeaderValue::from_static("\"\""))
}

/// Whether `If-None-Match` names this tag, or every one.
pub fn is_known(asked: &HeaderMap, tag: &HeaderValue) -> bool {
    let lists = asked.get_all(IF_NONE_MATCH).iter();
    lists
        .filter_map(|list| list.to_str().ok())
        .flat_map(|list| list.split(','))
        .map(|known| known.trim().trim_start_matches("W/"))
        .any(|known| known == "*" || known.as_bytes() == tag.as_bytes())
}

/// The bytes that `Range` asks for: `None` where all are to be sent, `Some(None)` where there are
/// no such bytes. Several ranges at once are not told apart: all is sent.
pub fn wanted(asked: &HeaderMap, tag: &HeaderValue, length: usize) -> Option<Option<Range<usize>>> {
    let range = asked.get(RANGE)?.to_str().ok()?.strip_prefix("bytes=")?;
    if asked.get(IF_RANGE).is_some_and(|known| known != tag) {
        return None;
    }
    let (first, last) = range.trim().split_once('-')?;
    if first.is_empty() {
        let count: usize = last.parse().ok()?;
        let start = length.saturating_sub(count);
        return Some((start < length).then_some(start..length));
    }
    let first: usize = first.parse().ok()?;
    let end = match last {
        "" => length,
        last => last.parse::<usize>().ok()?.saturating_add(1).min(length),
    };
    if first < length && end <= first {
        // The wrong way round: no range at all.
        return None;
    }
    Some((first < length).then_some(first..end))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    const TAG: HeaderValue = HeaderValue::from_static("\"a-1\"");

    #[test]
    fn tags_are_found_in_lists_weak_or_not() {
        let known = |value: &'static str| {
            let headers = [(IF_NONE_MATCH, HeaderValue::from_static(value))];
            is_known(&headers.into_iter().collect(), &TAG)
        };
        for value in ["\"a-1\"", "W/\"a-1\"", "\"b\", \"a-1\"", "*"] {
            assert!(known(value), "{value}");
        }
        for value in ["", "\"a-2\"", "\"a\"", "a-1"] {
            assert!(!known(value), "{value}");
        }
        assert!(!is_known(&HeaderMap::new(), &TAG));
    }

    #[test]
    fn single_ranges_are_cut_to_what_there_is() {
        let range = |value: &'static str| {
            let headers = [(RANGE, HeaderValue::from_static(value))];
            wanted(&headers.into_iter().collect(), &TAG, 10)
        };
        for (value, bytes) in [
            ("bytes=0-0", 0..1),
            ("bytes=2-5", 2..6),
            ("bytes=7-", 7..10),
            ("bytes=7-99", 7..10),
            ("bytes=-3", 7..10),
            ("bytes=-99", 0..10),
            ("bytes=0-18446744073709551615", 0..10),
        ] {
            assert_eq!(range(value), Some(Some(bytes)), "{value}");
        }
        for none in ["bytes=10-", "bytes=99-100", "bytes=-0"] {
            assert_eq!(range(none), Some(None), "{none}");
        }
        for all in [
            "bytes=5-2",
            "bytes=0-1,4-5",
            "lines=0-1",
            "bytes=x-1",
            "bytes=-",
            "",
        ] {
            assert_eq!(range(all), None, "{all}");
        }
        let other = [
            (RANGE, HeaderValue::from_static("bytes=0-0")),
            (IF_RANGE, HeaderValue::from_static("\"a-2\"")),
        ];
        assert_eq!(wanted(&other.into_iter().collect(), &TAG, 10), None);
    }
}
