//! The ten claims, each with its tests.

use anyhow::Context;

use super::claim::{Claim, Level, Test, Verdict};
use crate::documents::{
    ArenaSource, BuiltinArenas, CHAPTER_5_METHODS, SHORT_PHASE_ARENA, SHORT_PHASE_METHOD,
    SHORT_PHASES,
};
use crate::reproduce::far_chamber::{DEPTH_M, far_chamber};
use crate::reproduce::plan::{Settings, short_phase_label};
use crate::reproduce::results::{Finding, Findings};
use crate::statistics::{Comparison, compare, sign_test};

/// Margin of equivalence of claim 7, as a share of the reachable squares.
const MARGIN: f64 = 0.05;
/// A curve rises abruptly if this share of its final p1 is there ...
const RISE: f64 = 0.5;
/// ... after this share of the epochs.
const RISE_WITHIN: f64 = 0.1;
/// It has reached a plateau if this share of its epochs at the end ...
const PLATEAU: f64 = 0.25;
/// ... adds less than this share of its final p1.
const PLATEAU_ADDS: f64 = 0.05;

/// The arenas of the thesis, easiest first.
const BY_DIFFICULTY: [&str; 3] = ["easy", "graph", "maze"];
const EV_ITER: [&str; 2] = ["ev-iter-c", "ev-iter-d"];

/// The claims with their tests, not yet corrected.
///
/// # Errors
/// The maze is not among the built-in arenas.
pub fn claims(
    settings: &Settings,
    findings: &Findings,
    radius_m: f64,
) -> anyhow::Result<Vec<Claim>> {
    let table = Table { settings, findings };
    let mut brownian = table.least("brownian");
    brownian.extend(table.far_chamber_is_not_reached("brownian", radius_m)?);
    let chamber_mm = 1_000.0 * DEPTH_M;
    let levels = "p1, p10, and p1 averaged over the epochs";
    let on_each_arena = format!("{levels}, on each arena.");
    Ok(vec![
        claim(
            1,
            "Random motion covers least on every arena, and in no run gets to the farthest \
             chamber of the maze",
            format!(
                "{levels}, against each other method on each arena; the runs that entered the chamber \
                 are counted. The chamber is the reachable squares of the maze whose shortest way \
                 from the start over reachable squares is within {chamber_mm:.1} mm (a cell of \
                 the maze) of the longest such way; one run in it contradicts."
            ),
            brownian,
        ),
        claim(
            2,
            "Ev-ITER-C and Ev-ITER-D beat intrinsic motivation alone, the more so the harder the \
             arena",
            format!(
                "{levels}, on each arena; then the lead at p1 of each seed's run over the im run of \
                 the same seed, as a share of the reachable squares, on the harder of two \
                 neighbouring arenas against the easier (easy, graph, maze)."
            ),
            [table.beat(&EV_ITER, &["im"]), table.leads_grow("im")].concat(),
        ),
        claim(
            3,
            "Ev-ITER-C and Ev-ITER-D beat the controllers evolved for curiosity and discovery on \
             every arena, on the one they were trained in too",
            on_each_arena.clone(),
            table.beat(&EV_ITER, &["curiosity", "discovery"]),
        ),
        claim(
            4,
            "Intrinsic motivation alone beats the controllers evolved for actuator entropy on \
             every arena",
            on_each_arena.clone(),
            table.beat(&["im"], &["curiosity-a", "discovery-a"]),
        ),
        claim(
            5,
            "Among evolved controllers entropy beats differential entropy",
            on_each_arena.clone(),
            table.beat(&["curiosity"], &["discovery"]),
        ),
        claim(
            6,
            "Among evolved controllers the entropy of actuator data beats that of sensori-motor \
             data",
            on_each_arena.clone(),
            [
                table.beat(&["curiosity-a"], &["curiosity"]),
                table.beat(&["discovery-a"], &["discovery"]),
            ]
            .concat(),
        ),
        claim(
            7,
            "For Ev-ITER it makes no difference which of the two kinds of data phase 1 uses",
            format!(
                "Equivalence: both one-sided tests on {levels} with one sample moved by {} % of the \
                 reachable squares, p the larger of the two. The opposite is a difference in \
                 either direction (twice the smaller p). No significant difference alone would \
                 not do: few runs never show one.",
                100.0 * MARGIN
            ),
            [
                table.equivalent("ev-iter-c", "ev-iter-ca"),
                table.equivalent("ev-iter-d", "ev-iter-da"),
            ]
            .concat(),
        ),
        claim(
            8,
            "Ev-ITER visits densely: its lead at p10 is no smaller than at p1",
            "A lead grows from p1 to p10 exactly if the squares lost between the two, p1 - p10, \
             are fewer than the rival's: that difference is compared, with im and with the \
             method's own phase-1 objective as rivals."
                .to_owned(),
            [
                table.loses_less("ev-iter-c", &["im", "curiosity"]),
                table.loses_less("ev-iter-d", &["im", "discovery"]),
            ]
            .concat(),
        ),
        claim(
            9,
            "Ev-ITER gets worse with less than 200 epochs of phase 1",
            format!("{levels}, of Ev-ITER-C on the maze, 200 epochs of phase 1 against 50 and 20."),
            table.longer_phase_is_better(),
        ),
        claim(
            10,
            "Coverage rises abruptly at first and then reaches a plateau",
            format!(
                "A run's curve rises abruptly if it has {} % of its final p1 after {} % of the \
                 epochs, and has reached a plateau if the last {} % of the epochs add less than \
                 {} % of it; sign test over the runs, against as likely as not. im, ev-iter-c and \
                 ev-iter-d, of which the thesis says it.",
                100.0 * RISE,
                100.0 * RISE_WITHIN,
                100.0 * PLATEAU,
                100.0 * PLATEAU_ADDS
            ),
            table.curves(&["im", "ev-iter-c", "ev-iter-d"]),
        ),
    ]
    .into_iter()
    .map(|claim| table.with_reason(claim))
    .collect())
}

