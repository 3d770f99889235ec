//! Benchmarks of the step loop (cases with goals, measured in turn, compared with earlier figures)
//! and load on the service.

pub mod cases;
pub mod compare;
pub mod document;
pub mod instructions;
pub mod measure;
pub mod picture;
pub mod service;
pub mod table;
