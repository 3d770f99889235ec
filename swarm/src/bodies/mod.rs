//! Robots and movable objects as plain data: what a world moves and a snapshot holds.

mod body;
mod list;
mod objects;
mod pose;
mod reading;
mod shape;

pub use body::Body;
pub use list::Bodies;
pub use objects::Objects;
pub use pose::{ObjectPose, StartPose};
pub use reading::Reading;
pub use shape::Shape;
