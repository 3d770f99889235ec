//! Counts of squares as shares of those within reach.

use api::Fractions;

use super::palette::STEPS;

/// Counts inside the reachable squares as shares of these.
pub fn fractions(inside: [u32; STEPS.len()], reachable: u32) -> Fractions {
    let [p1, p2, p5, p10] = inside.map(|count| match reachable {
        0 => 0.0,
        _ => f64::from(count) / f64::from(reachable),
    });
    Fractions { p1, p2, p5, p10 }
}
