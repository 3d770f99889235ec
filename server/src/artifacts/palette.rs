//! Colours of a coverage picture: four steps of viridis, so that print in grey and every kind of
//! colour blindness keep the order.

/// Red, green, blue.
pub type Colour = [u8; 3];

pub const WHITE: Colour = [255, 255, 255];
pub const BLACK: Colour = [0, 0, 0];
/// Text that is not in the first line of sight.
pub const GREY: Colour = [90, 90, 90];
/// Ground and lines of squares that cannot be reached.
pub const UNREACHABLE: Colour = [232, 232, 232];
pub const HATCH: Colour = [178, 178, 178];
/// Start poses: the vermilion of Okabe and Ito.
pub const START: Colour = [213, 94, 0];
/// Movable objects: where they are, and where they began.
pub const OBJECT: Colour = [176, 0, 132];
pub const OBJECT_START: Colour = [232, 150, 210];

/// A class of squares by their visits.
pub struct Step {
    /// Fewest visits.
    pub from: u32,
    /// In the legend.
    pub label: &'static str,
    /// Fill.
    pub colour: Colour,
}

/// The classes, fewest visits first: the thresholds of p1, p2, p5 and p10.
pub const STEPS: [Step; 4] = [
    Step {
        from: 1,
        label: "1 visit",
        colour: [0x47, 0x2c, 0x7a],
    },
    Step {
        from: 2,
        label: "2 to 4",
        colour: [0x2a, 0x78, 0x8e],
    },
    Step {
        from: 5,
        label: "5 to 9",
        colour: [0x43, 0xbf, 0x71],
    },
    Step {
        from: 10,
        label: "10 or more",
        colour: [0xfd, 0xe7, 0x25],
    },
];

/// The class of a square; `None` where it was never entered.
pub fn step(visits: u32) -> Option<usize> {
    STEPS.iter().rposition(|step| visits >= step.from)
}
