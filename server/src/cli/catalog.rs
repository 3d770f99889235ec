//! `evswarm arenas` and `evswarm controllers`: what there is to choose from.

use std::path::{Path, PathBuf};

use anyhow::{Context, anyhow};
use api::ParameterListing;
use arenas::{Arena, SvgOptions};
use clap::Subcommand;
use swarm::robot::RobotParameters;

use super::{Failure, output};
use crate::documents::{self, ArenaSource, BuiltinArenas, arena_error};

/// Gates whose width differs from the robot's by at most this are told, metres.
const GATE_WITHIN_M: f64 = 1e-3;
/// Most gates that are told each.
const MOST_GATES: usize = 20;

#[derive(Debug, Subcommand)]
pub enum ArenasCommand {
    /// List the arenas that ship with the program.
    List,
    /// Check an arena file: exit code 2 and one line a wrong field, or 0.
    Check {
        /// The arena, a JSON file.
        file: PathBuf,
    },
    /// Draw an arena as SVG.
    Draw {
        /// Name of a built-in arena, or an arena file.
        name: String,
        /// File to write [default: standard output].
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
}

pub fn arenas(command: &ArenasCommand) -> Result<(), Failure> {
    match command {
        ArenasCommand::List => {
            for name in BuiltinArenas.names() {
                if let Some(arena) = BuiltinArenas.arena(&name) {
                    output::say(described(&arena))?;
                }
            }
            Ok(())
        }
        ArenasCommand::Check { file } => {
            let arena = load(file)?;
            let errors = arena.check_starts(body_radius_m());
            if !errors.is_empty() {
                let errors = errors.into_iter().map(arena_error);
                return Err(Failure::WrongSpec(errors.collect()));
            }
            output::say(described(&arena))?;
            for line in gates(&arena) {
                output::say(line)?;
            }
            Ok(())
        }
        ArenasCommand::Draw { name, out } => draw(name, out.as_deref()),
    }
}

fn draw(name: &str, out: Option<&Path>) -> Result<(), Failure> {
    let builtin = BuiltinArenas
        .arena(name)
        .map(|arena| arena.as_ref().clone());
    let arena = match builtin {
        Some(arena) => arena,
        None if Path::new(name).is_file() => load(Path::new(name))?,
        None => {
            let names = BuiltinArenas.names().join(", ");
            return Err(anyhow!("{name:?} is neither an arena ({names}) nor a file").into());
        }
    };
    let svg = arenas::render_svg(
        &arena,
        &SvgOptions {
            body_radius_m: body_radius_m(),
            ..SvgOptions::default()
        },
    );
    match out {
        None => output::say_bytes(svg.as_bytes()),
        Some(path) => {
            std::fs::write(path, svg)
                .with_context(|| format!("cannot write {}", path.display()))?;
            Ok(())
        }
    }
}

fn load(file: &Path) -> Result<Arena, Failure> {
    let text =
        std::fs::read_to_string(file).with_context(|| format!("cannot read {}", file.display()))?;
    documents::parse(&text)
        .and_then(|value| documents::read_arena(&value))
        .map_err(Failure::WrongSpec)
}

/// Radius of the default robot.
fn body_radius_m() -> f64 {
    RobotParameters::default().body_radius_m
}

fn described(arena: &Arena) -> String {
    let reachable = arena.starts().first().map_or(0, |start| {
        arenas::reachable(arena, *start, body_radius_m()).count
    });
    let squares = arenas::Squares::of(arena).count();
    format!(
        "{:<12} {} m x {} m, {} inner walls, {} starts, {reachable} of {squares} squares reachable",
        arena.name(),
        arena.width_m(),
        arena.height_m(),
        arena.walls().len(),
        arena.starts().len(),
    )
}

/// Gates about as wide as the default robot, each in words.
fn gates(arena: &Arena) -> Vec<String> {
    let body_m = 2.0 * body_radius_m();
    let gates = arenas::gates_at_the_limit(arena, body_radius_m(), GATE_WITHIN_M);
    let more = gates.len().saturating_sub(MOST_GATES);
    let mut lines: Vec<String> = gates
        .iter()
        .take(MOST_GATES)
        .map(|gate| {
            let (width_mm, beyond_mm) = (1e3 * gate.width_m, 1e3 * (gate.width_m - body_m));
            let than_body = if beyond_mm.abs() < 1e-6 {
                "exactly as wide as the robot".to_owned()
            } else if beyond_mm > 0.0 {
                format!("{beyond_mm:.6} mm wider than the robot")
            } else {
                format!("{:.6} mm narrower than the robot", -beyond_mm)
            };
            let state = if gate.open { "open" } else { "closed" };
            format!(
                "  at the limit: a gate of {width_mm:.6} mm at ({:.4}, {:.4}) m, {than_body}: {state}",
                gate.at.x, gate.at.y
            )
        })
        .collect();
    if more > 0 {
        lines.push(format!("  and {more} such gates more"));
    }
    lines
}

pub fn controllers(json: bool) -> Result<(), Failure> {
    let listing = documents::controllers();
    if json {
        return output::say(serde_json::to_string_pretty(&listing)?);
    }
    let mut lines = vec!["methods (controller.method):".to_owned()];
    for method in &listing.methods {
        lines.push(format!(
            "  {:<14} {}; trains: {}",
            method.name, method.about, method.trains
        ));
        let own = method.parameters.iter().map(parameter);
        lines.extend(own.map(|line| format!("  {line}")));
    }
    lines.push("\nparameters (controller.*):".to_owned());
    lines.extend(listing.parameters.iter().map(parameter));
    lines.push("\npresets (controller.preset), and what they set:".to_owned());
    for preset in &listing.controller_presets {
        let set = preset.parameters.iter();
        let set: Vec<String> = set.map(|(name, value)| format!("{name} {value}")).collect();
        let line = format!("  {:<14} {}", preset.name, set.join(", "));
        lines.push(line.trim_end().to_owned());
    }
    lines.push(format!(
        "\nrobot presets (robot.preset): {}",
        listing.presets.join(", ")
    ));
    lines.push("\nrobot parameters (robot.*), defaults of the first preset:".to_owned());
    lines.extend(listing.robot_parameters.iter().map(parameter));
    output::say(lines.join("\n"))
}

fn parameter(parameter: &ParameterListing) -> String {
    let ParameterListing {
        name,
        default,
        unit,
        about,
        source,
        domain,
    } = parameter;
    let unit = if unit.is_empty() || unit == "1" {
        String::new()
    } else {
        format!(" {unit}")
    };
    let range = match (&domain["min"], &domain["max"], domain["names"].as_array()) {
        (_, _, Some(names)) => names
            .iter()
            .filter_map(|name| name.as_str())
            .collect::<Vec<_>>()
            .join(" | "),
        (min, max, None) => format!("{min} to {max}"),
    };
    format!("  {name:<30} {default}{unit} ({range})\n      {about} [{source}]")
}
