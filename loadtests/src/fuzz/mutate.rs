//! Changes at random: of documents as trees (values, fields, lists, parts of other documents) and
//! of bytes.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Map, Value, json};

/// Right inputs that are kept to begin with, beside those that are given.
const MAX_LEARNT: usize = 256;
/// Longest input that is kept.
const MAX_LEARNT_BYTES: usize = 64 << 10;

/// Makes inputs.
pub struct Mutator {
    random: Pcg64Mcg,
    given: Vec<Vec<u8>>,
    learnt: Vec<Vec<u8>>,
    names: Vec<String>,
}

impl Mutator {
    /// From these inputs.
    pub fn new(seed: u64, given: Vec<Vec<u8>>) -> Self {
        let mut names: Vec<String> = Vec::new();
        for document in given
            .iter()
            .filter_map(|text| serde_json::from_slice(text).ok())
        {
            gather_names(&document, &mut names);
        }
        names.extend(["", "$schema", "from", "x", "~/"].map(str::to_owned));
        names.sort();
        names.dedup();
        Self {
            random: Pcg64Mcg::seed_from_u64(seed),
            given,
            learnt: Vec::new(),
            names,
        }
    }

    /// Begins with this input too.
    pub fn learn(&mut self, input: &[u8]) {
        if input.len() > MAX_LEARNT_BYTES {
            return;
        }
        if self.learnt.len() < MAX_LEARNT {
            self.learnt.push(input.to_vec());
        } else {
            let place = self.below(MAX_LEARNT);
            self.learnt[place] = input.to_vec();
        }
    }

    /// The next input.
    pub fn input(&mut self, is_text: bool) -> Vec<u8> {
        let mut bytes = self.any_input();
        let document = match is_text {
            true => serde_json::from_slice(&bytes).ok(),
            false => None,
        };
        if let Some(mut document) = document
            && self.below(8) > 0
        {
            for _ in 0..=self.below(4) {
                let mut place = self.below(count(&document));
                self.change(&mut document, &mut place);
            }
            bytes = document.to_string().into_bytes();
            if self.below(8) > 0 {
                return bytes;
            }
        }
        for _ in 0..=self.below(6) {
            self.change_bytes(&mut bytes);
        }
        bytes
    }

    /// Three times of four.
    pub fn is_rather(&mut self) -> bool {
        self.below(4) > 0
    }

    fn below(&mut self, number: usize) -> usize {
        (self.random.next_u64() % number.max(1) as u64) as usize
    }

    fn any_input(&mut self) -> Vec<u8> {
        let place = self.below(self.given.len() + self.learnt.len());
        match self.given.get(place) {
            Some(input) => input.clone(),
            None => self.learnt[place - self.given.len()].clone(),
        }
    }

    /// Changes the value at a place of the tree, counted from its top.
    fn change(&mut self, at: &mut Value, place: &mut usize) {
        if *place == 0 {
            *place = usize::MAX;
            return self.change_here(at);
        }
        *place -= 1;
        let inside: Vec<&mut Value> = match at {
            Value::Object(map) => map.values_mut().collect(),
            Value::Array(list) => list.iter_mut().collect(),
            _ => return,
        };
        for value in inside {
            if *place == usize::MAX {
                return;
            }
            self.change(value, place);
        }
    }

    fn change_here(&mut self, at: &mut Value) {
        let what = self.below(6);
        match at {
            Value::Object(map) if what < 4 => self.change_object(map, what),
            Value::Array(list) if what < 5 => self.change_list(list, what),
            Value::Number(number) if what < 3 => {
                let number = number.as_f64().unwrap_or_default();
                let near = [
                    number + 1.0,
                    number - 1.0,
                    -number,
                    number * 2.0,
                    number * 1e3,
                    number / 7.0,
                ];
                let near = near[self.below(near.len())];
                *at = match self.below(2) {
                    0 => json!(near),
                    _ => json!(near as i64),
                };
            }
            Value::String(text) if what < 2 => {
                let end = self.below(text.chars().count() + 1);
                *text = text.chars().take(end).collect();
            }
            at => *at = self.value(),
        }
    }

    fn change_object(&mut self, map: &mut Map<String, Value>, what: usize) {
        let key = (!map.is_empty()).then(|| self.below(map.len()));
        let key = key.and_then(|key| map.keys().nth(key).cloned());
        match (what, key) {
            (0, Some(key)) => drop(map.remove(&key)),
            (1, Some(key)) => {
                let value = map.remove(&key).unwrap_or_default();
                let name = self.name();
                map.insert(name, value);
            }
            _ => {
                let (name, value) = (self.name(), self.value());
                map.insert(name, value);
            }
        }
    }

