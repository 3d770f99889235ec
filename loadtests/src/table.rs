//! The table of figures against goals, and of cost and memory against robots.

use crate::measure::Figure;

/// The figures as lines of text.
pub fn lines(figures: &[Figure]) -> Vec<String> {
    let mut lines = vec![format!(
        "{:<34} {:>9} {:>9} {:>9} {:>7} {:>8}  {:<9} {:>12}",
        "case", "median ns", "min ns", "p90 ns", "goal", "stretch", "verdict", "bytes/robot"
    )];
    for f in figures {
        let goal = |us: Option<f64>| us.map_or_else(|| "-".into(), |us| format!("{:.0}", us * 1e3));
        let verdict = match (f.goal_us, f.stretch_us) {
            (_, Some(stretch)) if f.median_ns <= stretch * 1e3 => "stretch",
            (Some(goal), _) if f.median_ns <= goal * 1e3 => "goal",
            (Some(_), _) => "missed",
            _ => "",
        };
        let bytes = f
            .bytes_per_robot
            .map_or_else(String::new, |bytes| bytes.to_string());
        lines.push(format!(
            "{:<34} {:>9.1} {:>9.1} {:>9.1} {:>7} {:>8}  {:<9} {:>12}",
            f.name,
            f.median_ns,
            f.min_ns,
            f.p90_ns,
            goal(f.goal_us),
            goal(f.stretch_us),
            verdict,
            bytes
        ));
    }
    lines
}

/// Most that a robot-step may cost among 100,000 robots, against among 10.
const FLAT_GOAL: f64 = 1.25;
const FLAT_STRETCH: f64 = 1.1;

/// Kinds of cases that are measured at several numbers of robots: prefix, suffix, heading.
pub const SCALING: [(&str, &str, &str); 3] = [
    ("kinematic/swarm/", "/brownian", "kinematic, brownian"),
    ("kinematic/swarm/", "/im", "kinematic, im"),
    ("rapier/swarm/", "/brownian", "rapier, brownian"),
];

/// Robots of a case of a kind, from its name `prefix/ROBOTS/suffix`.
pub fn robots_of(name: &str, prefix: &str, suffix: &str) -> Option<u64> {
    let number = name.strip_prefix(prefix)?.strip_suffix(suffix)?;
    number.parse().ok()
}

/// Cost and peak memory against robots: a line a number of robots, a column a kind.
pub fn scaling(figures: &[Figure]) -> Vec<String> {
    let mut header = format!("{:>8}", "robots");
    for (.., heading) in SCALING {
        header += &format!("  {:>24}", format!("{heading}: ns, MB"));
    }
    let mut lines = vec![header];
    for robots in [1, 10, 100, 1_000, 10_000, 100_000] {
        let mut line = format!("{robots:>8}");
        for (prefix, suffix, _) in SCALING {
            let of_kind =
                |f: &&Figure| robots_of(&f.name, prefix, suffix).is_some_and(|n| n == robots);
            let cell = figures.iter().find(of_kind).map_or_else(String::new, |f| {
                let peak = f
                    .peak_bytes
                    .map_or_else(|| "-".into(), |bytes| format!("{:.1}", bytes as f64 / 1e6));
                format!("{:.0}, {peak:>6}", f.median_ns)
            });
            line += &format!("  {cell:>24}");
        }
        lines.push(line);
    }
    lines.extend(flatness(figures));
    lines
}

/// How much more a robot-step costs among 100,000 robots than among 10, and the verdict.
fn flatness(figures: &[Figure]) -> Option<String> {
    let of = |robots: u64| {
        let name = format!("kinematic/swarm/{robots}/brownian");
        figures.iter().find(|f| f.name == name)
    };
    let ratio = of(100_000)?.median_ns / of(10)?.median_ns;
    let verdict = match ratio {
        ratio if ratio <= FLAT_STRETCH => "stretch",
        ratio if ratio <= FLAT_GOAL => "goal",
        _ => "missed",
    };
    Some(format!(
        "kinematic, brownian, 100,000 against 10 robots: {ratio:.2} x (goal {FLAT_GOAL}, stretch {FLAT_STRETCH}): {verdict}"
    ))
}