fn claim(claim: u32, text: &'static str, how: String, tests: Vec<Test>) -> Claim {
    Claim {
        claim,
        text,
        how,
        verdict: Verdict::NotTested,
        verdict_p10: Verdict::NotTested,
        verdict_over_time: Verdict::NotTested,
        reason: None,
        tests,
    }
}

struct Table<'a> {
    settings: &'a Settings,
    findings: &'a Findings,
}

impl Table<'_> {
    /// Says which arenas a claim was not tested on.
    fn with_reason(&self, claim: Claim) -> Claim {
        let missing: Vec<&str> = BY_DIFFICULTY
            .into_iter()
            .filter(|name| !self.settings.arenas.iter().any(|arena| arena == name))
            .filter(|&name| claim.claim != 9 || name == SHORT_PHASE_ARENA)
            .collect();
        let reason = (!missing.is_empty())
            .then(|| format!("no runs on {} were asked for", missing.join(" and ")));
        Claim { reason, ..claim }
    }

    fn squares(&self, level: Level, arena: &str, method: &str) -> Vec<f64> {
        self.findings
            .values(arena, method, |run| level.squares(run))
    }

    fn arenas(&self) -> impl Iterator<Item = &str> {
        self.settings.arenas.iter().map(String::as_str)
    }

    /// A method against every other of the template, less expected at every level, on each arena.
    fn least(&self, method: &str) -> Vec<Test> {
        let others: Vec<&str> = CHAPTER_5_METHODS
            .into_iter()
            .filter(|&other| other != method)
            .collect();
        self.beat(&others, &[method])
    }

    /// Each of some methods against each of others, more expected at every level, on each arena.
    fn beat(&self, better: &[&str], worse: &[&str]) -> Vec<Test> {
        let mut tests = Vec::new();
        for level in Level::ALL {
            let name = level.name();
            for arena in self.arenas() {
                for one in better {
                    for other in worse {
                        let [x, y] = [one, other].map(|method| self.squares(level, arena, method));
                        let hypothesis = format!("{name} of {one} > {name} of {other}");
                        tests.push(Test {
                            level,
                            ..mann_whitney(arena, hypothesis, &x, &y, "squares")
                        });
                    }
                }
            }
        }
        tests
    }

    /// Leads over a rival on each arena against the next easier one.
    fn leads_grow(&self, rival: &str) -> Vec<Test> {
        let lead = |arena: &str, method: &str| -> Vec<f64> {
            let shares = |method| {
                self.findings
                    .values(arena, method, |run| run.result.fractions.p1)
            };
            let (own, rivals) = (shares(method), shares(rival));
            own.iter()
                .zip(rivals)
                .map(|(own, rival)| own - rival)
                .collect()
        };
        let given: Vec<&str> = BY_DIFFICULTY
            .into_iter()
            .filter(|name| self.settings.arenas.iter().any(|arena| arena == name))
            .collect();
        let mut tests = Vec::new();
        for pair in given.windows(2) {
            let (easier, harder) = (pair[0], pair[1]);
            for method in EV_ITER {
                let (x, y) = (lead(harder, method), lead(easier, method));
                let hypothesis =
                    format!("lead of {method} over {rival} on {harder} > lead on {easier}");
                let arenas = format!("{easier}, {harder}");
                tests.push(mann_whitney(
                    &arenas,
                    hypothesis,
                    &x,
                    &y,
                    "share of the reachable squares",
                ));
            }
        }
        tests
    }

    /// Two one-sided tests for a difference of less than the margin.
    fn equivalent(&self, one: &str, other: &str) -> Vec<Test> {
        let arenas = || self.arenas();
        let mut tests = Vec::new();
        for (level, arena) in Level::ALL
            .into_iter()
            .flat_map(|l| arenas().map(move |a| (l, a)))
        {
            let [x, y] = [one, other].map(|method| self.squares(level, arena, method));
            let name = level.name();
            let reachable = self
                .findings
                .of(arena, one)
                .next()
                .map_or(0.0, |run| f64::from(run.result.reachable));
            let margin = MARGIN * reachable;
            let moved = |by: f64| -> Vec<f64> { x.iter().map(|value| value + by).collect() };
            let not_less = compare(&moved(margin), &y).p_greater;
            let not_more = compare(&moved(-margin), &y).p_less;
            let plain = compare(&x, &y);
            let hypothesis =
                format!("{name} of {one} within {margin:.0} squares of {name} of {other}");
            tests.push(Test {
                level,
                test: "equivalence, two one-sided Mann-Whitney",
                p: Some(not_less.max(not_more)),
                p_opposite: Some((2.0 * plain.p_greater.min(plain.p_less)).min(1.0)),
                ..mann_whitney(arena, hypothesis, &x, &y, "squares")
            });
        }
        tests
    }

    /// Fewer squares lost between p1 and p10 than by each rival.
    fn loses_less(&self, method: &str, rivals: &[&str]) -> Vec<Test> {
        let lost = |run: &Finding| f64::from(run.result.p1) - f64::from(run.result.p10);
        let mut tests = Vec::new();
        for arena in self.arenas() {
            for rival in rivals {
                let x = self.findings.values(arena, rival, lost);
                let y = self.findings.values(arena, method, lost);
                let hypothesis = format!("p1 - p10 of {rival} > p1 - p10 of {method}");
                tests.push(mann_whitney(arena, hypothesis, &x, &y, "squares"));
            }
        }
        tests
    }

    fn longer_phase_is_better(&self) -> Vec<Test> {
        if !self.arenas().any(|arena| arena == SHORT_PHASE_ARENA) {
            return Vec::new();
        }
        let mut tests = Vec::new();
        for level in Level::ALL {
            let values = |method: &str| self.squares(level, SHORT_PHASE_ARENA, method);
            let (name, full) = (level.name(), values(SHORT_PHASE_METHOD));
            for epochs in SHORT_PHASES {
                let short = values(&short_phase_label(epochs));
                let hypothesis = format!(
                    "{name} of {SHORT_PHASE_METHOD} with 200 epochs of phase 1 > with {epochs}"
                );
                tests.push(Test {
                    level,
                    ..mann_whitney(SHORT_PHASE_ARENA, hypothesis, &full, &short, "squares")
                });
            }
        }
        tests
    }

    /// Runs of a method that entered the maze's farthest chamber: none expected.
    fn far_chamber_is_not_reached(
        &self,
        method: &str,
        radius_m: f64,
    ) -> anyhow::Result<Option<Test>> {
        if !self.arenas().any(|arena| arena == "maze") {
            return Ok(None);
        }
        let maze = BuiltinArenas
            .arena("maze")
            .context("there is no arena maze")?;
        let chamber = far_chamber(&maze, radius_m);
        let size = chamber.iter().filter(|&&far| far).count();
        let entered = |run: &Finding| {
            run.visits
                .iter()
                .zip(&chamber)
                .any(|(&visits, &far)| far && visits > 0)
        };
        let runs = self.findings.of("maze", method).count();
        let number = self
            .findings
            .of("maze", method)
            .filter(|run| entered(run))
            .count();
        Ok(Some(Test {
            arena: "maze".to_owned(),
            hypothesis: format!("no run of {method} enters the farthest chamber ({size} squares)"),
            level: Level::P1,
            test: "count",
            n: vec![runs],
            statistic: number as f64,
            p: None,
            p_holm: None,
            p_opposite_holm: None,
            p_opposite: None,
            effect_size: "share of runs",
            effect: number as f64 / runs.max(1) as f64,
            median_difference: None,
            unit: None,
            verdict: if number == 0 {
                Verdict::Reproduced
            } else {
                Verdict::Contradicted
            },
        }))
    }

    /// Abrupt rise and plateau, for each method on each arena.
    fn curves(&self, methods: &[&str]) -> Vec<Test> {
        let mut tests = Vec::new();
        for arena in self.arenas() {
            for method in methods {
                let count = |meets: fn(&[f64]) -> bool| {
                    let runs = self.findings.of(arena, method);
                    runs.filter(|run| meets(&run.p1_by_epoch)).count()
                };
                let runs = self.findings.of(arena, method).count();
                let rise = format!("curves of {method} rise abruptly");
                tests.push(sign(arena, rise, count(rises), runs));
                let plateau = format!("curves of {method} reach a plateau");
                tests.push(sign(arena, plateau, count(flattens), runs));
            }
        }
        tests
    }
}

