//! The simulator's end: before each step it asks the programs that steer a run's robots, and waits
//! for their answers. A question that is not answered leaves the run where it was.

use std::path::Path;
use std::time::{Duration, Instant};

use api::WaitsFor;
use api::controller::{ControllerError, bell, node, service, transport};
use api::external::{Answered, Asked, EXTERNAL_VERSION, RobotSense, Side, WheelCommand, share};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;
use swarm::run::Run;
use swarm::spec::{Method, RunSpec};
use swarm::world::Body;

use super::port::create_private_folder;
use super::room::{self, NoRoom};
use crate::runner::{Attendant, Wait};

/// How long an answer is waited for awake, before the run sleeps until the bell rings.
const SPIN: Duration = Duration::from_micros(20);
/// Longest sleep: a bell that was missed costs no more than this.
const SLEEP: Duration = Duration::from_millis(10);
/// Time between two looks for a controller that is not there.
const LOOK: Duration = Duration::from_millis(2);
/// Time between two looks whether the controller that is waited for was killed.
const LOOK_FOR_DEAD: Duration = Duration::from_millis(100);
/// Least time that the first question of an attempt may take: a controller connects then.
const FIRST: Duration = Duration::from_secs(1);

type Pending = PendingResponse<ipc::Service, [RobotSense], Asked, [WheelCommand], Answered>;

/// Why there is no answer that can be used.
#[derive(Debug, thiserror::Error)]
pub enum AskError {
    /// Nobody is there.
    #[error("controller {0} is not there")]
    Absent(usize),
    /// It did not answer in time: it is busy, stopped or dead.
    #[error("controller {controller} did not answer within {deadline_ms} ms")]
    Late {
        /// Its number.
        controller: usize,
        /// What it was given.
        deadline_ms: u128,
    },
    /// What it answered cannot be used.
    #[error("controller {controller} answered wrongly: {why}")]
    Wrong {
        /// Its number.
        controller: usize,
        /// Which field, what is allowed.
        why: String,
    },
    /// The run is to be let go.
    #[error("the run is let go")]
    LetGo,
    /// Shared memory is full.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// The transport failed.
    #[error(transparent)]
    Transport(#[from] ControllerError),
}

impl AskError {
    /// Whether the same question may be answered later, by the same program or another.
    pub fn may_pass(&self) -> bool {
        !matches!(self, Self::Wrong { .. })
    }
}

/// The connection to one controller. Fields are dropped in this order.
struct Part {
    pending: Option<Pending>,
    client: Client<ipc::Service, [RobotSense], Asked, [WheelCommand], Answered>,
    asked: Notifier<ipc::Service>,
    answered: Listener<ipc::Service>,
    /// Its robots: first, number.
    robots: (usize, usize),
}

impl Part {
    fn open(
        node: &Node<ipc::Service>,
        run_id: &str,
        controller: usize,
        robots: (usize, usize),
    ) -> Result<Self, ControllerError> {
        let service = service(node, run_id, controller)?;
        let asked = bell(node, run_id, controller, Side::Asked)?;
        let answered = bell(node, run_id, controller, Side::Answered)?;
        let client = service
            .client_builder()
            .initial_max_slice_len(robots.1.max(1))
            .create();
        Ok(Self {
            pending: None,
            client: transport("a port that asks", client)?,
            asked: transport("a notifier", asked.notifier_builder().create())?,
            answered: transport("a listener", answered.listener_builder().create())?,
            robots,
        })
    }

    /// Sends the question. Returns whether anybody is there to hear it.
    fn ask(&mut self, asked: Asked, senses: &[RobotSense]) -> Result<bool, AskError> {
        self.pending = None;
        room::for_bytes(size_of_val(senses) + size_of::<Asked>())?;
        let request = transport("a question", self.client.loan_slice_uninit(senses.len()))?;
        let mut request = request.write_from_slice(senses);
        *request.user_header_mut() = asked;
        let pending = transport("sending a question", request.send())?;
        if pending.number_of_server_connections() == 0 {
            return Ok(false);
        }
        self.pending = Some(pending);
        transport("ringing", self.asked.notify())?;
        Ok(true)
    }