    fn change_list(&mut self, list: &mut Vec<Value>, what: usize) {
        let place = self.below(list.len());
        match what {
            0 if !list.is_empty() => drop(list.remove(place)),
            1 if !list.is_empty() => {
                let times = [1, 2, 20, 300][self.below(4)];
                let value = list[place].clone();
                list.extend(std::iter::repeat_n(value, times));
            }
            2 if !list.is_empty() => {
                let other = self.below(list.len());
                list.swap(place, other);
            }
            _ => {
                let value = self.value();
                list.insert(place, value);
            }
        }
    }

    fn name(&mut self) -> String {
        let place = self.below(self.names.len());
        self.names[place].clone()
    }

    /// A value: a plain one, or a part of another document.
    fn value(&mut self) -> Value {
        const NUMBERS: [f64; 22] = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            2.0,
            7.0,
            0.1,
            0.5,
            1e-9,
            5e-324,
            1e3,
            1e5,
            1e6,
            1e7,
            4294967295.0,
            4294967296.0,
            9007199254740991.0,
            9007199254740993.0,
            1.8446744073709552e19,
            1e100,
            1.7976931348623157e308,
            -1e308,
        ];
        match self.below(12) {
            0 => Value::Null,
            1 => json!(self.below(2) == 0),
            2 | 3 => json!(NUMBERS[self.below(NUMBERS.len())]),
            4 => json!(self.random.next_u64()),
            5 => json!(self.below(2_000)),
            6 => json!(self.name()),
            7 => json!("é\u{0}".repeat([1, 30, 3_000][self.below(3)])),
            8 => json!([]),
            9 => json!({}),
            _ => {
                let Ok(document) = serde_json::from_slice(&self.any_input()) else {
                    return Value::Null;
                };
                let mut place = self.below(count(&document));
                part(&document, &mut place).cloned().unwrap_or_default()
            }
        }
    }

    fn change_bytes(&mut self, bytes: &mut Vec<u8>) {
        let place = self.below(bytes.len());
        let end = (place + 1 + self.below(16)).min(bytes.len());
        match self.below(7) {
            0 if !bytes.is_empty() => bytes[place] ^= 1 << self.below(8),
            1 if !bytes.is_empty() => bytes[place] = self.random.next_u64() as u8,
            2 => drop(bytes.drain(place..end)),
            3 => bytes.truncate(place),
            4 => {
                let again = bytes[place..end].to_vec();
                bytes.splice(place..place, again);
            }
            5 => {
                const TEXTS: [&[u8]; 9] = [
                    b"{",
                    b"]",
                    b"\"",
                    b",",
                    b"1e999",
                    b"\xff\xfe",
                    b"\\u0000",
                    b"null",
                    b"-",
                ];
                let text = TEXTS[self.below(TEXTS.len())];
                bytes.splice(place..place, text.iter().copied());
            }
            _ => {
                let other = self.any_input();
                let from = self.below(other.len());
                let to = (from + self.below(64)).min(other.len());
                bytes.splice(place..place, other[from..to].iter().copied());
            }
        }
    }
}

fn count(value: &Value) -> usize {
    1 + match value {
        Value::Object(map) => map.values().map(count).sum(),
        Value::Array(list) => list.iter().map(count).sum(),
        _ => 0,
    }
}

fn part<'a>(value: &'a Value, place: &mut usize) -> Option<&'a Value> {
    if *place == 0 {
        return Some(value);
    }
    *place -= 1;
    match value {
        Value::Object(map) => map.values().find_map(|inside| part(inside, place)),
        Value::Array(list) => list.iter().find_map(|inside| part(inside, place)),
        _ => None,
    }
}

fn gather_names(value: &Value, names: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            for (name, inside) in map {
                names.push(name.clone());
                gather_names(inside, names);
            }
        }
        Value::Array(list) => list.iter().for_each(|inside| gather_names(inside, names)),
        Value::String(text) if text.len() < 40 => names.push(text.clone()),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_inputs_and_they_differ() {
        let given = vec![br#"{"epochs":3,"arena":{"tile":[1,2]}}"#.to_vec()];
        let inputs = |seed| {
            let mut mutator = Mutator::new(seed, given.clone());
            (0..200).map(|_| mutator.input(true)).collect::<Vec<_>>()
        };
        assert_eq!(inputs(1), inputs(1));
        assert_ne!(inputs(1), inputs(2));
        let changed = inputs(1).iter().filter(|input| **input != given[0]).count();
        assert!(changed > 150, "{changed}");
    }
}
