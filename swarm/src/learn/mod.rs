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

/// Largest amount of a number that is saved and read again: far beyond what any run comes to, and
/// no sum of products of such numbers is beyond `f32`.
const FARTHEST: f32 = 1e9;

/// Whether numbers of saved state can be reckoned with.
pub(crate) fn are_sound<'a>(numbers: impl IntoIterator<Item = &'a f32>) -> bool {
    numbers.into_iter().all(|x| x.abs() <= FARTHEST)
}
