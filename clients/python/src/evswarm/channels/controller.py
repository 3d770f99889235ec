"""A controller in another process: the run asks before each step, and waits for the answer."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import iceoryx2 as iox2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from evswarm.channels import types
from evswarm.channels.transport import ChannelError, as_array, attempt, columns, open_node

_SPIN_S = 20e-6
_SLEEP_S = 0.05


@dataclass(frozen=True)
class Readings:
    """What all robots of a controller read before a step. Arrays lie in shared memory: they are
    read-only, and good until the question is answered."""

    sensors: NDArray[np.float32]
    """Raw proximity values of ps0 to ps7, (robots, 8), 0 to 4095."""
    robots: NDArray[Any]
    """All that is told of each robot: number, sensors, x_m, y_m, heading_cos, heading_sin,
    first_entries. Sensors are all that a robot knows itself."""
    arena_step: int
    """Steps of the arena since the run began."""
    epoch: int
    """Epoch, from 0."""
    epoch_step: int
    """Step within the epoch; at 0 robots are back at their starts, unless episodes continue."""
    epochs: int
    """Epochs of the run."""
    steps_per_epoch: int
    """Steps of an epoch."""
    step_s: float
    """Control step, simulated seconds."""
    size_m: tuple[float, float]
    """Width and height of the arena, metres."""
    squares: tuple[int, int]
    """Squares of the arena: columns, rows."""

    @property
    def positions_m(self) -> NDArray[np.float32]:
        """Positions, (robots, 2)."""
        return columns(self.robots, "x_m", 2)


class Controller(ABC):
    """A control program for all robots at once."""

    @abstractmethod
    def act(self, readings: Readings) -> ArrayLike:
        """Wheel commands, (robots, 2): left and right, -1 to 1 of the top speed."""


class Question:
    """A question of the run; it waits until this is answered."""

    def __init__(self, port: ControllerPort, request: Any) -> None:
        self._port = port
        self._request = request
        asked = request.user_header().contents
        # The length of the slice itself counts bytes in some versions of the library.
        robots = as_array(request.payload_ptr, asked.asked_robots, types.ROBOT_SENSE)
        robots.flags.writeable = False
        self.readings = Readings(
            sensors=robots["sensors"],
            robots=robots,
            arena_step=asked.arena_step,
            epoch=asked.epoch,
            epoch_step=asked.epoch_step,
            epochs=asked.epochs,
            steps_per_epoch=asked.steps_per_epoch,
            step_s=asked.step_s,
            size_m=(asked.width_m, asked.height_m),
            squares=(asked.columns, asked.rows),
        )

    def answer(self, commands: ArrayLike) -> None:
        """Answers with a command for each robot, (robots, 2)."""
        given = np.asarray(commands, dtype=np.float32)
        count = len(self.readings.robots)
        if given.shape != (count, 2):
            raise ValueError(f"commands of shape {given.shape} (allowed: {(count, 2)})")
        loan = attempt("an answer", lambda: self._request.loan_slice_uninit(count))
        target = as_array(loan.payload_ptr, count * 2, np.dtype(np.float32))
        target[:] = given.ravel()
        header = loan.user_header().contents
        header.arena_step = self.readings.arena_step
        header.version = types.EXTERNAL_VERSION
        attempt("sending an answer", lambda: loan.assume_init().send())
        self._request.delete()
        self._port.ring()


class ControllerPort:
    """The controller's end of a run that is steered from outside, or of its robots of a number."""

    def __init__(self, run_id: str, number: int = 0, root: Path | None = None) -> None:
        self._node = open_node(root)
        # One that was killed is still registered.
        self._node.blocking_cleanup_dead_nodes(iox2.Duration.from_millis(500))
        name = f"swarm/{run_id}/external/{number}"
        builder = self._node.service_builder(iox2.ServiceName.new(name))
        self._service = attempt(
            "the service (of this version?)",
            lambda: (
                builder.request_response(
                    iox2.Slice[types.RobotSense], iox2.Slice[types.WheelCommand]
                )
                .request_header(types.Asked)
                .response_header(types.Answered)
                .max_clients(1)
                .max_servers(1)
                .max_nodes(4)
                .max_active_requests_per_client(1)
                .max_response_buffer_size(1)
                .open_or_create()
            ),
        )
        asked, answered = (self._bell(f"{name}/{side}") for side in ("asked", "answered"))
        self._bells = asked, answered
        self._asked = attempt(
            "a listener (root path too long?)", lambda: asked.listener_builder().create()
        )
        self._answered = attempt("a notifier", lambda: answered.notifier_builder().create())
        self._server = attempt(
            "a port (is another controller there?)",
            lambda: (
                self._service.server_builder()
                .initial_max_slice_len(64)
                .allocation_strategy(iox2.AllocationStrategy.PowerOfTwo)
                .create()
            ),
        )

    def _bell(self, name: str) -> Any:
        builder = self._node.service_builder(iox2.ServiceName.new(name)).event()
        builder = builder.max_notifiers(2).max_listeners(2).max_nodes(4)
        return attempt("a bell", builder.open_or_create)

    def question(self, timeout_s: float = 5.0) -> Question | None:
        """Waits for the next question; ``None`` where none comes in time."""
        since = time.perf_counter()
        while True:
            request = attempt("a question", self._server.receive)
            if request is not None:
                return Question(self, request)
            waited = time.perf_counter() - since
            if waited >= timeout_s:
                return None
            if waited >= _SPIN_S:
                sleep_s = min(_SLEEP_S, timeout_s - waited)
                duration = iox2.Duration.from_secs_f64(sleep_s)
                attempt("waiting", lambda d=duration: self._asked.timed_wait(d))

    def ring(self) -> None:
        """Says that an answer was sent."""
        attempt("ringing", self._answered.notify)

    def close(self) -> None:
        """Lets go of the run, which waits for another controller."""
        for port in (self._server, self._asked, self._answered):
            port.delete()

    def __enter__(self) -> ControllerPort:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def steer(
    run_id: str,
    controller: Controller,
    *,
    number: int = 0,
    root: Path | None = None,
    idle_s: float = 10.0,
) -> int:
    """Steers a run's robots until it asks nothing for ``idle_s`` seconds. Returns the steps."""
    steps = 0
    with ControllerPort(run_id, number, root) as port:
        while (question := port.question(idle_s)) is not None:
            question.answer(controller.act(question.readings))
            steps += 1
    return steps


__all__ = ["ChannelError", "Controller", "ControllerPort", "Question", "Readings", "steer"]
