//! Comparison with earlier figures: what changed by more than the noise.

use crate::measure::Figure;

/// Lines for every case that is in both sets. A change counts when the medians differ by more than
/// the larger spread (median to least chunk) of the two, and by at least 3 %.
pub fn lines(base: &[Figure], now: &[Figure]) -> Vec<String> {
    let mut lines = Vec::new();
    for new in now {
        let Some(old) = base.iter().find(|old| old.name == new.name) else {
            lines.push(format!("{:<34} new", new.name));
            continue;
        };
        let ratio = new.median_ns / old.median_ns;
        let spread = |f: &Figure| f.median_ns - f.min_ns;
        let noise = spread(old).max(spread(new)).max(0.03 * old.median_ns);
        let verdict = if (new.median_ns - old.median_ns).abs() <= noise {
            "within noise"
        } else if ratio < 1.0 {
            "faster"
        } else {
            "SLOWER"
        };
        lines.push(format!(
            "{:<34} {:>9.1} -> {:>9.1} ns  x {:.3}  {verdict}",
            new.name, old.median_ns, new.median_ns, ratio
        ));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(median_ns: f64, min_ns: f64) -> Vec<Figure> {
        vec![Figure {
            name: "case".into(),
            min_ns,
            median_ns,
            p90_ns: median_ns,
            bytes_per_robot: None,
            peak_bytes: None,
            goal_us: None,
            stretch_us: None,
        }]
    }

    #[test]
    fn only_changes_beyond_the_noise_count() {
        let verdict = |old: (f64, f64), new: (f64, f64)| {
            lines(&figure(old.0, old.1), &figure(new.0, new.1))[0].clone()
        };
        assert!(verdict((100.0, 95.0), (104.0, 99.0)).ends_with("within noise"));
        assert!(verdict((100.0, 95.0), (120.0, 118.0)).ends_with("SLOWER"));
        assert!(verdict((100.0, 95.0), (80.0, 78.0)).ends_with("faster"));
        assert!(verdict((100.0, 70.0), (120.0, 118.0)).ends_with("within noise"));
    }
}
