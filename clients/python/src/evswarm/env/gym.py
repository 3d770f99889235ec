"""A Gymnasium environment: one robot, or a swarm steered as one."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from evswarm.env.episodes import Episodes, checked


class SwarmEnv(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Robots of a spec. Observation: their proximity sensors from 0 to 1, (8,) or (robots, 8);
    action: wheel commands from -1 to 1, (2,) or (robots, 2); reward: the robots' sum."""

    metadata = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        spec: dict[str, Any] | None = None,
        steps: int = 2000,
        reward: str = "coverage",
    ) -> None:
        self._episodes = Episodes(spec or {}, steps, reward)
        robots = self._episodes.robots
        lead = () if robots == 1 else (robots,)
        self.observation_space = spaces.Box(0.0, 1.0, (*lead, 8), np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (*lead, 2), np.float32)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode; the same seed begins the same run."""
        seed = checked(seed)
        super().reset(seed=seed)
        seen = self._episodes.reset(seed, self.np_random)
        return seen.reshape(self.observation_space.shape or ()), self._info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """One control step. Episodes end by their length alone: ``truncated``."""
        commands = np.asarray(action, np.float32).reshape(-1, 2)
        seen, rewards, over = self._episodes.step(commands)
        seen = seen.reshape(self.observation_space.shape or ())
        return seen, float(rewards.sum()), False, over, self._info()

    def _info(self) -> dict[str, Any]:
        return {"coverage": self._episodes.coverage}

    def close(self) -> None:
        """Ends the simulation."""
        self._episodes.close()


def register() -> None:
    """Makes ``gymnasium.make("evswarm/Swarm-v0", spec=...)`` work."""
    if "evswarm/Swarm-v0" not in gymnasium.registry:
        gymnasium.register("evswarm/Swarm-v0", entry_point="evswarm.env.gym:SwarmEnv")