/// p1 after a share of the epochs, at least one; 0 without epochs.
fn after(curve: &[f64], share: f64) -> f64 {
    let epoch = ((share * curve.len() as f64).round() as usize).max(1);
    curve.get(epoch - 1).copied().unwrap_or(0.0)
}

fn rises(curve: &[f64]) -> bool {
    after(curve, RISE_WITHIN) >= RISE * after(curve, 1.0)
}

fn flattens(curve: &[f64]) -> bool {
    let last = after(curve, 1.0);
    last - after(curve, 1.0 - PLATEAU) < PLATEAU_ADDS * last
}

/// A one-sided test for larger values in `x`.
fn mann_whitney(arena: &str, hypothesis: String, x: &[f64], y: &[f64], unit: &'static str) -> Test {
    let Comparison {
        u,
        p_greater,
        p_less,
        a,
        median_difference,
    } = compare(x, y);
    Test {
        arena: arena.to_owned(),
        hypothesis,
        level: Level::P1,
        test: "Mann-Whitney, one-sided",
        n: vec![x.len(), y.len()],
        statistic: u,
        p: Some(p_greater),
        p_holm: None,
        p_opposite_holm: None,
        p_opposite: Some(p_less),
        effect_size: "Vargha-Delaney A",
        effect: a,
        median_difference: Some(median_difference),
        unit: Some(unit),
        verdict: Verdict::Inconclusive,
    }
}

/// A one-sided sign test for a condition that most runs meet.
fn sign(arena: &str, hypothesis: String, meeting: usize, runs: usize) -> Test {
    Test {
        arena: arena.to_owned(),
        hypothesis,
        level: Level::P1,
        test: "sign test, one-sided",
        n: vec![runs],
        statistic: meeting as f64,
        p: Some(sign_test(meeting as u64, runs as u64)),
        p_holm: None,
        p_opposite_holm: None,
        p_opposite: Some(sign_test((runs - meeting) as u64, runs as u64)),
        effect_size: "share of runs",
        effect: meeting as f64 / runs.max(1) as f64,
        median_difference: None,
        unit: None,
        verdict: Verdict::Inconclusive,
    }
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
