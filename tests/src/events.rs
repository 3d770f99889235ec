//! A stream of server-sent events, read by hand.

use std::io::{BufRead, BufReader, Read};

use api::events::Event;
use serde_json::json;

/// An event as it was sent.
#[derive(Clone, Debug, PartialEq)]
pub struct Heard {
    /// What to come back with; empty where it has none.
    pub id: String,
    /// The event.
    pub event: Event,
}

/// Reads events one after the other.
pub struct Listener {
    lines: Box<dyn Iterator<Item = std::io::Result<String>>>,
}

impl Listener {
    /// Of the body of an answer.
    pub fn new(body: impl Read + 'static) -> Self {
        Self {
            lines: Box::new(BufReader::new(body).lines()),
        }
    }

    /// Reads until an event is the one that is looked for; gives all of them.
    pub fn until(&mut self, is_last: impl Fn(&Event) -> bool) -> Vec<Heard> {
        let mut heard = Vec::new();
        loop {
            let next = self.next().unwrap();
            let last = is_last(&next.event);
            heard.push(next);
            if last {
                return heard;
            }
        }
    }
}

impl Iterator for Listener {
    type Item = Heard;

    fn next(&mut self) -> Option<Heard> {
        let (mut id, mut name, mut data) = (String::new(), String::new(), String::new());
        for line in &mut self.lines {
            let line = line.unwrap();
            if line.is_empty() && !name.is_empty() {
                let data: serde_json::Value = serde_json::from_str(&data).unwrap();
                let event = json!({ "event": name, "data": data });
                return Some(Heard {
                    id,
                    event: serde_json::from_value(event).unwrap(),
                });
            }
            let (field, value) = line.split_once(':').unwrap_or((&line, ""));
            let value = value.strip_prefix(' ').unwrap_or(value);
            match field {
                "id" => value.clone_into(&mut id),
                "event" => value.clone_into(&mut name),
                "data" => data.push_str(value),
                _ => {}
            }
        }
        None
    }
}
