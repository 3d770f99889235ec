"""A robot learns to cover rooms by proximal policy optimisation (PPO of stable-baselines3), from
its eight proximity sensors and what it remembers of its own wheel commands, and is compared with
the built-in Levy walk in rooms that it never saw.

    pip install 'clients/python[env]' stable-baselines3
    python clients/python/examples/learn_to_cover.py --minutes 10 --seed 1 --out learnt
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from evswarm.env import SwarmEnv, SwarmVectorEnv
from evswarm.env.simulation import program

STEPS = 2000
"""Steps of an episode, as of the thesis's epochs."""
HOLD = 5
"""Steps that a decision holds."""
TRAINING_ROOMS = (11, 12, 13, 14)
TEST_ROOMS = (1, 2, 3)
TEST_SEEDS = 10

# A robot whose wheels do not slip, so that it can reckon where it is.
ROBOT = {"preset": "stepwise"}
# Of it: radius of its wheels, distance between them, top speed and acceleration, control step.
WHEEL_M, AXLE_M, TOP_RAD_S, ACCELERATION_RAD_S2, STEP_S = 0.0205, 0.052, 6.28, 10.0, 0.064

CELL_M = 0.012
"""Side of a cell of the robot's memory, which is 3.07 m wide and wraps around."""
CELLS = 256
BEARINGS = np.arange(12) * (2 * np.pi / 12)
REACHES_M = np.array([0.03, 0.06, 0.10, 0.16])


def rooms(seed: int) -> dict[str, Any]:
    generate = {"kind": "rooms", "seed": seed}
    return {"name": f"rooms-{seed}", "width_m": 0.6, "height_m": 0.6, "generate": generate}


class Memory:
    """What robots know of their way by their own commands (no pose is told): where they believe to
    be, and how often they were in the cells around."""

    size = 8 + 2 + len(BEARINGS) * len(REACHES_M) + 1

    def __init__(self, robots: int) -> None:
        self.robots = robots
        self.all = np.arange(robots)
        self.reset()

    def reset(self) -> None:
        self.at_m = np.zeros((self.robots, 2))
        self.heading = np.zeros(self.robots)
        self.speed = np.zeros((self.robots, 2))
        self.visits = np.zeros((self.robots, CELLS, CELLS), np.float32)
        self.last = np.zeros((self.robots, 2))
        self.steps = 0

    def move(self, commands: NDArray[Any]) -> None:
        """A step by these commands, as wheels follow them."""
        limit = ACCELERATION_RAD_S2 * STEP_S
        self.speed += np.clip(commands * TOP_RAD_S - self.speed, -limit, limit)
        left, right = self.speed[:, 0], self.speed[:, 1]
        turn = WHEEL_M * STEP_S * (right - left) / AXLE_M
        way = WHEEL_M * STEP_S * (left + right) / 2
        middle = self.heading + turn / 2
        self.at_m += way[:, None] * np.stack([np.cos(middle), np.sin(middle)], axis=1)
        self.heading += turn
        cell = self.cells(self.at_m)
        self.visits[self.all, cell[:, 0], cell[:, 1]] += 1
        self.steps += 1

    @staticmethod
    def cells(at_m: NDArray[Any]) -> NDArray[np.int64]:
        return np.floor(at_m / CELL_M).astype(np.int64) % CELLS

    def observe(self, sensors: NDArray[Any]) -> NDArray[np.float32]:
        """Sensors, the last decision, and how new the cells around are, by bearing and reach."""
        angle = self.heading[:, None] + BEARINGS
        ahead = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        around = self.at_m[:, None, None, :] + ahead[:, :, None, :] * REACHES_M[:, None]
        cell = self.cells(around)
        seen = self.visits[self.all[:, None, None], cell[..., 0], cell[..., 1]]
        known = np.minimum(seen / 10.0, 1.0).reshape(self.robots, -1)
        left = np.full((self.robots, 1), 1.0 - self.steps / STEPS)
        return np.concatenate([np.sqrt(sensors), self.last, known, left], axis=1, dtype=np.float32)


def wheels(actions: NDArray[Any]) -> NDArray[np.float32]:
    """Forward speed and turn to wheel commands."""
    ahead, turn = 0.5 + 0.5 * actions[:, 0], 0.6 * actions[:, 1]
    return np.clip(np.stack([ahead - turn, ahead + turn], axis=1), -1, 1).astype(np.float32)


