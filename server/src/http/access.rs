//! Tokens: who may read and who may change something. Only digests are kept, so that whoever reads
//! the file or the process's memory learns no token; failed attempts are counted by address.

use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use hashlink::LruCache;
use sha2::{Digest, Sha256};

/// Shortest token that is taken for a secret.
pub const MIN_TOKEN_BYTES: usize = 16;
/// Most tokens of a file.
const MAX_TOKENS: usize = 10_000;
/// Failed attempts of one address that are answered as such ...
const MAX_FAILED: u32 = 20;
/// ... within this time.
const FAILED_WITHIN: Duration = Duration::from_secs(60);
/// Addresses whose failed attempts are counted; the least recent give way.
const MAX_ADDRESSES: usize = 1_024;

/// What a token allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Right {
    /// To read.
    Read,
    /// To read and to change.
    Write,
}

/// The tokens of a server; without any, none is asked for.
#[derive(Clone, Debug, Default)]
pub struct Tokens(Vec<([u8; 32], Right)>);

impl Tokens {
    /// The tokens of a file: a line for each, `NAME read|write sha256:HEX`. Empty lines and those
    /// that begin with `#` do not count.
    ///
    /// # Errors
    /// The line that is something else, by its number.
    pub fn parse(text: &str) -> Result<Self, String> {
        let lines = (1..).zip(text.lines().map(str::trim));
        let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let read = |(number, line): (usize, &str)| {
            token(line).ok_or_else(|| {
                format!("line {number} is not of the form: NAME read|write sha256:HEX")
            })
        };
        let tokens: Vec<_> = lines.map(read).collect::<Result<_, _>>()?;
        match tokens.len() {
            0 => Err("there is no token in it".to_owned()),
            1..=MAX_TOKENS => Ok(Self(tokens)),
            _ => Err(format!("there are more than {MAX_TOKENS} tokens in it")),
        }
    }

    /// With this token besides, which allows everything.
    ///
    /// # Errors
    /// It is too short.
    pub fn with_secret(mut self, secret: &str) -> Result<Self, String> {
        if secret.len() < MIN_TOKEN_BYTES {
            return Err(format!("a token has at least {MIN_TOKEN_BYTES} characters"));
        }
        self.0.push((digest(secret), Right::Write));
        Ok(self)
    }

    /// Whether no token is asked for.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What this token allows. Digests are compared, and all of them, so that the time it takes
    /// tells nothing of the tokens.
    pub fn right(&self, secret: &str) -> Option<Right> {
        let digest = digest(secret);
        self.0.iter().fold(None, |found, (known, right)| {
            if *known == digest {
                Some(*right)
            } else {
                found
            }
        })
    }
}

/// The line of a token in a file.
pub fn line(name: &str, right: Right, secret: &str) -> String {
    let right = match right {
        Right::Read => "read",
        Right::Write => "write",
    };
    let digits = hex::encode(digest(secret));
    format!("{name} {right} sha256:{digits}")
}

fn token(line: &str) -> Option<([u8; 32], Right)> {
    let mut words = line.split_whitespace();
    let (_name, right, digits) = (words.next()?, words.next()?, words.next()?);
    let right = match right {
        "read" => Right::Read,
        "write" => Right::Write,
        _ => return None,
    };
    let digits = digits.strip_prefix("sha256:")?;
    let is_hex = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    if words.next().is_some() || digits.len() != 64 || !is_hex {
        return None;
    }
    let mut digest = [0; 32];
    for (byte, place) in digest.iter_mut().zip((0..).step_by(2)) {
        *byte = u8::from_str_radix(&digits[place..place + 2], 16).ok()?;
    }
    Some((digest, right))
}

fn digest(secret: &str) -> [u8; 32] {
    Sha256::digest(secret).into()
}

/// Failed attempts by address.
pub struct Failures(Mutex<LruCache<IpAddr, (u32, Instant)>>);

impl Default for Failures {
    fn default() -> Self {
        Self(Mutex::new(LruCache::new(MAX_ADDRESSES)))
    }
}

impl Failures {
    /// Counts one; tells whether they are too many. A right token is let in all the same: one that
    /// is long enough cannot be guessed, and nobody behind the same address is shut out.
    pub fn count(&self, address: IpAddr) -> bool {
        let mut failed = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let (count, since) = match failed.get(&address) {
            Some((count, since)) if now.duration_since(*since) < FAILED_WITHIN => {
                (count.saturating_add(1), *since)
            }
            _ => (1, now),
        };
        failed.insert(address, (count, since));
        count > MAX_FAILED
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn files_of_tokens_are_read_or_refused() {
        let reader = line("ann", Right::Read, "ann's long secret");
        let writer = line("bob", Right::Write, "bob's long secret");
        let text = format!("# who\n\n{reader}\n  {writer}  \n");
        let tokens = Tokens::parse(&text).unwrap();
        let tokens = tokens.with_secret("of the environment").unwrap();
        for (secret, right) in [
            ("ann's long secret", Some(Right::Read)),
            ("bob's long secret", Some(Right::Write)),
            ("of the environment", Some(Right::Write)),
            ("bob's long secret ", None),
            ("", None),
        ] {
            assert_eq!(tokens.right(secret), right, "{secret}");
        }
        assert!(!text.contains("secret"));
        for wrong in [
            "",
            "# nobody",
            "ann read",
            "ann admin sha256:00",
            "ann read sha256:00",
            &format!("{reader} more"),
            &reader.replace("sha256:", "md5:"),
            &reader.replace("sha256:", "sha256:é"),
        ] {
            assert!(Tokens::parse(wrong).is_err(), "{wrong}");
        }
        let told = Tokens::parse(&format!("{reader}\nbob\n")).unwrap_err();
        assert!(told.starts_with("line 2 "), "{told}");
        assert!(Tokens::default().with_secret("short").is_err());
    }

    #[test]
    fn failures_are_counted_by_address() {
        let failures = Failures::default();
        let here = IpAddr::from([127, 0, 0, 1]);
        for _ in 0..MAX_FAILED {
            assert!(!failures.count(here));
        }
        assert!(failures.count(here));
        assert!(!failures.count(IpAddr::from([127, 0, 0, 2])));
    }
}
