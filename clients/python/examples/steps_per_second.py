"""Robot-steps a second through the Python environment, beside VMAS and a plain loop over Gymnasium
environments with as many robots. All of it on one core:

    pip install 'clients/python[env]' vmas
    taskset -c 0 python clients/python/examples/steps_per_second.py
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

from evswarm.env import SwarmEnv

STEPS = 500
"""Steps of an episode."""


def evswarm(robots: int) -> Callable[[], Any]:
    """Robots with eight proximity sensors in one arena, which meet each other and walls."""
    side = max(1, int(np.ceil(np.sqrt(robots / 16))))
    arena = {"from": "easy", "tile": [side, side], "squares": 20}
    placement = "start" if robots == 1 else "grid"
    env = SwarmEnv({"arena": arena, "robots": robots, "placement": placement}, STEPS)
    env.reset(seed=1)
    actions = np.random.default_rng(1).uniform(-1, 1, (64, robots, 2)).astype(np.float32)
    done = 0

    def step() -> None:
        nonlocal done
        _, _, _, over, _ = env.step(actions[done % 64])
        done += 1
        if over:
            env.reset()

    return step


def vmas(scenario: str, **more: Any) -> Callable[[int], Callable[[], Any]]:
    """Agents of a scenario of VMAS in one environment."""

    def made(robots: int) -> Callable[[], Any]:
        import torch
        from vmas import make_env

        torch.set_num_threads(1)
        env = make_env(scenario, num_envs=1, n_agents=robots, device="cpu", max_steps=None, **more)
        env.reset()
        draw = torch.Generator().manual_seed(1)
        actions = [torch.rand((1, 2), generator=draw) * 2 - 1 for _ in range(robots)]
        return lambda: env.step(actions)

    return made


def vmas_environments(robots: int) -> Callable[[], Any]:
    """As many environments of VMAS with an agent each, in one tensor: what it is made for."""
    import torch
    from vmas import make_env

    torch.set_num_threads(1)
    env = make_env("navigation", num_envs=robots, n_agents=1, device="cpu", max_steps=None)
    env.reset()
    actions = [torch.rand((robots, 2)) * 2 - 1]
    return lambda: env.step(actions)


def plain(robots: int) -> Callable[[], Any]:
    """As many environments of Gymnasium (Pendulum) in a loop."""
    env = gymnasium.make_vec("Pendulum-v1", num_envs=robots, vectorization_mode="sync")
    env.reset(seed=1)
    actions = np.random.default_rng(1).uniform(-2, 2, (robots, 1)).astype(np.float32)
    return lambda: env.step(actions)


WAYS: dict[str, tuple[Callable[[int], Callable[[], Any]], int]] = {
    "evswarm, robots in one arena": (evswarm, 10_000),
    "VMAS navigation, agents in one world, lidar": (vmas("navigation"), 100),
    "VMAS, environments with one agent each, lidar": (vmas_environments, 10_000),
    "Gymnasium loop, Pendulum": (plain, 10_000),
}
"""Ways, and the most robots that each is tried with."""


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--robots", type=int, nargs="*", default=[1, 10, 100, 1000])
    options.add_argument("--seconds", type=float, default=5.0)
    given = options.parse_args()
    cells = " | ".join(f"{robots} robots" for robots in given.robots)
    print(f"| Robot-steps a second | {cells} |\n|---|{'---|' * len(given.robots)}")
    for name, (make, most) in WAYS.items():
        row = []
        for robots in given.robots:
            if robots > most:
                row.append("")
                continue
            step = make(robots)
            for _ in range(3):
                step()
            steps, since = 0, time.perf_counter()
            while time.perf_counter() - since < given.seconds:
                step()
                steps += 1
            row.append(f"{steps * robots / (time.perf_counter() - since):,.0f}")
        print(f"| {name} | {' | '.join(row)} |", flush=True)
    print(f"\n{given.seconds} s each; load average {os.getloadavg()[0]:.1f}, this included")


if __name__ == "__main__":
    main()