class Rooms(VecEnv):  # type: ignore[misc]
    """Robots in tiles of several rooms as one vector environment of stable-baselines3."""

    def __init__(self, seeds: tuple[int, ...], robots: int) -> None:
        each = robots // len(seeds)
        self.worlds = [SwarmVectorEnv(rooms(seed), each, STEPS, robot=ROBOT) for seed in seeds]
        self.memories = [Memory(each) for _ in seeds]
        seen = gymnasium.spaces.Box(-1.0, 1.0, (Memory.size,), np.float32)
        acts = gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
        super().__init__(each * len(seeds), seen, acts)
        self.seed_of_worlds = 0
        self.returns = np.zeros(self.num_envs)

    def reset(self) -> NDArray[np.float32]:
        seen = []
        for world, memory in zip(self.worlds, self.memories, strict=True):
            self.seed_of_worlds += 1
            sensors, _ = world.reset(seed=self.seed_of_worlds)
            memory.reset()
            seen.append(memory.observe(sensors))
        self.returns[:] = 0
        return np.concatenate(seen)

    def step_async(self, actions: NDArray[Any]) -> None:
        self.actions = actions

    def step_wait(self) -> Any:
        seen, rewards, overs, last = [], [], [], []
        each = self.num_envs // len(self.worlds)
        for number, (world, memory) in enumerate(zip(self.worlds, self.memories, strict=True)):
            acts = np.clip(self.actions[number * each : (number + 1) * each], -1, 1)
            commands, reward = wheels(acts), np.zeros(each)
            for _ in range(HOLD):
                sensors, new, _, truncated, _ = world.step(commands)
                memory.move(commands)
                reward += new
                if truncated.any():
                    break
            memory.last = acts
            now = memory.observe(sensors)
            last.append(now)
            if truncated.any():
                sensors, *_ = world.step(commands)  # begins the next episode
                memory.reset()
                now = memory.observe(sensors)
            seen.append(now)
            rewards.append(reward)
            overs.append(truncated)
        over = np.concatenate(overs)
        reward = np.concatenate(rewards)
        self.returns += reward
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for number in np.flatnonzero(over):
            infos[number] = {
                "TimeLimit.truncated": True,
                "terminal_observation": np.concatenate(last)[number],
                "episode": {"r": float(self.returns[number]) + 1, "l": STEPS, "t": 0.0},
            }
        self.returns[over] = 0
        return np.concatenate(seen), reward.astype(np.float32), over, infos

    def close(self) -> None:
        for world in self.worlds:
            world.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kw: Any) -> list[Any]:
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * self.num_envs


class Curve(BaseCallback):  # type: ignore[misc]
    """Ends training after so many minutes of this process on a processor, which are those of the
    clock where nothing else runs, and notes what episodes covered."""

    def __init__(self, minutes: float, path: Path) -> None:
        super().__init__()
        self.cpu_s, self.path = minutes * 60, path
        self.rows: list[list[float]] = []
        self.begun, self.cpu = time.monotonic(), time.process_time()

    def _on_step(self) -> bool:
        covered = [info["episode"]["r"] for info in self.locals["infos"] if "episode" in info]
        if covered:
            wall_s, cpu_s = time.monotonic() - self.begun, time.process_time() - self.cpu
            row = [round(wall_s, 1), round(cpu_s, 1), self.num_timesteps * HOLD]
            self.rows.append([*row, round(float(np.mean(covered)), 1)])
            with self.path.open("w", newline="") as file:
                writer = csv.writer(file)
                writer.writerow(["wall_s", "learner_cpu_s", "robot_steps", "covered"])
                writer.writerows(self.rows)
            print(self.rows[-1], flush=True)
        return time.process_time() - self.cpu < self.cpu_s


def learnt(model: PPO, arena: dict[str, Any], seed: int) -> int:
    """Squares that the policy covers in an episode of one robot."""
    env = SwarmEnv({"arena": arena, "robot": ROBOT}, STEPS)
    torch.manual_seed(seed)
    seen, info = env.reset(seed=seed)
    memory, commands = Memory(1), np.zeros((1, 2), np.float32)
    for step in range(STEPS):
        if step % HOLD == 0:
            acts, _ = model.predict(memory.observe(seen[None]), deterministic=False)
            acts = np.clip(acts, -1, 1)
            commands, memory.last = wheels(acts), acts
        seen, _, _, _, info = env.step(commands[0])
        memory.move(commands)
    env.close()
    return int(info["coverage"])


def levy(arena: dict[str, Any], seed: int) -> int:
    """Squares that the built-in Levy walk covers in as many steps."""
    spec = {
        "arena": arena,
        "robot": ROBOT,
        "controller": {"method": "levy"},
        "epochs": 1,
        "steps_per_epoch": STEPS,
        "seed": seed,
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "spec.json"
        path.write_text(json.dumps(spec))
        out = f"{folder}/out"
        subprocess.run([program(), "run", path, "--out", out], check=True, capture_output=True)
        return int(json.loads(Path(out, "result.json").read_text())["p1"])


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--minutes", type=float, default=10.0, help="of this process's processor")
    options.add_argument("--robots", type=int, default=48)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--threads", type=int, default=1)
    options.add_argument("--out", type=Path, default=Path("learnt"))
    given = options.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(given.threads)

    world = Rooms(TRAINING_ROOMS, given.robots)
    model = PPO(
        "MlpPolicy",
        world,
        n_steps=100,
        batch_size=1200,
        n_epochs=6,
        gamma=0.98,
        gae_lambda=0.95,
        learning_rate=7e-4,
        ent_coef=0.002,
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -0.5},
        seed=given.seed,
        device="cpu",
    )
    model.learn(10**9, callback=Curve(given.minutes, given.out / "curve.csv"))
    world.close()
    model.save(given.out / "policy.zip")

    with (given.out / "test.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["rooms", "seed", "learnt", "levy"])
        for number in TEST_ROOMS:
            pairs = []
            for seed in range(1, TEST_SEEDS + 1):
                pairs.append((learnt(model, rooms(number), seed), levy(rooms(number), seed)))
                writer.writerow([f"rooms-{number}", seed, *pairs[-1]])
            (a, b), (sa, sb) = np.mean(pairs, axis=0), np.std(pairs, axis=0, ddof=1)
            print(f"rooms-{number}: learnt {a:.0f} +- {sa:.0f}, Levy {b:.0f} +- {sb:.0f}")


if __name__ == "__main__":
    main()
