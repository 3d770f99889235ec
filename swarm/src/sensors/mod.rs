//! What robots sense.

pub mod noise;
pub mod proximity;
