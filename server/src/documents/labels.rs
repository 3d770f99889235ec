//! What of a job's matrix a combination has, in a few words: `alpha 0.5, arena maze`.

use serde_json::Value;

use super::matrix::{Axis, indices_at};

/// Most characters of a value that is shown.
const MAX_CHARACTERS: usize = 40;

/// The words of an axis: its name and those of its values.
pub struct Words {
    name: String,
    values: Vec<String>,
}

impl Words {
    /// Of an axis at this path (several with `+` between them), whose values have an entry a path.
    pub fn new<'a, V>(path: impl Into<String>, values: impl Iterator<Item = V>) -> Self
    where
        V: IntoIterator<Item = &'a Value>,
    {
        let value = |entries: V| {
            let parts: Vec<String> = entries.into_iter().map(in_short).collect();
            parts.join(" + ")
        };
        Self {
            name: path.into(),
            values: values.map(value).collect(),
        }
    }
}

/// A label for each combination, in their order; axes of one value do not show.
pub fn labels(axes: &[Axis<'_>], combinations: usize) -> Vec<String> {
    let words = axes.iter().map(|axis| {
        let entries = |index| (0..axis.targets.len()).map(move |target| axis.value(index, target));
        Words::new(axis.path, (0..axis.values.len()).map(entries))
    });
    labels_of(words.collect(), combinations)
}

/// The same from the words of the axes.
pub fn labels_of(axes: Vec<Words>, combinations: usize) -> Vec<String> {
    let lengths: Vec<usize> = axes.iter().map(|axis| axis.values.len()).collect();
    let paths: Vec<String> = axes.iter().map(|axis| axis.name.clone()).collect();
    let words: Vec<Option<Words>> = axes
        .into_iter()
        .map(|axis| (axis.values.len() > 1).then(|| told_apart(axis, &paths)))
        .collect();
    let label = |place| {
        let parts: Vec<String> = words
            .iter()
            .zip(indices_at(lengths.iter().copied(), place))
            .filter_map(|(words, index)| {
                let words = words.as_ref()?;
                Some(format!("{} {}", words.name, words.values[index]))
            })
            .collect();
        parts.join(", ")
    };
    (0..combinations).map(label).collect()
}

/// The last names of an axis' paths.
fn short(path: &str) -> String {
    let last = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
    path.split('+').map(last).collect::<Vec<_>>().join("+")
}

/// With a name no longer than it must be, and no two values alike.
fn told_apart(axis: Words, paths: &[String]) -> Words {
    let Words {
        name: path,
        mut values,
    } = axis;
    let name = short(&path);
    let alike = paths.iter().filter(|other| short(other) == name).count();
    let name = if alike == 1 { name } else { path };
    let mut sorted: Vec<&String> = values.iter().collect();
    sorted.sort();
    if sorted.windows(2).any(|pair| pair[0] == pair[1]) {
        for (index, value) in values.iter_mut().enumerate() {
            value.push_str(&format!(" #{}", index + 1));
        }
    }
    Words { name, values }
}

/// A value as it is, or in short where it is long.
pub fn shortened(value: &Value) -> Value {
    if value.to_string().len() <= 200 {
        value.clone()
    } else {
        Value::from(in_short(value))
    }
}

/// A value in short: of an object what names it, if anything does.
fn in_short(value: &Value) -> String {
    let naming = ["name", "method", "preset", "mode"];
    let text = match naming.into_iter().find_map(|field| value.get(field)) {
        Some(Value::String(name)) => name.clone(),
        _ => match value {
            Value::String(text) => text.clone(),
            _ => value.to_string(),
        },
    };
    match text.char_indices().nth(MAX_CHARACTERS) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::json;

    use super::super::fields::Errors;
    use super::super::matrix::axes;
    use super::*;

    #[test]
    fn labels_tell_combinations_apart_in_few_words() {
        let matrix = json!({
            "controller.alpha": [0.5, 0.7], "epochs": [9],
            "controller": [{ "method": "im" }, { "method": "im", "lambda": 3 }],
        });
        let axes = axes(&matrix, &mut Errors::default()).unwrap();
        assert_eq!(
            labels(&axes, 4),
            [
                "controller im #1, alpha 0.5",
                "controller im #1, alpha 0.7",
                "controller im #2, alpha 0.5",
                "controller im #2, alpha 0.7",
            ]
        );
        let matrix = json!({
            "arena": ["easy", { "name": "mine" }], "controller.train.arena": ["easy", "maze"]
        });
        let axes = super::super::matrix::axes(&matrix, &mut Errors::default()).unwrap();
        let labels = labels(&axes, 4);
        assert_eq!(labels[2], "arena mine, controller.train.arena easy");
        assert_eq!(super::labels(&[], 1), [""]);
    }
}
