//! Answers that are too long to be held, of which the parts that are asked for are sent: what tag,
//! `If-None-Match` and `Range` come to, as for those that are there as a whole.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;

use api::ProblemCode;
use axum::http::header::{
    ACCEPT_RANGES, CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_LENGTH, CONTENT_RANGE, CONTENT_TYPE,
    ETAG,
};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};

use super::conditional::{is_known, wanted};
use super::parts::streamed;
use super::refusal::Refusal;

/// What is sent of an answer.
pub struct Part {
    pub status: StatusCode,
    pub headers: HeaderMap,
    /// Of its bytes.
    pub range: Range<u64>,
}

/// The headers of an answer with this tag.
pub fn tagged(tag: &HeaderValue) -> HeaderMap {
    let mut headers = HeaderMap::new();
    headers.insert(ETAG, tag.clone());
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    headers.insert(ACCEPT_RANGES, HeaderValue::from_static("bytes"));
    headers
}

/// That the client has the answer with this tag, if it says so.
pub fn not_modified(asked: &HeaderMap, tag: &HeaderValue) -> Option<Response> {
    is_known(asked, tag).then(|| (StatusCode::NOT_MODIFIED, tagged(tag)).into_response())
}

/// What is to be sent of so many bytes with this tag.
///
/// # Errors
/// There are no such bytes.
pub fn part(asked: &HeaderMap, tag: &HeaderValue, length: u64) -> Result<Part, Box<Response>> {
    let header = |text: String| HeaderValue::try_from(text);
    let internal = |error| Box::new(Refusal::internal(&error).into_response());
    let mut headers = tagged(tag);
    let bytes = usize::try_from(length).unwrap_or(usize::MAX);
    let (status, range) = match wanted(asked, tag, bytes) {
        None => (StatusCode::OK, 0..length),
        Some(Some(range)) => {
            let range = range.start as u64..range.end as u64;
            let told = format!("bytes {}-{}/{length}", range.start, range.end - 1);
            headers.insert(CONTENT_RANGE, header(told).map_err(internal)?);
            (StatusCode::PARTIAL_CONTENT, range)
        }
        Some(None) => {
            let detail = format!("there are {length} bytes");
            let refusal = Refusal::new(ProblemCode::RangeNotSatisfiable, detail);
            let told = header(format!("bytes */{length}")).map_err(internal)?;
            return Err(Box::new(([(CONTENT_RANGE, told)], refusal).into_response()));
        }
    };
    headers.insert(CONTENT_LENGTH, HeaderValue::from(range.end - range.start));
    Ok(Part {
        status,
        headers,
        range,
    })
}

/// Answers with a file, or the part of it that is asked for; `kind` tells it from others at the same
/// address, and `held` is let go of when it is sent.
pub fn file<T: Send + 'static>(
    mut file: File,
    kind: &str,
    (media_type, name): (&'static str, &str),
    asked: &HeaderMap,
    held: T,
) -> Result<Response, Refusal> {
    let internal = |error: &dyn std::error::Error| Refusal::internal(error);
    let of = file.metadata().map_err(|error| internal(&error))?;
    let written = of.modified().map_err(|error| internal(&error))?;
    // What is written in the place of a file is another one, written at another time.
    let written = written.duration_since(std::time::UNIX_EPOCH);
    let nanos = written.map_or(0, |time| time.as_nanos());
    let length = of.len();
    let header = |text: String| HeaderValue::try_from(text).map_err(|error| internal(&error));
    let tag = header(format!("\"{kind}-{length}-{nanos:x}\""))?;
    if let Some(known) = not_modified(asked, &tag) {
        return Ok(known);
    }
    let Part {
        status,
        mut headers,
        range,
    } = match part(asked, &tag, length) {
        Ok(part) => part,
        Err(refused) => return Ok(*refused),
    };
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(media_type));
    let disposition = header(format!("attachment; filename=\"{name}\""))?;
    headers.insert(CONTENT_DISPOSITION, disposition);
    let body = streamed(move |out| {
        let _held = held;
        file.seek(SeekFrom::Start(range.start))?;
        io::copy(&mut file.take(range.end - range.start), out).map(drop)
    });
    Ok((status, headers, body).into_response())
}

/// Hands on the bytes of a range, and counts all. More than the range has are not made: the next
/// write after its end fails with [`io::ErrorKind::WriteZero`].
pub struct Window<W> {
    out: W,
    range: Option<Range<u64>>,
    pub written: u64,
}

impl<W: Write> Window<W> {
    /// Onto all bytes where no range is given.
    pub fn new(out: W, range: Option<Range<u64>>) -> Self {
        Self {
            out,
            range,
            written: 0,
        }
    }

    /// Whether there is nothing to come that would be handed on.
    pub fn is_over(&self) -> bool {
        matches!(&self.range, Some(range) if self.written >= range.end)
    }
}

impl<W: Write> Write for Window<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_over() {
            return Err(io::ErrorKind::WriteZero.into());
        }
        let length = bytes.len() as u64;
        let own = match &self.range {
            None => 0..length,
            Some(range) => {
                let within = |place: u64| place.saturating_sub(self.written).min(length);
                within(range.start)..within(range.end)
            }
        };
        // Within the slice.
        self.out
            .write_all(&bytes[own.start as usize..own.end as usize])?;
        self.written += length;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn a_window_shows_its_bytes_however_they_are_written() {
        let all: Vec<u8> = (0..20).collect();
        for (from, to) in [(0, 20), (0, 1), (3, 9), (5, 5), (19, 20)] {
            for size in [1, 3, 7, 20] {
                let mut shown = Vec::new();
                let mut window = Window::new(&mut shown, Some(from..to));
                let ended = (all.chunks(size)).try_for_each(|part| window.write_all(part));
                assert_eq!(ended.is_err(), window.written < 20, "{from} {to} {size}");
                assert!(window.is_over());
                assert_eq!(shown, all[from as usize..to as usize], "{size}");
            }
        }
        let mut shown = Vec::new();
        let mut window = Window::new(&mut shown, None);
        window.write_all(&all).unwrap();
        assert_eq!((window.written, window.is_over()), (20, false));
        assert_eq!(shown, all);
    }
}
