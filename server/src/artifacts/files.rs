//! The table of a run's files: what `evswarm run` writes into its directory, what the service gives
//! below `/v1/runs/{id}/`, and how each is made. Router, directory, page and README follow it.

use std::borrow::Cow;
use std::sync::Arc;

use arenas::Squares;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use swarm::run::{CurveRow, MetricsLog};

use super::tables::curve_row;
use super::{
    coverage_csv, coverage_json, coverage_png, coverage_svg, curve_csv, metrics_csv, metrics_json,
    objects_csv, objects_json, pushed, robots_csv, visits_npy,
};
use crate::documents::ResolvedRun;
use crate::exports::metrics_of_run;
use crate::store::Findings;
use crate::tables::Form;

const JSON: &str = "application/json";
const CSV: &str = "text/csv; charset=utf-8";
const PARQUET: &str = Form::Parquet.media_type();
const BYTES: &str = "application/octet-stream";

/// Something about a run that can be read, in one format.
#[derive(Debug)]
pub struct RunFile {
    /// Name in the output directory; `None` where only the service has it.
    pub name: Option<&'static str>,
    /// Route below `/v1/runs/{id}/`; `None` where only the directory has it.
    pub route: Option<&'static str>,
    /// What it is sent as.
    pub media_type: &'static str,
    /// How it is made.
    pub maker: Maker,
    /// The schema of one that is JSON.
    pub shape: Option<fn(&mut SchemaGenerator) -> Schema>,
    /// What it holds; empty where it is another format of the one before.
    pub holds: &'static str,
    /// Written only where the arena has movable objects.
    pub needs_objects: bool,
    /// Worth keeping once it is made.
    pub is_dear: bool,
}

/// How a file is made.
#[derive(Clone, Copy, Debug)]
pub enum Maker {
    /// The spec with every default filled in; there before the run begins.
    Spec,
    /// The result; there when the run is done.
    Result,
    /// What it took; only `evswarm run` knows that.
    Timing,
    /// While the run is stepped, where its spec asks for it.
    Recording,
    /// From what the run has found at some moment.
    Findings(fn(&Material<'_>) -> Vec<u8>),
}

/// What files are made of.
#[derive(Clone, Copy)]
pub struct Material<'a> {
    /// What is run.
    pub spec: &'a ResolvedRun,
    /// What it has found.
    pub findings: &'a Findings,
    /// Finds the squares within reach; only some files need them.
    pub reachable: &'a dyn Fn() -> Option<Arc<[bool]>>,
    /// Most rows that the curve may have.
    pub curve_points: Option<usize>,
}

impl RunFile {
    /// What it holds, also where it is another format of the one before.
    pub fn about(&self) -> &'static str {
        let place = RUN_FILES
            .iter()
            .position(|file| std::ptr::eq(file, self))
            .unwrap_or(0);
        let before = RUN_FILES[..=place].iter().rev();
        before
            .map(|file| file.holds)
            .find(|holds| !holds.is_empty())
            .unwrap_or_default()
    }
}

impl<'a> Material<'a> {
    /// Counts a square; zeros for a run that has none yet.
    fn grid(&self, counts: &'a [u32]) -> Cow<'a, [u32]> {
        match counts {
            [] => Cow::Owned(vec![0; Squares::of(self.spec.arena()).count()]),
            counts => Cow::Borrowed(counts),
        }
    }

    fn visits(&self) -> Cow<'a, [u32]> {
        self.grid(&self.findings.visits)
    }

    fn npy(&self, counts: &'a [u32]) -> Vec<u8> {
        visits_npy(&self.grid(counts), self.spec.arena().squares())
    }
}

/// A file in the form of another one.
const fn form(
    name: Option<&'static str>,
    route: Option<&'static str>,
    media_type: &'static str,
    maker: Maker,
) -> RunFile {
    RunFile {
        name,
        route,
        media_type,
        maker,
        shape: None,
        holds: "",
        needs_objects: false,
        is_dear: false,
    }
}

