//! Wheel commands rounded to a few levels, where a spec asks for it (`command_levels`).

use crate::dimensions::WHEELS;

/// Levels evenly from -1 to 1; by default none, and commands stay as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CommandLevels(u16);

impl CommandLevels {
    /// So many levels, of at most 65,535; none for fewer than two.
    pub fn new(levels: u32) -> Self {
        Self(if levels < 2 {
            0
        } else {
            levels.min(65_535) as u16
        })
    }

    /// A command, each wheel at its nearest level.
    #[inline(always)]
    pub fn round(self, command: [f32; WHEELS]) -> [f32; WHEELS] {
        if self.0 == 0 {
            return command;
        }
        // Adding 1.5 * 2^23 leaves no fraction bits: rounds to nearest even on every machine.
        const ROUND: f32 = 12_582_912.0;
        let per_unit = 0.5 * (f32::from(self.0) - 1.0);
        command.map(|wheel| {
            let level = ((wheel + 1.0) * per_unit + ROUND) - ROUND;
            (level / per_unit - 1.0).clamp(-1.0, 1.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_go_to_the_nearest_level() {
        let three = CommandLevels::new(3);
        assert_eq!(three.round([-1.0, -0.51]), [-1.0, -1.0]);
        assert_eq!(three.round([-0.49, 0.49]), [0.0, 0.0]);
        assert_eq!(three.round([0.51, 1.0]), [1.0, 1.0]);
        assert_eq!(CommandLevels::new(2).round([-0.1, 0.1]), [-1.0, 1.0]);
        assert_eq!(CommandLevels::new(5).round([0.3, -0.6]), [0.5, -0.5]);
        for none in [0, 1] {
            assert_eq!(CommandLevels::new(none).round([0.123, -0.7]), [0.123, -0.7]);
        }
    }
}
