//! What robots sense: each kind of sensor is a file that fills its field of a [`Reading`].
//!
//! [`proximity`] is the one that there is. To add another, say `ground.rs`, `range_bearing.rs` or
//! `compass.rs`:
//!
//! 1. Its field goes into [`Reading`] (`bodies/reading.rs`), at the end; a length that others need
//!    goes into `dimensions.rs`. Controllers that do not look at the field stay as they are.
//! 2. Its constants, taken from the robot model, are a struct like [`proximity::Optics`] that
//!    [`crate::world::World`] holds. What it senses is a function of the state of the world before
//!    the phase alone, so that the order of robots cannot show: the ground's colour of a place, the
//!    places of robots in range (`engine/crowd.rs` finds them by cell), the heading of the body.
//! 3. `World::sense` (`world/step.rs`) fills the field after the proximity values. Noise comes from
//!    a key of its own (`random::Purpose`), never from that of another sensor.
//! 4. `Reading` is saved with its body: a new field changes the layout of snapshots (the version
//!    in `run/snapshot.rs`) and every `state_sha256`, hence `RESULTS_VERSION`.

pub mod noise;
pub mod proximity;

pub use crate::bodies::Reading;
