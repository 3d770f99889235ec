"""Frames: where every robot of a run stands, up to 60 times a second, latest first."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import iceoryx2 as iox2
from numpy.typing import NDArray

from evswarm.channels import types
from evswarm.channels.transport import as_array, attempt, columns, open_node

PHASES = ("babbling", "evolution", "repository", "exploration", "done")
"""Names of the phases of a run."""


@dataclass(frozen=True)
class Frame:
    """A moment of a run. Arrays lie in shared memory and stay there for as long as this does."""

    robots: NDArray[Any]
    """Read-only, one structured element a robot: number, x_m, y_m, heading_cos, heading_sin,
    sensors (8), commands (2)."""
    arena_step: int
    """Steps of the arena since the run began."""
    sim_time_s: float
    """Simulated seconds since the run began."""
    phase: str
    """What the run is doing."""
    epochs_done: int
    """Counted epochs that are complete."""
    epochs_total: int
    """Counted epochs in all."""
    _sample: Any

    @property
    def positions_m(self) -> NDArray[Any]:
        """Positions, (robots, 2)."""
        return columns(self.robots, "x_m", 2)


class FrameReader:
    """Reads the frames of a run with ``"channels": true``."""

    def __init__(self, run_id: str, root: Path | None = None) -> None:
        self._node = open_node(root)
        builder = self._node.service_builder(iox2.ServiceName.new(f"swarm/{run_id}/frames"))
        service = attempt(
            "the frames of the run (has it channels, and of this version?)",
            lambda: (
                builder.publish_subscribe(iox2.Slice[types.RobotState])
                .user_header(types.FrameHeader)
                .open()
            ),
        )
        self._service = service
        self._subscriber = attempt("a reader", lambda: service.subscriber_builder().create())

    def read(self) -> Frame | None:
        """The newest frame that has not been read; ``None`` where there is none."""
        newest = None
        while (sample := attempt("a frame", self._subscriber.receive)) is not None:
            newest = sample
        return None if newest is None else _frame(newest)

    def wait(self, timeout_s: float = 5.0) -> Frame | None:
        """Waits for a frame."""
        until = time.monotonic() + timeout_s
        while (frame := self.read()) is None:
            if time.monotonic() >= until:
                return None
            time.sleep(0.002)
        return frame

    def close(self) -> None:
        """Lets go of the channel."""
        self._subscriber.delete()

    def __enter__(self) -> FrameReader:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _frame(sample: Any) -> Frame:
    header = sample.user_header().contents
    robots = as_array(sample.payload_ptr, header.robots, types.ROBOT_STATE)
    robots.flags.writeable = False
    phase = PHASES[header.phase] if header.phase < len(PHASES) else "unknown"
    return Frame(
        robots=robots,
        arena_step=header.arena_step,
        sim_time_s=header.sim_time_s,
        phase=phase,
        epochs_done=header.epochs_done,
        epochs_total=header.epochs_total,
        _sample=sample,
    )
