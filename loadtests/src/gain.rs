//! How much faster a case is on several threads, for the table and for the picture.

/// What a case gained.
pub struct Gain {
    /// The case.
    pub name: String,
    /// Threads, least and median wall nanoseconds a robot-step, median of the rounds' speed-ups.
    pub points: Vec<Point>,
}

/// A case on some threads.
pub struct Point {
    /// How many.
    pub threads: usize,
    /// Least wall time of all chunks.
    pub min_ns: f64,
    /// Median wall time of all chunks.
    pub median_ns: f64,
}
