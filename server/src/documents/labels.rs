//! What of a job's matrix a combination has, in a few words: `alpha 0.5, arena maze`.

use serde_json::Value;

use super::matrix::{Axis, place_of};

/// Most characters of a value that is shown.
const MAX_CHARACTERS: usize = 40;

/// The words of an axis: its name and those of its values, no two alike.
struct Words {
    name: String,
    values: Vec<String>,
}

/// A label for each combination, in their order; axes of one value do not show.
pub fn labels(axes: &[Axis<'_>], combinations: usize) -> Vec<String> {
    let words: Vec<Option<Words>> = axes
        .iter()
        .map(|axis| (axis.values.len() > 1).then(|| words(axis, axes)))
        .collect();
    let label = |place| {
        let parts: Vec<String> = words
            .iter()
            .zip(place_of(axes, place))
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

fn words(axis: &Axis<'_>, axes: &[Axis<'_>]) -> Words {
    let name_of = short(axis.path);
    let alike = axes.iter().filter(|other| short(other.path) == name_of);
    let name = if alike.count() == 1 {
        name_of
    } else {
        axis.path.to_owned()
    };
    let mut values: Vec<String> = (0..axis.values.len())
        .map(|index| {
            let parts: Vec<String> = (0..axis.targets.len())
                .map(|target| in_short(axis.value(index, target)))
                .collect();
            parts.join(" + ")
        })
        .collect();
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
