//! What a job varies, as it is stored with the job.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::labels::shortened;
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
    use super::*;

    #[test]
    fn designs_of_earlier_versions_are_read() {
        let one = r#"{"seeds":3,"axes":[{"paths":["robots"],"values":[[1],[2]]}]}"#;
        let designs = Design::parse(one).unwrap();
        assert_eq!((designs.len(), designs[0].combinations()), (1, 2));
        assert_eq!(Design::parse(&format!("[{one}]")).unwrap(), designs);
        assert!(Design::parse("3").is_err());
    }
}
