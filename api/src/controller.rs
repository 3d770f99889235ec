//! The controller's end of the service on which a run asks what its robots are to do: for programs
//! that steer robots from outside the simulator.
//!
//! ```no_run
//! use api::controller::Controller;
//!
//! let mut controller = Controller::open(&api::frames::default_root(), "RUN_ID", 0)?;
//! controller.serve(|_asked, robots, commands| {
//!     for (robot, command) in robots.iter().zip(commands) {
//!         command.left = 0.5;
//!         command.right = if robot.sensors[0] > 300.0 { 1.0 } else { 0.5 };
//!     }
//! })?;
//! # Ok::<(), api::controller::ControllerError>(())
//! ```

use std::fmt::Debug;
use std::path::Path;
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;

use crate::external::{
    Answered, Asked, EXTERNAL_VERSION, RobotSense, Side, WheelCommand, external_bell,
    external_service,
};
use crate::frames::{RootError, transport_config};

/// How long a question is waited for awake, before the controller sleeps until the bell rings.
const SPIN: Duration = Duration::from_micros(20);
/// Longest sleep: a bell that was missed costs no more than this.
const SLEEP: Duration = Duration::from_millis(50);
/// Longest wait for the removal of a controller that was killed.
const CLEAN_UP: Duration = Duration::from_millis(500);

type AskedService = iceoryx2::service::port_factory::request_response::PortFactory<
    ipc::Service,
    [RobotSense],
    Asked,
    [WheelCommand],
    Answered,
>;
type Question = ActiveRequest<ipc::Service, [RobotSense], Asked, [WheelCommand], Answered>;

/// Why a controller cannot work.
#[derive(Debug, thiserror::Error)]
pub enum ControllerError {
    /// The root path cannot be used.
    #[error(transparent)]
    Root(#[from] RootError),
    /// The transport refused something.
    #[error("{what}: {why}")]
    Transport {
        /// What was tried.
        what: &'static str,
        /// What it said.
        why: String,
    },
}

/// Says what was tried when the transport refuses it.
///
/// # Errors
/// `Transport` where the outcome is one.
pub fn transport<T, E: Debug>(
    what: &'static str,
    outcome: Result<T, E>,
) -> Result<T, ControllerError> {
    outcome.map_err(|error| ControllerError::Transport {
        what,
        why: format!("{error:?}"),
    })
}

/// A node of this process under a root.
///
/// # Errors
/// When the root or the transport cannot be used.
pub fn node(root: &Path) -> Result<Node<ipc::Service>, ControllerError> {
    let config = transport_config(root)?;
    let node = NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>();
    transport("a node of the transport", node)
}

/// The service on which a run asks a controller, opened or made: both ends say the same of it.
///
/// # Errors
/// When the transport refuses it; another version of the types is refused here.
pub fn service(
    node: &Node<ipc::Service>,
    run_id: &str,
    controller: usize,
) -> Result<AskedService, ControllerError> {
    let name = transport(
        "the name of the service",
        ServiceName::new(&external_service(run_id, controller)),
    )?;
    let service = node
        .service_builder(&name)
        .request_response::<[RobotSense], [WheelCommand]>()
        .request_user_header::<Asked>()
        .response_user_header::<Answered>()
        .max_clients(1)
        // Two controllers of the same robots would be told apart by nobody.
        .max_servers(1)
        .max_nodes(4)
        .max_active_requests_per_client(1)
        .max_response_buffer_size(1)
        .open_or_create();
    transport("the service (of this version?)", service)
}

/// The bell of one side.
type Bell = iceoryx2::service::port_factory::event::PortFactory<ipc::Service>;

/// The event service on which a side says that it has sent something.
///
/// # Errors
/// When the transport refuses it.
pub fn bell(
    node: &Node<ipc::Service>,
    run_id: &str,
    controller: usize,
    side: Side,
) -> Result<Bell, ControllerError> {
    let name = transport(
        "the name of the bell",
        ServiceName::new(&external_bell(run_id, controller, side)),
    )?;
    let bell = node
        .service_builder(&name)
        .event()
        .max_notifiers(2)
        .max_listeners(2)
        .max_nodes(4)
        .open_or_create();
    transport("the bell", bell)
}

/// A controller of a run's robots. Fields are dropped in this order.
pub struct Controller {
    server: Server<ipc::Service, [RobotSense], Asked, [WheelCommand], Answered>,
    asked: Listener<ipc::Service>,
    answered: Notifier<ipc::Service>,
    _service: AskedService,
    _bells: [Bell; 2],
    _node: Node<ipc::Service>,
}

impl Controller {
    /// A controller of the run with this id, the one with this number of those that share its
    /// robots. The run need not have begun.
    ///
    /// # Errors
    /// When the transport refuses it, or another controller is there.
    pub fn open(root: &Path, run_id: &str, number: usize) -> Result<Self, ControllerError> {
        let node = node(root)?;
        // One that was killed is still registered.
        node.blocking_cleanup_dead_nodes(CLEAN_UP);
        let service = service(&node, run_id, number)?;
        let bells = [
            bell(&node, run_id, number, Side::Asked)?,
            bell(&node, run_id, number, Side::Answered)?,
        ];
        let asked = transport(
            "a listener (root path too long?)",
            bells[0].listener_builder().create(),
        )?;
        let answered = transport("a notifier", bells[1].notifier_builder().create())?;
        let server = service
            .server_builder()
            .initial_max_slice_len(64)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .create();
        let server = transport("a port (is another controller there?)", server)?;
        Ok(Self {
            server,
            asked,
            answered,
            _service: service,
            _bells: bells,
            _node: node,
        })
    }

    /// Answers for as long as the process lives. `act` is told the moment and the robots, and sets a
    /// command for each, in the same order; they are 0 before.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn serve(
        &mut self,
        mut act: impl FnMut(&Asked, &[RobotSense], &mut [WheelCommand]),
    ) -> Result<(), ControllerError> {
        loop {
            self.answer(Duration::MAX, &mut act)?;
        }
    }

    /// Waits for one question, and answers it. Returns whether there was one in time.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn answer(
        &mut self,
        wait: Duration,
        mut act: impl FnMut(&Asked, &[RobotSense], &mut [WheelCommand]),
    ) -> Result<bool, ControllerError> {
        let Some(question) = self.question(wait)? else {
            return Ok(false);
        };
        let robots = question.payload();
        let asked = *question.user_header();
        let mut answer = transport("an answer", question.loan_slice(robots.len()))?;
        act(&asked, robots, answer.payload_mut());
        *answer.user_header_mut() = Answered {
            arena_step: asked.arena_step,
            version: EXTERNAL_VERSION,
            reserved: 0,
        };
        transport("sending an answer", answer.send())?;
        // Whoever has given up meanwhile hears no bell.
        transport("ringing", self.answered.notify())?;
        Ok(true)
    }

    fn question(&self, wait: Duration) -> Result<Option<Question>, ControllerError> {
        let since = Instant::now();
        loop {
            if let Some(question) = transport("a question", self.server.receive())? {
                return Ok(Some(question));
            }
            let waited = since.elapsed();
            if waited >= wait {
                return Ok(None);
            }
            if waited < SPIN {
                std::hint::spin_loop();
                continue;
            }
            let sleep = SLEEP.min(wait - waited);
            transport("waiting", self.asked.timed_wait(|_| {}, sleep))?;
        }
    }
}
