//! A common sample of what all robots saw, from which their common codebook is made.

use crate::controllers::Watch;
use crate::dimensions::SENSORI_MOTOR;

/// What k-means needs for a codebook.
pub struct Pooled {
    /// Sensori-motor vectors.
    pub vectors: Vec<[f32; SENSORI_MOTOR]>,
    /// Numbers of states and of actions.
    pub clusters: (u32, u32),
}

/// At most `cap` vectors, as nearly as possible the same number of each robot, evenly spaced in its
/// sample; as many clusters as the robot that found the most.
pub fn pool(watches: &[&Watch], cap: u32) -> Pooled {
    let robots = watches.len().max(1);
    let cap = cap as usize;
    let mut vectors = Vec::with_capacity(cap);
    for (robot, watch) in watches.iter().enumerate() {
        let sample = watch.sample.sample();
        // The first robots take one more where the cap is no multiple of their number.
        let share = cap / robots + usize::from(robot < cap % robots);
        let share = share.min(sample.len());
        vectors.extend((0..share).map(|n| sample[n * sample.len() / share]));
    }
    let most = |count: fn(&Watch) -> u32| watches.iter().map(|w| count(w)).max().unwrap_or(0);
    Pooled {
        vectors,
        clusters: (most(|w| w.sensors.len()), most(|w| w.actuators.len())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caps::MemoryPlan;
    use crate::random::Stream;
    use crate::spec::ControllerParameters;

    #[test]
    fn takes_the_same_share_of_each_robot() {
        let p = ControllerParameters::default();
        let watches: Vec<Watch> = (0..3)
            .map(|robot| {
                let mut watch = Watch::new(&p, &MemoryPlan::small(), Stream::new(robot));
                for n in 0..20 {
                    let mark = [robot as f32, n as f32];
                    watch.observe(&[n as f32; 8], mark);
                }
                watch
            })
            .collect();
        let watches: Vec<&Watch> = watches.iter().collect();
        let count = |cap| {
            let pooled = pool(&watches, cap);
            [0.0, 1.0, 2.0].map(|robot| pooled.vectors.iter().filter(|v| v[8] == robot).count())
        };
        assert_eq!(count(20), [7, 7, 6]);
        assert_eq!(count(2), [1, 1, 0]);
        assert_eq!(count(1_000), [20, 20, 20]);
        assert_eq!(pool(&watches, 20).clusters.0, 9);
    }
}
