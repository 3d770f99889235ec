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


def vmas(worlds: int, agents: int) -> Callable[[], Any]:
    """So many worlds of VMAS with so many agents each, which have a lidar: scenario navigation."""
    import torch
    from vmas import make_env

    torch.set_num_threads(1)
    side = max(1.0, 0.35 * agents**0.5)
    sides = {"world_spawning_x": side, "world_spawning_y": side}
    env = make_env(
        "navigation", num_envs=worlds, n_agents=agents, device="cpu", max_steps=None, **sides
    )
    env.reset()
    actions = [torch.rand((worlds, 2)) * 2 - 1 for _ in range(agents)]
    return lambda: env.step(actions)


def plain(robots: int) -> Callable[[], Any]:
    """As many environments of Gymnasium (Pendulum) in a loop."""
    env = gymnasium.make_vec("Pendulum-v1", num_envs=robots, vectorization_mode="sync")
    env.reset(seed=1)
    actions = np.random.default_rng(1).uniform(-2, 2, (robots, 1)).astype(np.float32)
    return lambda: env.step(actions)


WAYS: dict[str, tuple[Callable[[int], Callable[[], Any]], int]] = {
    "evswarm, robots in one arena": (evswarm, 10_000),
    "VMAS, agents in one world": (lambda robots: vmas(1, robots), 100),
    "VMAS, a world for each agent": (lambda robots: vmas(robots, 1), 10_000),
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
