//! What pages see of a run while a worker steps it: pictures of where robots are, and what
//! they have learnt. Nothing is copied while nobody looks, and no result depends on who does.

mod frame;
mod learnt;
mod observer;
mod window;

pub use frame::{covered, hello, steps_of_squares, waiting};
pub use learnt::{learning, shown};
pub use observer::Watched;
pub use window::{Viewer, Window};