/// A JSON file of this shape that only the service has.
const fn json<T: JsonSchema>(route: &'static str, maker: Maker) -> RunFile {
    RunFile {
        shape: Some(SchemaGenerator::subschema_for::<T>),
        ..form(None, Some(route), JSON, maker)
    }
}

const fn holding(file: RunFile, holds: &'static str) -> RunFile {
    RunFile { holds, ..file }
}

/// Every file of a run. Formats of the same thing follow each other.
pub static RUN_FILES: &[RunFile] = &[
    holding(
        form(Some("spec.json"), Some("spec"), JSON, Maker::Spec),
        "the run spec with every default filled in",
    ),
    holding(
        form(Some("result.json"), Some("result"), JSON, Maker::Result),
        "`p1` to `p10`, the same by steps spent in a square (`dwell`), reachable squares, swarm metrics, steps, collisions, clusters, accuracy of \
         the transition model, bytes and memory plan of the learners, SHA-256 of the final state",
    ),
    holding(
        json::<Vec<api::CurveRow>>(
            "curve",
            Maker::Findings(|run| compact(&thinned(&run.findings.curve, run.curve_points))),
        ),
        "coverage after each epoch",
    ),
    form(
        Some("curve.csv"),
        Some("curve.csv"),
        CSV,
        Maker::Findings(|run| curve_csv(&run.findings.curve).into_bytes()),
    ),
    holding(
        json::<api::Metrics>(
            "metrics",
            Maker::Findings(|run| compact(&metrics_json(&run.findings.metrics, run.spec.step_s()))),
        ),
        "coverage, entropy, overlap, collisions, distance over time \
         ([docs/metrics.md](docs/metrics.md))",
    ),
    form(
        Some("metrics.csv"),
        Some("metrics.csv"),
        CSV,
        Maker::Findings(|run| metrics_csv(&run.findings.metrics, run.spec.step_s()).into_bytes()),
    ),
    form(
        None,
        Some("metrics.parquet"),
        PARQUET,
        Maker::Findings(|run| metrics_parquet(&run.findings.metrics, run.spec.step_s())),
    ),
    holding(
        json::<api::ObjectTracks>(
            "objects",
            Maker::Findings(|run| {
                let (arena, step_s) = (run.spec.arena(), run.spec.step_s());
                compact(&objects_json(arena, &run.findings.tracks, step_s))
            }),
        ),
        "pose of each movable object and how far it was moved, over time; only where the arena has \
         objects",
    ),
    RunFile {
        needs_objects: true,
        ..form(
            Some("objects.csv"),
            Some("objects.csv"),
            CSV,
            Maker::Findings(|run| objects_csv(&run.findings.tracks).into_bytes()),
        )
    },
    holding(
        form(
            Some("robots.csv"),
            Some("robots.csv"),
            CSV,
            Maker::Findings(|run| robots_csv(&run.findings.metrics).into_bytes()),
        ),
        "first entries, distance, learner's bytes and vectors that found no cluster, of each robot",
    ),
    holding(
        json::<api::Coverage>(
            "coverage",
            Maker::Findings(|run| {
                let mask = (run.reachable)().unwrap_or_default();
                compact(&coverage_json(run.spec.arena(), &run.visits(), &mask))
            }),
        ),
        "entries counted a square, `uint32`, row 0 the lowest y",
    ),
    form(
        Some("visits.npy"),
        Some("coverage.npy"),
        BYTES,
        Maker::Findings(|run| run.npy(&run.findings.visits)),
    ),
    form(
        None,
        Some("coverage.csv"),
        CSV,
        Maker::Findings(|run| {
            coverage_csv(&run.visits(), run.spec.arena().squares()[0]).into_bytes()
        }),
    ),
    holding(
        form(
            None,
            Some("dwell.npy"),
            BYTES,
            Maker::Findings(|run| run.npy(&run.findings.dwell)),
        ),
        "steps spent a square, in the same form",
    ),
    holding(
        RunFile {
            is_dear: true,
            ..form(
                Some("coverage.png"),
                Some("coverage.png"),
                "image/png",
                Maker::Findings(|run| {
                    let objects = pushed(run.spec, &run.findings.tracks);
                    let mask = (run.reachable)();
                    coverage_png(run.spec.arena(), &run.visits(), mask.as_deref(), &objects)
                }),
            )
        },
        "the visits over the arena's walls; movable objects where they are, with where they began \
         and their way",
    ),
    form(
        None,
        Some("coverage.svg"),
        "image/svg+xml",
        Maker::Findings(|run| {
            let objects = pushed(run.spec, &run.findings.tracks);
            let mask = (run.reachable)();
            coverage_svg(run.spec.arena(), &run.visits(), mask.as_deref(), &objects).into_bytes()
        }),
    ),
    holding(
        form(
            Some("recording.evrec"),
            Some("recording"),
            BYTES,
            Maker::Recording,
        ),
        "what robots did, step by step; only where the spec says `record` \
         ([docs/recordings.md](docs/recordings.md))",
    ),
    holding(
        form(Some("timing.json"), None, JSON, Maker::Timing),
        "seconds, speed, machine: the only file that may differ between two equal runs",
    ),
];

