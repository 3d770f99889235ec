//! A generator as written: its numbers checked, defaults filled in.

use serde::{Deserialize, Serialize};

use super::generator::{Generator, Layout};
use super::kinds::GeneratorKind;
use super::layouts::{Corridors, Maze, Rooms};
use super::obstacles::{ObstacleShape, RandomObstacles};
use crate::error::ArenaError;

/// `generate` as written. Which numbers a kind takes, with defaults, ranges and units, is in
/// [`GeneratorKind::parameters`]; a number that the kind does not take is an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "the table documents each")]
pub struct GenerateFormat {
    pub kind: GeneratorKind,
    /// Every seed makes another arena; 1 if left out.
    #[serde(default = "default_seed")]
    pub seed: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub braid: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub room_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gate_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corridor_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loops: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density_per_m2: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_length_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clear_m: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<ObstacleShape>,
}

fn default_seed() -> u64 {
    1
}

impl GenerateFormat {
    /// A kind with a seed, the rest at its defaults.
    pub fn new(kind: GeneratorKind, seed: u64) -> Self {
        Self {
            kind,
            seed,
            cell_m: None,
            braid: None,
            room_m: None,
            gate_m: None,
            corridor_m: None,
            loops: None,
            density_per_m2: None,
            wall_length_m: None,
            gap_m: None,
            clear_m: None,
            shape: None,
        }
    }

    fn numbers(&self) -> [(&'static str, Option<f64>); 10] {
        [
            ("cell_m", self.cell_m),
            ("braid", self.braid),
            ("room_m", self.room_m),
            ("gate_m", self.gate_m),
            ("corridor_m", self.corridor_m),
            ("loops", self.loops),
            ("density_per_m2", self.density_per_m2),
            ("wall_length_m", self.wall_length_m),
            ("gap_m", self.gap_m),
            ("clear_m", self.clear_m),
        ]
    }

    /// The value of one of the kind's own parameters, given or default.
    fn value(&self, name: &str) -> f64 {
        let given = self
            .numbers()
            .into_iter()
            .find_map(|(known, value)| value.filter(|_| known == name));
        let default = self
            .kind
            .parameters()
            .iter()
            .find(|parameter| parameter.name == name);
        // Callers ask for names of the kind's table only.
        given
            .or(default.map(|parameter| parameter.default))
            .unwrap_or_default()
    }

    /// Checks every number alone, then, if the size of the arena is known, those that depend on it.
    pub(crate) fn resolve(&self, size_m: Option<[f64; 2]>) -> Result<Generator, Vec<ArenaError>> {
        let mut errors = self.check_numbers();
        let layout = match self.kind {
            GeneratorKind::Maze => Layout::Maze(Maze {
                cell_m: self.value("cell_m"),
                braid: self.value("braid"),
            }),
            GeneratorKind::Rooms => Layout::Rooms(Rooms {
                room_m: self.value("room_m"),
                gate_m: self.value("gate_m"),
                loops: self.value("loops"),
            }),
            GeneratorKind::Corridors => Layout::Corridors(Corridors {
                cell_m: self.value("cell_m"),
                corridor_m: self.value("corridor_m"),
                loops: self.value("loops"),
            }),
            GeneratorKind::RandomObstacles => Layout::RandomObstacles(RandomObstacles {
                density_per_m2: self.value("density_per_m2"),
                wall_length_m: self.value("wall_length_m"),
                gap_m: self.value("gap_m"),
                clear_m: self.value("clear_m"),
                shape: self.shape.unwrap_or_default(),
            }),
        };
        if let (Some(size_m), true) = (size_m, errors.is_empty()) {
            errors.extend(match &layout {
                Layout::Maze(maze) => maze.check(size_m),
                Layout::Rooms(rooms) => rooms.check(size_m),
                Layout::Corridors(corridors) => corridors.check(size_m),
                Layout::RandomObstacles(obstacles) => obstacles.check(size_m),
            });
        }
        if errors.is_empty() {
            Ok(Generator {
                seed: self.seed,
                layout,
            })
        } else {
            Err(errors)
        }
    }

    fn check_numbers(&self) -> Vec<ArenaError> {
        let mut errors = Vec::new();
        let known = self.kind.parameters();
        let mut taken = known
            .iter()
            .map(|parameter| parameter.name)
            .collect::<Vec<_>>()
            .join(", ");
        taken.push_str(", seed");
        if self.kind == GeneratorKind::RandomObstacles {
            taken.push_str(", shape");
        }
        let not_taken = |name: &str| {
            ArenaError::new(
                format!("/generate/{name}"),
                format!("{} takes no {name}", self.kind.as_str()),
                &taken,
            )
        };
        for (name, value) in self.numbers() {
            let Some(value) = value else { continue };
            match known.iter().find(|parameter| parameter.name == name) {
                None => errors.push(not_taken(name)),
                Some(parameter) if !(parameter.min..=parameter.max).contains(&value) => {
                    errors.push(ArenaError::new(
                        format!("/generate/{name}"),
                        format!("{value} is out of range"),
                        format!("{} to {}", parameter.min, parameter.max),
                    ));
                }
                Some(_) => {}
            }
        }
        if self.shape.is_some() && self.kind != GeneratorKind::RandomObstacles {
            errors.push(not_taken("shape"));
        }
        errors
    }
}
