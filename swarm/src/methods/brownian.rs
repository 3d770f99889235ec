//! Brownian moves.

use super::definition::{Definition, Explores, Trains, explore_only, no_check, no_parameters};
use super::walker::Walker;
use crate::controllers::Brownian;
use crate::spec::{Method, RunSpec};

pub(super) static BROWNIAN: Definition = Definition {
    method: Method::Brownian,
    about: "Each command uniform in the action space",
    source: "section 5.2.3",
    trains: Trains::Never,
    objective: None,
    explores: Explores::Walking,
    parameters: no_parameters,
    check: no_check,
    stages: explore_only,
};

impl Walker for Brownian {
    fn new(_spec: &RunSpec, key: u64) -> Self {
        Self::new(key)
    }
}