/// A document as it is sent.
fn compact(document: &impl Serialize) -> Vec<u8> {
    #[allow(
        clippy::expect_used,
        reason = "structs of numbers and strings: JSON can hold all of them"
    )]
    serde_json::to_vec(document).expect("a document is JSON")
}

/// A table as it is sent.
fn metrics_parquet(log: &MetricsLog, step_s: f64) -> Vec<u8> {
    #[allow(
        clippy::expect_used,
        reason = "memory takes every byte, and cells are of their columns' kinds: a test writes all"
    )]
    metrics_of_run(log, step_s).expect("a table is written into memory")
}

/// At most `points` rows, evenly spread, the last always there.
fn thinned(curve: &[CurveRow], points: Option<usize>) -> Vec<api::CurveRow> {
    match points {
        Some(points) if points >= 2 && points < curve.len() => (0..points)
            .map(|point| curve_row(&curve[point * (curve.len() - 1) / (points - 1)]))
            .collect(),
        _ => curve.iter().map(curve_row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thinned_curve_keeps_both_ends() {
        let row = |epoch| CurveRow {
            epoch,
            p1: epoch,
            p2: 0,
            p5: 0,
            p10: 0,
        };
        let curve: Vec<_> = (1..=1_000).map(row).collect();
        for points in [2, 3, 7, 999] {
            let thin = thinned(&curve, Some(points));
            assert_eq!(thin.len(), points);
            assert_eq!((thin[0].epoch, thin[points - 1].epoch), (1, 1_000));
            assert!(thin.windows(2).all(|pair| pair[0].epoch < pair[1].epoch));
        }
        assert_eq!(thinned(&curve, Some(1_000)).len(), 1_000);
        assert_eq!(thinned(&curve, None).len(), 1_000);
        assert!(thinned(&[], Some(5)).is_empty());
    }

    /// The rows of the README's table, as they follow from this one.
    fn readme_rows() -> String {
        let cell = |texts: Vec<&str>| {
            let quoted: Vec<String> = texts.iter().map(|text| format!("`{text}`")).collect();
            match quoted.join(", ") {
                empty if empty.is_empty() => " ".to_owned(),
                text => format!(" {text} "),
            }
        };
        let groups = RUN_FILES.chunk_by(|_, next| next.holds.is_empty());
        let row = |forms: &[RunFile]| {
            let names = forms.iter().filter_map(|form| form.name).collect();
            let routes = forms.iter().filter_map(|form| form.route).collect();
            format!("|{}|{}| {} |\n", cell(names), cell(routes), forms[0].holds)
        };
        groups.map(row).collect()
    }

    #[test]
    fn the_readme_lists_every_file() {
        let readme = include_str!("../../../README.md");
        let rows = readme_rows();
        assert!(
            readme.contains(&format!("|---|---|---|\n{rows}\n")),
            "the README's table under \"What comes out\" has to be:\n{rows}"
        );
    }
}
