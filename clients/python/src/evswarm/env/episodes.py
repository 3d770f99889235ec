"""What all environments have in common: a simulation, its episodes, and rewards."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from evswarm.channels import Readings
from evswarm.env.rewards import REWARDS, Squares
from evswarm.env.simulation import Simulation

MOST_SEED = 2**53 - 1
"""Highest seed of a run."""

HIGHEST = 4095.0
"""Highest raw value of a sensor."""


class Episodes:
    """Episodes of ``steps`` steps of all robots of a spec."""

    def __init__(self, spec: dict[str, Any], steps: int, reward: str) -> None:
        if reward not in REWARDS:
            raise ValueError(f"reward {reward!r} (allowed: {', '.join(sorted(REWARDS))})")
        self.robots = int(spec.get("robots", 1))
        self.steps = steps
        self._reward = REWARDS[reward]
        self.squares: Squares | None = None
        self._simulation = Simulation({"robots": self.robots, **spec, "steps_per_epoch": steps})
        self._done = steps
        self._next: Readings | None = None
        self._seen = np.zeros((self.robots, 8), np.float32)

    def reset(self, seed: int | None, draw: np.random.Generator) -> NDArray[np.float32]:
        """Begins an episode: the next epoch where one has just ended and no seed is given, else a
        run with that seed, or a drawn one."""
        at_end = self._next is not None and self._next.epoch_step == 0
        if seed is not None or not at_end:
            self._next = self._simulation.start(int(draw.integers(2**53)) if seed is None else seed)
        assert self._next is not None
        self._done = 0
        if self.squares is None:
            self.squares = Squares(self._next.size_m, self._next.squares)
        self.squares.reset(self._next.positions_m)
        self._seen = observe(self._next)
        return self._seen

    def step(self, commands: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[np.float64], bool]:
        """A step of all robots: what they read, rewards, whether the episode is over. After the
        last step robots are back at their starts: no reward, and what they read before it."""
        if self._done >= self.steps or self.squares is None:
            raise RuntimeError("the episode is over: reset first")
        self._next = self._simulation.step(np.clip(commands, -1.0, 1.0))
        self._done += 1
        if self._done == self.steps:
            return self._seen, np.zeros(self.robots), True
        self._seen = observe(self._next)
        return self._seen, self._reward(self.squares, self._next.positions_m), False

    @property
    def coverage(self) -> int:
        """Squares entered in this episode."""
        return 0 if self.squares is None else self.squares.coverage

    def close(self) -> None:
        """Ends the simulation."""
        self._next = None
        self._simulation.close()


def checked(seed: int | None) -> int | None:
    """A seed that a run can have."""
    if seed is None:
        return None
    number = operator.index(seed)
    if not 0 <= number <= MOST_SEED:
        raise ValueError(f"seed {number} (allowed: 0 to {MOST_SEED})")
    return number


def observe(readings: Readings) -> NDArray[np.float32]:
    """Sensors from 0 to 1, (robots, 8)."""
    seen: NDArray[np.float32] = readings.sensors / np.float32(HIGHEST)
    return np.clip(seen, 0.0, 1.0)
