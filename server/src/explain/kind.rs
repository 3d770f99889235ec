//! What a robot that stays where it is may be doing.

/// A way of staying.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Told to stand.
    Resting,
    /// Told to move, and does neither that nor turn: something is in the way.
    Wedged,
    /// Turns on the spot.
    Spinning,
    /// Stands, for none of these reasons.
    Standing,
    /// Moves within a small place, most of the time close to a wall.
    WallDancing,
    /// Moves within a small place, in the open.
    Circling,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Resting,
        Self::Wedged,
        Self::Spinning,
        Self::Standing,
        Self::WallDancing,
        Self::Circling,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Resting => "resting",
            Self::Wedged => "wedged",
            Self::Spinning => "spinning",
            Self::Standing => "standing",
            Self::WallDancing => "wall dancing",
            Self::Circling => "circling",
        }
    }

    /// As a part of a sentence.
    pub const fn doing(self) -> &'static str {
        match self {
            Self::Resting => "told to stand still",
            Self::Wedged => "told to move but held by what it touches",
            Self::Spinning => "turning on the spot",
            Self::Standing => "hardly moving",
            Self::WallDancing => "dancing along a wall",
            Self::Circling => "circling in the open",
        }
    }
}
