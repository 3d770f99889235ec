//! The learning algorithms of Ev-ITER, each on its own; `robot` and `run` put them together.
//!
//! What the step loop calls is inlined, allocates nothing and uses only `+ - * / sqrt`.

pub mod accuracy;
pub mod actuator_samples;
pub mod archive;
pub mod centres;
pub mod epsilon_clustering;
pub mod evolution;
mod flat;
pub mod kmeans;
pub mod objective;
pub mod perceptron;
pub mod repository;
pub mod reservoir;
pub mod sigmoid;
pub mod transition;