    /// Waits for the answer and writes it to `commands`. Returns whether it came in time.
    fn receive(
        &mut self,
        node: &Node<ipc::Service>,
        controller: usize,
        arena_step: u64,
        until: Instant,
        wait: &mut Wait<'_>,
        commands: &mut [[f32; 2]],
    ) -> Result<bool, AskError> {
        let Some(pending) = &self.pending else {
            return Ok(false);
        };
        let since = Instant::now();
        let mut looked = since;
        loop {
            let is_there = pending.is_connected();
            if let Some(answer) = transport("an answer", pending.receive())? {
                let header = answer.user_header();
                if header.arena_step != arena_step {
                    // Too late, and to a question that has been given up.
                    continue;
                }
                check(header, answer.payload(), commands)
                    .map_err(|why| AskError::Wrong { controller, why })?;
                self.pending = None;
                return Ok(true);
            }
            let now = Instant::now();
            if !is_there {
                self.pending = None;
                return Err(AskError::Absent(controller));
            }
            if now >= until {
                self.pending = None;
                return Ok(false);
            }
            if now - looked >= LOOK_FOR_DEAD {
                looked = now;
                // One that was killed stays connected until somebody looks.
                node.try_cleanup_dead_nodes();
            }
            if now - since < SPIN {
                std::hint::spin_loop();
                continue;
            }
            if !wait.look_around() {
                self.pending = None;
                return Err(AskError::LetGo);
            }
            let sleep = SLEEP.min(until.saturating_duration_since(Instant::now()));
            transport("waiting", self.answered.timed_wait(|_| {}, sleep))?;
        }
    }
}

/// Checks an answer and takes its commands.
fn check(
    header: &Answered,
    answer: &[WheelCommand],
    commands: &mut [[f32; 2]],
) -> Result<(), String> {
    if header.version != EXTERNAL_VERSION {
        return Err(format!(
            "version {} (allowed: {EXTERNAL_VERSION})",
            header.version
        ));
    }
    if answer.len() != commands.len() {
        return Err(format!(
            "{} commands (allowed: {}, one for each robot asked about)",
            answer.len(),
            commands.len()
        ));
    }
    for (place, (given, command)) in answer.iter().zip(commands).enumerate() {
        for (wheel, value) in [("left", given.left), ("right", given.right)] {
            if !(-1.0..=1.0).contains(&value) {
                return Err(format!(
                    "{wheel} of command {place} is {value} (allowed: -1 to 1)"
                ));
            }
        }
        *command = [given.left, given.right];
    }
    Ok(())
}

/// The programs that steer a run.
pub struct External {
    parts: Vec<Part>,
    node: Node<ipc::Service>,
    deadline: Duration,
    is_first: bool,
    senses: Vec<RobotSense>,
    commands: Vec<[f32; 2]>,
}

impl External {
    /// The connections of a run that is steered from outside; `None` for others.
    ///
    /// # Errors
    /// When the transport fails, or shared memory is full.
    pub fn open(root: &Path, run_id: &str, spec: &RunSpec) -> Result<Option<Self>, AskError> {
        if spec.controller.method != Method::External {
            return Ok(None);
        }
        let parameters = swarm::methods::ExternalParameters::of(spec);
        let (robots, controllers) = (spec.robots as usize, parameters.controllers as usize);
        room::for_bytes(robots * (size_of::<RobotSense>() + size_of::<WheelCommand>()))?;
        transport("the root folder", create_private_folder(root))?;
        let node = node(root)?;
        // A server that was killed may still be registered as the one that asks.
        node.try_cleanup_dead_nodes();
        let parts = (0..controllers)
            .map(|number| Part::open(&node, run_id, number, share(robots, controllers, number)))
            .collect::<Result<_, _>>()?;
        Ok(Some(Self {
            parts,
            node,
            deadline: Duration::from_millis(u64::from(parameters.deadline_ms)),
            is_first: true,
            senses: vec![RobotSense::default(); robots],
            commands: vec![[0.0; 2]; robots],
        }))
    }

    /// Asks for the next step of a run, and steers it by the answers; somebody attends to the run
    /// while it waits for them.
    ///
    /// # Errors
    /// When there is none that can be used; the run is as it was.
    pub fn steer(&mut self, run: &mut Run, attendant: &dyn Attendant) -> Result<(), AskError> {
        let asked = self.sense(run);
        let deadline = match self.is_first {
            true => self.deadline.max(FIRST),
            false => self.deadline,
        };
        let mut wait = Wait::new(attendant, run, WaitsFor::Controllers);
        let answered = self.ask(asked, deadline, &mut wait);
        drop(wait);
        if answered.is_err() {
            // Whoever was killed is not waited for the next time.
            self.node.try_cleanup_dead_nodes();
        }
        answered?;
        self.is_first = false;
        run.steer(&self.commands);
        Ok(())
    }

