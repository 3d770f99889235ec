//! What the simulator and a controller in another process say to each other: before each step all
//! readings, then all wheel commands: a request and its answer on the service [`external_service`].

use iceoryx2::prelude::ZeroCopySend;

use crate::frames::{TypeLayout, shared_type};

/// Version of [`Asked`], [`RobotSense`], [`Answered`] and [`WheelCommand`]; part of their type names, so that a
/// controller of another version is refused when it opens the service.
pub const EXTERNAL_VERSION: u32 = 1;

shared_type! {
    /// What the simulator asks: the header of a request, whose slice has a [`RobotSense`] for each
    /// robot of this controller.
    Asked as "swarm.Asked.v1" {
        /// Steps of the arena since the run began: what the answer is for.
        arena_step: u64,
        /// Simulated seconds since the run began.
        sim_time_s: f64,
        /// Control step, simulated seconds.
        step_s: f64,
        /// Width of the arena, metres.
        width_m: f64,
        /// Height of the arena, metres.
        height_m: f64,
        /// Epoch that the run is in, from 0.
        epoch: u32,
        /// Step within the epoch, from 0; at 0 robots have been put back to their starts, unless
        /// episodes continue.
        epoch_step: u32,
        /// Epochs of the run.
        epochs: u32,
        /// Steps of an epoch.
        steps_per_epoch: u32,
        /// Robots of the run.
        robots: u32,
        /// Number of the first robot in the slice; the others follow.
        first_robot: u32,
        /// Squares of the arena side by side.
        columns: u32,
        /// Squares of the arena one above the other.
        rows: u32,
        /// Robots in the slice.
        asked_robots: u32,
        /// [`EXTERNAL_VERSION`] of the simulator.
        version: u32,
    }
}

shared_type! {
    /// What a robot reads. Position and first entries are there for rewards and displays: a
    /// robot does not know them.
    RobotSense as "swarm.RobotSense.v1" {
        /// Number of the robot in its run, from 0.
        number: u32,
        /// Raw proximity values of ps0 to ps7, 0 to 4095.
        sensors: [f32; 8],
        /// Position, metres from the arena's lower left corner.
        x_m: f32,
        /// Position, metres upwards.
        y_m: f32,
        /// Cosine of the heading (counter-clockwise from the x axis).
        heading_cos: f32,
        /// Sine of the heading.
        heading_sin: f32,
        /// Squares that it was the first robot to enter.
        first_entries: u32,
    }
}

shared_type! {
    /// The header of an answer, whose slice has a [`WheelCommand`] for each robot asked about, in
    /// their order.
    Answered as "swarm.Answered.v1" {
        /// [`Asked::arena_step`] of the request.
        arena_step: u64,
        /// [`EXTERNAL_VERSION`] of the controller.
        version: u32,
        /// Always 0: keeps the type free of padding.
        reserved: u32,
    }
}

shared_type! {
    /// What a robot is to do in a step.
    WheelCommand as "swarm.WheelCommand.v1" {
        /// Left wheel, -1 to 1 of the top speed; rounded to thousandths.
        left: f32,
        /// Right wheel.
        right: f32,
    }
}

/// Name of the service on which a run asks its controller; of several controllers that with this
/// number, from 0.
pub fn external_service(run_id: &str, controller: usize) -> String {
    format!("swarm/{run_id}/external/{controller}")
}

/// Name of the event service on which the simulator says that it has asked, or the controller that it
/// has answered.
pub fn external_bell(run_id: &str, controller: usize, side: Side) -> String {
    let side = match side {
        Side::Asked => "asked",
        Side::Answered => "answered",
    };
    format!("swarm/{run_id}/external/{controller}/{side}")
}

/// What there is to hear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The simulator has asked.
    Asked,
    /// The controller has answered.
    Answered,
}

/// The robots of a controller of so many that share `robots`: first and number. Ranges differ in
/// length by one at most; the first ones are longer.
pub fn share(robots: usize, controllers: usize, controller: usize) -> (usize, usize) {
    let (each, more) = (robots / controllers, robots % controllers);
    let first = controller * each + controller.min(more);
    (first, each + usize::from(controller < more))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn version_1_never_changes_its_layout() {
        let sizes = [
            Asked::layout(),
            RobotSense::layout(),
            Answered::layout(),
            WheelCommand::layout(),
        ]
        .map(|layout| {
            let fields: usize = layout.fields.iter().map(|field| field.size_bytes).sum();
            assert_eq!(fields, layout.size_bytes, "padding in {}", layout.type_name);
            assert!(layout.type_name.ends_with(&format!(".v{EXTERNAL_VERSION}")));
            layout.size_bytes
        });
        assert_eq!(sizes, [80, 56, 16, 8]);
    }

    #[test]
    fn shares_are_contiguous_and_leave_nobody_out() {
        for (robots, controllers) in [(1, 1), (10, 3), (3, 5), (64, 64)] {
            let mut next = 0;
            for controller in 0..controllers {
                let (first, count) = share(robots, controllers, controller);
                assert_eq!(first, next);
                next += count;
            }
            assert_eq!(next, robots);
        }
    }
}
