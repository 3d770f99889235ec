//! What a job varies, as it is stored with the job.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::labels::{Words, labels_of, shortened};
use super::matrix::Axis;

/// The runs of a job, or of a part of it: the product of the axes, the last one fastest, and of
/// seeds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Design {
    /// Name of the part, where the job has parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Seeds of each combination.
    pub seeds: usize,
    /// In order.
    pub axes: Vec<DesignAxis>,
}

/// An axis: places in the run spec that vary together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DesignAxis {
    /// Dotted paths, mostly one.
    pub paths: Vec<String>,
    /// For each value one entry a path; long ones in short.
    pub values: Vec<Vec<Value>>,
}

/// Designs as text: a list of parts, or as earlier versions stored it.
#[derive(Deserialize)]
#[serde(untagged)]
enum Stored {
    Parts(Vec<Design>),
    One(Design),
}

/// The label of a combination of a part.
pub(super) fn in_part(part: &str, label: &str) -> String {
    if label.is_empty() {
        part.to_owned()
    } else {
        format!("{part}: {label}")
    }
}

impl Design {
    pub(super) fn new(axes: &[Axis<'_>], seeds: usize) -> Self {
        Self {
            part: None,
            seeds,
            axes: axes.iter().map(DesignAxis::new).collect(),
        }
    }

    /// Combinations of the axes.
    pub fn combinations(&self) -> usize {
        self.axes.iter().map(|axis| axis.values.len()).product()
    }

    /// What each combination is called, as the labels of its runs call it: values that are stored
    /// in short read as they did in full.
    pub fn labels(&self) -> Vec<String> {
        let words = self.axes.iter().map(|axis| {
            let values = axis.values.iter();
            Words::new(axis.paths.join("+"), values)
        });
        let labels = labels_of(words.collect(), self.combinations()).into_iter();
        labels
            .map(|label| match &self.part {
                None => label,
                Some(part) => in_part(part, &label),
            })
            .collect()
    }

    /// A job's designs from their text.
    ///
    /// # Errors
    /// It is something else.
    pub fn parse(text: &str) -> serde_json::Result<Vec<Self>> {
        Ok(match serde_json::from_str(text)? {
            Stored::Parts(parts) => parts,
            Stored::One(design) => vec![design],
        })
    }
}

impl DesignAxis {
    fn new(axis: &Axis<'_>) -> Self {
        let targets = || 0..axis.targets.len();
        let values = |index| targets().map(move |target| shortened(axis.value(index, target)));
        Self {
            paths: axis
                .targets
                .iter()
                .map(|target| target.path.to_owned())
                .collect(),
            values: (0..axis.values.len())
                .map(|index| values(index).collect())
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use serde_json::json;

    use super::super::fields::Errors;
    use super::super::matrix::axes;
    use super::*;
    use crate::documents::{BuiltinArenas, expand};

    /// Runs are told apart by them after others of the job were deleted.
    #[test]
    fn a_design_calls_its_combinations_as_their_runs_are_called() {
        let long = "x".repeat(300);
        let job = json!({ "base": { "epochs": 1 }, "parts": [
            { "name": "plain" },
            { "name": "varied", "seeds": [3, 4], "matrix": {
                "epochs+steps_per_epoch": [[1, 100], [4, 25]],
                "sharing.mode": ["none", "arena"],
                "controller": [{ "method": "im" }, { "method": "im", "lambda": 3 }],
            } },
        ] });
        let expanded = expand(&job, &BuiltinArenas).unwrap();
        let labels = expanded.designs.iter().flat_map(|design| {
            let labels = design.labels().into_iter();
            labels.flat_map(|label| std::iter::repeat_n(label, design.seeds))
        });
        assert_eq!(labels.collect::<Vec<_>>(), expanded.labels);
        // As it is stored and as it was posted.
        let matrix = json!({ "name": [{ "name": long }, { "other": long }] });
        let axes = axes(&matrix, &mut Errors::default()).unwrap();
        assert_eq!(
            Design::new(&axes, 1).labels(),
            super::super::labels::labels(&axes, 2)
        );
    }

    #[test]
    fn designs_of_earlier_versions_are_read() {
        let one = r#"{"seeds":3,"axes":[{"paths":["robots"],"values":[[1],[2]]}]}"#;
        let designs = Design::parse(one).unwrap();
        assert_eq!((designs.len(), designs[0].combinations()), (1, 2));
        assert_eq!(Design::parse(&format!("[{one}]")).unwrap(), designs);
        assert!(Design::parse("3").is_err());
    }
}
