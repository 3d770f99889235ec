//! The objectives of phase 1: entropy of a trajectory (eq. 4.5) and what it adds to the archive's
//! (eq. 4.6), natural logarithm, from the visit counts of an epsilon-clustering.

/// `q log q`, 0 for `q` = 0.
fn q_log_q(q: f64) -> f64 {
    if q > 0.0 { q * libm::log(q) } else { 0.0 }
}

/// Curiosity (eq. 4.5): the entropy of the trajectory over its clusters, in nats.
///
/// `trajectory` holds the visits of each cluster. An empty trajectory has entropy 0.
pub fn curiosity(trajectory: &[u32]) -> f64 {
    let steps: u64 = trajectory.iter().map(|visits| u64::from(*visits)).sum();
    let steps = steps as f64;
    -trajectory
        .iter()
        .filter(|visits| **visits > 0)
        .map(|visits| q_log_q(f64::from(*visits) / steps))
        .sum::<f64>()
}

/// Discovery (eq. 4.6): entropy of archive and trajectory together less that of the archive.
///
/// `archive` holds the visits of each cluster in all earlier trajectories, in the order of
/// `trajectory`. While it is all zeros the second term is 0 and discovery equals curiosity.
pub fn discovery(trajectory: &[u32], archive: &[u64]) -> f64 {
    let before: u64 = archive.iter().sum();
    let steps: u64 = trajectory.iter().map(|visits| u64::from(*visits)).sum();
    let after = (before + steps) as f64;
    let before = before as f64;
    let mut sum = 0.0;
    for (visits, archived) in trajectory.iter().zip(archive) {
        if u64::from(*visits) + archived > 0 {
            sum += q_log_q((archived + u64::from(*visits)) as f64 / after);
        }
        if *archived > 0 {
            sum -= q_log_q(*archived as f64 / before);
        }
    }
    -sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entropy(counts: &[f64]) -> f64 {
        let total: f64 = counts.iter().sum();
        counts
            .iter()
            .filter(|c| **c > 0.0)
            .map(|c| -(c / total) * (c / total).ln())
            .sum()
    }

    #[test]
    fn curiosity_is_the_entropy() {
        assert_eq!(curiosity(&[]), 0.0);
        assert_eq!(curiosity(&[0, 0]), 0.0);
        assert_eq!(curiosity(&[0, 7]), 0.0);
        assert!((curiosity(&[5; 8]) - 8_f64.ln()).abs() < 1e-14);
        assert!((curiosity(&[1, 0, 3]) - entropy(&[1.0, 0.0, 3.0])).abs() < 1e-15);
    }

    #[test]
    fn discovery_is_a_difference_of_entropies() {
        assert_eq!(discovery(&[2, 3], &[0, 0]), curiosity(&[2, 3]));
        assert_eq!(discovery(&[0, 0], &[0, 0]), 0.0);
        let got = discovery(&[3, 0, 9, 1], &[40, 2, 0, 8]);
        let want = entropy(&[43.0, 2.0, 9.0, 9.0]) - entropy(&[40.0, 2.0, 0.0, 8.0]);
        assert!((got - want).abs() < 1e-14);
    }

    #[test]
    fn discovery_rewards_what_was_rarely_visited() {
        let archive = [1_000, 10, 0];
        assert!(discovery(&[0, 100, 0], &archive) > discovery(&[100, 0, 0], &archive));
        assert!(discovery(&[0, 50, 50], &archive) > discovery(&[0, 100, 0], &archive));
    }
}