    fn sense(&mut self, run: &Run) -> Asked {
        let sense = |(number, body): (usize, &Body)| RobotSense {
            number: number as u32,
            sensors: body.reading.proximity,
            x_m: body.x_m,
            y_m: body.y_m,
            heading_cos: body.cos,
            heading_sin: body.sin,
            first_entries: body.first_entries,
        };
        let bodies = run.robots().iter().enumerate();
        for (place, body) in self.senses.iter_mut().zip(bodies) {
            *place = sense(body);
        }
        let (spec, arena) = (run.spec(), run.arena());
        let [columns, rows] = arena.squares();
        let (epoch, epoch_step) = run.epoch_and_step();
        let step_s = spec.robot.parameters.step_s;
        Asked {
            arena_step: run.step(),
            sim_time_s: run.step() as f64 * step_s,
            step_s,
            epoch,
            epoch_step,
            epochs: spec.epochs,
            steps_per_epoch: spec.steps_per_epoch,
            robots: spec.robots,
            first_robot: 0,
            width_m: arena.width_m(),
            height_m: arena.height_m(),
            columns,
            rows,
            asked_robots: 0,
            version: EXTERNAL_VERSION,
        }
    }

    fn ask(
        &mut self,
        asked: Asked,
        deadline: Duration,
        wait: &mut Wait<'_>,
    ) -> Result<(), AskError> {
        let until = Instant::now() + deadline;
        for (number, part) in self.parts.iter_mut().enumerate() {
            let (first, count) = part.robots;
            let asked = Asked {
                first_robot: first as u32,
                asked_robots: count as u32,
                ..asked
            };
            while count > 0 && !part.ask(asked, &self.senses[first..first + count])? {
                if Instant::now() >= until {
                    return Err(AskError::Absent(number));
                }
                if !wait.look_around() {
                    return Err(AskError::LetGo);
                }
                std::thread::sleep(LOOK);
            }
        }
        let node = &self.node;
        for (controller, part) in self.parts.iter_mut().enumerate() {
            let (first, count) = part.robots;
            let commands = &mut self.commands[first..first + count];
            let step = asked.arena_step;
            if count > 0 && !part.receive(node, controller, step, until, wait, commands)? {
                return Err(AskError::Late {
                    controller,
                    deadline_ms: deadline.as_millis(),
                });
            }
        }
        Ok(())
    }
}

/// Looks for controllers of runs that wait for them.
pub struct Lookout {
    node: Node<ipc::Service>,
}

impl Lookout {
    /// A look-out under a root.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn open(root: &Path) -> Result<Self, ControllerError> {
        Ok(Self { node: node(root)? })
    }

    /// Whether all controllers of a run are there; those that were killed are not.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn all_there(&self, run_id: &str, controllers: usize) -> Result<bool, ControllerError> {
        self.node.try_cleanup_dead_nodes();
        for controller in 0..controllers {
            let service = service(&self.node, run_id, controller)?;
            if service.dynamic_config().number_of_servers() == 0 {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answered() -> Answered {
        Answered {
            arena_step: 7,
            version: EXTERNAL_VERSION,
            reserved: 0,
        }
    }

    #[test]
    fn answers_that_cannot_be_used_say_what_is_allowed() {
        let command = |left, right| WheelCommand { left, right };
        let one = [command(0.5, -1.0)];
        let mut commands = [[0.0; 2]];
        let mut answer = |header: Answered, answer: &[WheelCommand]| {
            check(&header, answer, &mut commands).map_err(|why| why.to_string())
        };
        assert_eq!(answer(answered(), &one), Ok(()));
        for wrong in [f32::NAN, f32::INFINITY, 1.001, -7.0] {
            let why = answer(answered(), &[command(0.0, wrong)]).err();
            assert!(why.is_some_and(|why| why.contains("right of command 0")));
        }
        let other = Answered {
            version: 9,
            ..answered()
        };
        for (header, commands) in [(other, &one[..]), (answered(), &[])] {
            assert!(answer(header, commands).is_err());
        }
    }
}
