//! How robots share what they learn.
//!
//! Tables can be shared only where state 7 and action 3 mean the same to all: with any sharing the
//! robots of an arena get a common codebook when their phase 1 ends, from an equal part of each
//! robot's sample ([`pool`]), as robots are given the same firmware before they are set out.

pub mod pool;
pub mod radio;
pub mod told;
