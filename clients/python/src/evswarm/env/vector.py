"""A Gymnasium vector environment: every robot of a tiled arena is an environment of its own, and
all are steered by one question a step."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from evswarm.env.episodes import Episodes, checked


class SwarmVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """A robot in each of ``num_envs`` copies of an arena, with doorways too narrow for it."""

    metadata = {"autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        arena: Any = "easy",
        num_envs: int = 16,
        steps: int = 2000,
        reward: str = "coverage",
        **spec: Any,
    ) -> None:
        columns = int(np.ceil(np.sqrt(num_envs)))
        rows = int(np.ceil(num_envs / columns))
        # As many robots as tiles: each tile has the starts of the arena.
        if columns * rows != num_envs:
            raise ValueError(f"num_envs {num_envs} (allowed: columns x rows, as 16 or 20)")
        tiled = {"from": arena, "tile": [columns, rows], "doorway_m": 0.001}
        whole = {"placement": "start", **spec, "arena": tiled, "robots": num_envs}
        self._episodes = Episodes(whole, steps, reward)
        self.num_envs = num_envs
        self.single_observation_space = spaces.Box(0.0, 1.0, (8,), np.float32)
        self.single_action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._over = False

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode in all; one seed is all that a run has: the first of a list."""
        first = checked(seed[0] if isinstance(seed, list) else seed)
        super().reset(seed=first)
        self._over = False
        return self._episodes.reset(first, self.np_random), {}

    def step(
        self, actions: NDArray[np.float32]
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """A step of all; the one after the last of an episode begins the next, and does nothing."""
        never = np.zeros(self.num_envs, bool)
        if self._over:
            self._over = False
            seen = self._episodes.reset(None, self.np_random)
            return seen, np.zeros(self.num_envs), never, never.copy(), {}
        seen, rewards, self._over = self._episodes.step(np.asarray(actions, np.float32))
        return seen, rewards, never, np.full(self.num_envs, self._over), {}

    def close_extras(self, **_: Any) -> None:
        """Ends the simulation."""
        self._episodes.close()
