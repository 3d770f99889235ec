//! Controllers of methods that learn nothing.

use crate::bodies::Body;
use crate::controllers::Controller;
use crate::spec::RunSpec;

/// A controller that walks from the first step of a run to the last.
pub(crate) trait Walker: Controller {
    /// The controller of a robot; `key` is that of its action stream.
    fn new(spec: &RunSpec, key: u64) -> Self;

    /// Whether what was saved can be reckoned with.
    fn is_sound(&self) -> bool {
        true
    }

    /// An epoch begins where the robot stands.
    #[inline(always)]
    fn begin_epoch(&mut self, _body: &Body) {}
}
