//! Benchmarks of the step loop: cases with goals, measured in turn, compared with earlier figures.

pub mod cases;
pub mod compare;
pub mod document;
pub mod instructions;
pub mod measure;
pub mod picture;
pub mod table;
