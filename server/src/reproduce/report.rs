//! The report: four texts, a function of the runs' results alone.

use std::io::Write;
use std::path::Path;

use anyhow::Context;
use arenas::Arena;

use super::claims::{self, Claims};
use super::document::{self, Block};
use super::maps::{self, Counted};
use super::plan::Plan;
use super::results::{Finding, Findings};
use super::{curves, engines, sections};
use crate::documents::{ArenaSource, BuiltinArenas};
use crate::store::Store;

/// The report on a plan's runs. Equal results give equal bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    /// One line a run.
    pub runs_csv: String,
    /// The claims with their tests.
    pub claims_json: String,
    /// Tables in Markdown.
    pub markdown: String,
    /// All of it with pictures, one page that needs no other file.
    pub html: String,
    /// A line for each claim.
    pub verdicts: Vec<String>,
}

impl Report {
    /// Reads every run of the plan from the store and judges them.
    ///
    /// # Errors
    /// A run that is missing or cannot be read.
    pub fn new(plan: &Plan, store: &Store) -> anyhow::Result<Self> {
        let findings = Findings::read(plan, store)?;
        let radius_m = plan
            .runs
            .first()
            .context("there are no runs")?
            .spec
            .body_radius_m();
        let claims = claims::judge(&plan.settings, &findings, radius_m)?;
        let blocks = blocks(plan, &findings, &claims, radius_m)?;
        let mut claims_json = serde_json::to_string_pretty(&claims)?;
        claims_json.push('\n');
        Ok(Self {
            runs_csv: findings.csv(),
            claims_json,
            markdown: document::markdown(&blocks),
            html: document::html(&blocks),
            verdicts: claims.claims.iter().map(verdict).collect(),
        })
    }

    /// Writes `runs.csv`, `claims.json`, `report.md` and `report.html` into a directory, each as a
    /// whole.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, out: &Path) -> anyhow::Result<()> {
        for (name, text) in [
            ("runs.csv", &self.runs_csv),
            ("claims.json", &self.claims_json),
            ("report.md", &self.markdown),
            ("report.html", &self.html),
        ] {
            replace(&out.join(name), text.as_bytes())?;
        }
        Ok(())
    }
}

fn verdict(claim: &claims::Claim) -> String {
    let at = |level: &str, verdict: claims::Verdict| match verdict {
        claims::Verdict::NotTested => String::new(),
        verdict => format!("{level} {}", verdict.name()),
    };
    let at_p10 = at("p10", claim.verdict_p10);
    let over_time = at("over time", claim.verdict_over_time);
    format!(
        "claim {:>2}: {:<12} {at_p10:<16} {over_time:<22} {}",
        claim.claim,
        claim.verdict.name(),
        claim.text
    )
}

/// Writes a file as a whole or not at all.
///
/// # Errors
/// It cannot be written; the one before stays.
pub fn replace(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    let parent = path.parent().unwrap_or(Path::new("."));
    let write = || -> std::io::Result<()> {
        let mut file = tempfile::Builder::new();
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            file.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut file = file.tempfile_in(parent)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        Ok(())
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

fn blocks(
    plan: &Plan,
    findings: &Findings,
    claims: &Claims,
    radius_m: f64,
) -> anyhow::Result<Vec<Block>> {
    let mut blocks = sections::opening(plan, claims);
    blocks.extend(sections::verdicts(claims));
    blocks.extend(sections::coverage(plan, findings));
    blocks.push(Block::Heading(2, "Curves and maps".to_owned()));
    for name in &plan.settings.arenas {
        let arena = BuiltinArenas
            .arena(name)
            .with_context(|| format!("there is no arena {name}"))?;
        blocks.push(curves_of(plan, findings, name));
        blocks.extend(maps_of(plan, findings, &arena, radius_m));
    }
    blocks.extend(sections::time_to_coverage(plan, findings));
    blocks.extend(sections::model_accuracy(plan, findings));
    blocks.extend(engines::section(&plan.settings, findings, &claims.engines));
    blocks.extend(sections::test_tables(claims));
    blocks.extend(sections::settings(plan));
    Ok(blocks)
}

fn curves_of(plan: &Plan, findings: &Findings, arena: &str) -> Block {
    let line = |method: &str| curves::Line {
        method: method.to_owned(),
        curves: findings
            .of(arena, method)
            .map(|run| run.p1_by_epoch.clone())
            .collect(),
    };
    let lines: Vec<curves::Line> = methods_on(plan, findings, arena).map(line).collect();
    Block::Figure {
        svg: curves::svg(&lines),
        caption: format!(
            "p1 by epoch on {arena}: mean over the runs and pointwise 95 % bootstrap band of the \
             mean ({} draws of whole runs).",
            crate::statistics::bootstrap::RESAMPLES
        ),
    }
}

/// Maps of all runs, and of one run of each method.
fn maps_of(plan: &Plan, findings: &Findings, arena: &Arena, radius_m: f64) -> [Block; 2] {
    let name = arena.name();
    let reachable = arena.starts().first().map_or_else(Vec::new, |start| {
        arenas::reachable(arena, *start, radius_m).mask
    });
    let all = |method: &str| {
        let runs: Vec<&Finding> = findings.of(name, method).collect();
        let entered = |square| runs.iter().filter(|run| run.visits[square] > 0).count() as u32;
        maps::Map {
            title: method.to_owned(),
            entered: (0..reachable.len()).map(entered).collect(),
        }
    };
    let one = |method: &str| {
        let run = median_run(findings.of(name, method))?;
        Some(maps::Map {
            title: format!("{method}, seed {}", run.seed),
            entered: run.visits.clone(),
        })
    };
    let figure = |maps: &[maps::Map], counted, caption| Block::Figure {
        svg: maps::svg(arena, &reachable, maps, counted),
        caption,
    };
    let all: Vec<maps::Map> = methods_on(plan, findings, name).map(all).collect();
    let one: Vec<maps::Map> = methods_on(plan, findings, name).filter_map(one).collect();
    [
        figure(
            &all,
            Counted::Runs(plan.settings.seeds),
            format!("Squares of {name} entered over all runs, by the number of runs."),
        ),
        figure(
            &one,
            Counted::Entries,
            format!(
                "Squares of {name} entered in one run of each method, that of median p1 (the \
                 lower of two), by the number of entries."
            ),
        ),
    ]
}

/// The run in the middle by p1, the lower of two, the smaller seed on ties.
fn median_run<'a>(runs: impl Iterator<Item = &'a Finding>) -> Option<&'a Finding> {
    let mut runs: Vec<&Finding> = runs.collect();
    runs.sort_by_key(|run| (run.result.p1, run.seed));
    runs.get(runs.len().saturating_sub(1) / 2).copied()
}

/// Methods that have runs on an arena.
fn methods_on<'a>(
    plan: &'a Plan,
    findings: &'a Findings,
    arena: &'a str,
) -> impl Iterator<Item = &'a str> {
    plan.methods()
        .into_iter()
        .filter(move |method| findings.of(arena, method).next().is_some())
}
