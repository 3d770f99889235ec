//! Comparisons in sentences.

use api::comparison::{Better, ComparedGroup, ComparedPair};

use super::super::table::short;
use crate::statistics::MOST_RUNS;

/// Which group is best.
pub struct Verdict {
    pub best: Option<usize>,
    pub sentence: String,
    pub runs_needed: Option<u64>,
}

/// How a measure is spoken of.
struct Speech {
    /// What the first of two does where its measure is higher, and where it is lower.
    higher: &'static str,
    lower: &'static str,
    /// Of differences.
    unit: &'static str,
    /// From the measure to its unit.
    factor: f64,
}

fn speech(measure: &str) -> Speech {
    let (higher, lower) = match measure {
        _ if measure.ends_with("_steps") => ("takes longer than", "is faster than"),
        "p1" | "p1_fraction" | "mean_coverage" => ("covers more than", "covers less than"),
        "collisions_per_robot_step" => ("collides more than", "collides less than"),
        "cpu_ns_per_robot_step" => ("costs more than", "costs less than"),
        "distance_m" => ("drives farther than", "drives less far than"),
        _ => ("has more than", "has less than"),
    };
    let (unit, factor) = match measure {
        _ if measure.ends_with("_fraction") => (" % of what can be reached", 100.0),
        "mean_coverage" => (" % of what can be reached, on average over time", 100.0),
        "p1" | "p2" | "p5" | "p10" => (" squares", 1.0),
        "distance_m" => (" m", 1.0),
        "cpu_ns_per_robot_step" => (" ns", 1.0),
        _ if measure.ends_with("_steps") => (" steps", 1.0),
        _ => ("", 1.0),
    };
    Speech {
        higher,
        lower,
        unit,
        factor,
    }
}

/// Names groups without a label.
fn named(label: &str) -> &str {
    if label.is_empty() {
        "the only group"
    } else {
        label
    }
}

/// A pair in one sentence; where the two differ the better one (or the higher) comes first.
pub fn of_pair(pair: &ComparedPair, labels: [&str; 2], measure: &str) -> String {
    let speech = speech(measure);
    // Where all that is known is who got there first, it is the chance to be better that speaks.
    let first_higher = pair.difference.map_or_else(
        || pair.improvement.is_some_and(|share| share < 0.5) == measure.ends_with("_steps"),
        |difference| difference > 0.0,
    );
    let low_is_good = measure.ends_with("_steps");
    let turn = pair.differs && first_higher == low_is_good;
    let [one, other] = if turn { [labels[1], labels[0]] } else { labels };
    let figures = figures(pair, &speech, if turn { -1.0 } else { 1.0 });
    if pair.differs {
        let verb = if first_higher != turn {
            speech.higher
        } else {
            speech.lower
        };
        let of = if verb.starts_with("has") {
            format!(" ({measure})")
        } else {
            String::new()
        };
        format!("{} {verb} {}{of}: {figures}", named(one), named(other))
    } else {
        let would = would_say(pair.runs_needed, pair.n);
        format!(
            "{} against {}: cannot be said yet: {figures}; {would}",
            named(one),
            named(other)
        )
    }
}

fn figures(pair: &ComparedPair, speech: &Speech, sign: f64) -> String {
    let scaled = |value: f64| short(Some(value * sign * speech.factor), 2);
    let mut text = match pair.difference {
        Some(difference) => {
            let plus = if difference * sign > 0.0 { "+" } else { "" };
            format!("{plus}{}{}", scaled(difference), speech.unit)
        }
        None => "no difference to measure".to_owned(),
    };
    if let Some(interval) = &pair.interval {
        let (low, high) = (scaled(interval.low), scaled(interval.high));
        let (low, high) = if sign < 0.0 { (high, low) } else { (low, high) };
        text.push_str(&format!(" [{low}, {high}]"));
    }
    let what = if pair.paired { "pairs" } else { "runs of each" };
    text.push_str(&format!(", n = {} {what}", pair.n));
    if pair.missed > 0 {
        text.push_str(&format!(
            " ({} with a run that never got there)",
            pair.missed
        ));
    }
    if let Some(p) = pair.p_holm {
        text.push_str(&match p {
            p if p < 0.001 => ", p < 0.001".to_owned(),
            p => format!(", p = {}", short(Some(p), 2)),
        });
    }
    text
}

