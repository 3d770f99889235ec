"""A PettingZoo parallel environment: every robot is an agent."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from evswarm.env.episodes import Episodes, checked


class SwarmParallelEnv(ParallelEnv[str, NDArray[np.float32], NDArray[np.float32]]):
    """Robots of a spec, agents ``robot_0`` and on. Observation: proximity sensors from 0 to 1,
    (8,); action: wheel commands from -1 to 1, (2,)."""

    metadata = {"name": "evswarm_v0", "render_modes": [], "is_parallelizable": True}  # noqa: RUF012

    def __init__(
        self,
        spec: dict[str, Any] | None = None,
        steps: int = 2000,
        reward: str = "coverage",
    ) -> None:
        self._episodes = Episodes({"robots": 4, "placement": "grid", **(spec or {})}, steps, reward)
        self.possible_agents = [f"robot_{number}" for number in range(self._episodes.robots)]
        self.agents: list[str] = []
        self._observation = spaces.Box(0.0, 1.0, (8,), np.float32)
        self._action = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self._draw = np.random.default_rng()
        self.render_mode = None

    def observation_space(self, agent: str) -> spaces.Space[NDArray[np.float32]]:
        """The same for all robots."""
        return self._observation

    def action_space(self, agent: str) -> spaces.Space[NDArray[np.float32]]:
        """The same for all robots."""
        return self._action

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Begins an episode; the same seed begins the same run."""
        seed = checked(seed)
        if seed is not None:
            self._draw = np.random.default_rng(seed)
        self.agents = self.possible_agents[:]
        return self._by_agent(self._episodes.reset(seed, self._draw)), self._infos()

    def step(
        self, actions: dict[str, NDArray[np.float32]]
    ) -> tuple[
        dict[str, NDArray[np.float32]],
        dict[str, float],
        dict[str, bool],
        dict[str, bool],
        dict[str, dict[str, Any]],
    ]:
        """A step of all robots; those without an action stand still."""
        commands = np.zeros((len(self.possible_agents), 2), np.float32)
        for number, agent in enumerate(self.possible_agents):
            if agent in actions:
                commands[number] = actions[agent]
        seen, rewards, over = self._episodes.step(commands)
        infos = self._infos()
        result = (
            self._by_agent(seen),
            dict(zip(self.agents, rewards.tolist(), strict=True)),
            dict.fromkeys(self.agents, False),
            dict.fromkeys(self.agents, over),
            infos,
        )
        if over:
            self.agents = []
        return result

    def _by_agent(self, seen: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
        return dict(zip(self.agents, seen, strict=True))

    def _infos(self) -> dict[str, dict[str, Any]]:
        return {agent: {"coverage": self._episodes.coverage} for agent in self.agents}

    def close(self) -> None:
        """Ends the simulation."""
        self._episodes.close()
