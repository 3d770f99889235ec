//! Controllers of methods that learn nothing.

use crate::bodies::Body;
use crate::controllers::Controller;
use crate::spec::RunSpec;

/// A controller that walks from the first step of a run to the last.
pub(crate) trait Walker: Controller {
    /// The controller of a robot; `key` is that of its action stream.
    fn new(spec: &RunSpec, key: u64) -> Self;

    /// An epoch begins where the robot stands.
    #[inline(always)]
    fn begin_epoch(&mut self, _body: &Body) {}
}