/// How many runs would do, in words.
fn would_say(needed: Option<u64>, n: u64) -> String {
    match needed {
        // What was seen should have been found: with a few more it will be.
        Some(needed) => format!("about {} seeds would", rounded(needed.max(n + 1))),
        None if n < 2 => "at least 2 seeds of both are needed".to_owned(),
        None => format!("more than {MOST_RUNS} seeds would be needed"),
    }
}

/// Up to what sounds as uncertain as it is.
pub fn rounded(runs: u64) -> u64 {
    let step = match runs {
        0..=20 => 1,
        21..=50 => 5,
        _ => 10,
    };
    runs.div_ceil(step) * step
}

/// The best group is the one that differs from every other for the better.
pub fn verdict(
    groups: &[ComparedGroup],
    pairs: &[ComparedPair],
    measure: &str,
    better: Option<Better>,
) -> Verdict {
    let silent = |sentence: &str| Verdict {
        best: None,
        sentence: sentence.to_owned(),
        runs_needed: None,
    };
    if groups.len() < 2 {
        return silent("there is one group: nothing to compare");
    }
    let sign = if better == Some(Better::Lower) {
        -1.0
    } else {
        1.0
    };
    let word = match better {
        Some(_) => "best",
        None => "highest",
    };
    let standing = |place: usize| groups[place].mean.map(|mean| sign * mean);
    let ranked = (0..groups.len()).filter_map(|place| Some((place, standing(place)?)));
    // Of equal means the first.
    let leader = ranked.reduce(|best, next| if next.1 > best.1 { next } else { best });
    let Some((leader, _)) = leader else {
        return silent("cannot be said yet: no run has the measure");
    };
    let name = named(&groups[leader].label);
    let rivals = pairs
        .iter()
        .filter(|pair| [pair.first, pair.second].contains(&leader));
    let (beaten, open): (Vec<_>, Vec<_>) = rivals.partition(|pair| {
        // The chance to be better counts runs that never got there, which no mean does.
        let ahead = pair
            .improvement
            .is_some_and(|share| (share > 0.5) == (pair.first == leader));
        pair.differs && ahead
    });
    if open.is_empty() {
        let p = beaten
            .iter()
            .filter_map(|pair| pair.p_holm)
            .fold(0.0, f64::max);
        let than = match &beaten[..] {
            [only] => {
                return Verdict {
                    best: Some(leader),
                    sentence: format!("{name} is {word}: {}", only.sentence),
                    runs_needed: None,
                };
            }
            all => format!("each of the other {}", all.len()),
        };
        return Verdict {
            best: Some(leader),
            sentence: format!(
                "{name} is {word} by {measure}: it differs from {than} (p at most {})",
                short(Some(p.max(0.001)), 2)
            ),
            runs_needed: None,
        };
    }
    let rival = |pair: &&ComparedPair| {
        let place = if pair.first == leader {
            pair.second
        } else {
            pair.first
        };
        named(&groups[place].label).to_owned()
    };
    let names: Vec<String> = open.iter().map(rival).collect();
    let level: Vec<&str> = (0..groups.len())
        .filter(|place| standing(*place) == standing(leader))
        .map(|place| named(&groups[place].label))
        .collect();
    let ahead = match &level[..] {
        [] | [_] => format!("{name} leads, but is not told from {}", names.join(", ")),
        [first @ .., last] => format!("{} and {last} have the same mean", first.join(", ")),
    };
    let n = open.iter().map(|pair| pair.n).min().unwrap_or(0);
    let needed: Option<Vec<u64>> = open.iter().map(|pair| pair.runs_needed).collect();
    let needed = needed.and_then(|needed| needed.into_iter().max());
    Verdict {
        best: None,
        sentence: format!(
            "which is {word} by {measure} cannot be said yet: {ahead}; {}",
            would_say(needed, n)
        ),
        runs_needed: needed.map(|needed| rounded(needed.max(n + 1))),
    }
}
