//! Benchmarks of the step loop (cases with goals, measured in turn, compared with earlier figures)
//! load on the service, its memory, faults of it, inputs at random, and what recording costs.

pub mod cases;
pub mod channels;
mod client;
pub mod compare;
pub mod document;
pub mod faults;
pub mod fuzz;
pub mod gain;
pub mod instructions;
pub mod measure;
pub mod memory;
pub mod picture;
pub mod recording;
mod server;
pub mod service;
pub mod short;
pub mod table;
pub mod threads;
