"""Frames and controllers in this process, and environments on top of them."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import ArrayLike
from pettingzoo.test import parallel_api_test, parallel_seed_test

from conftest import program
from evswarm.channels import ChannelError, Controller, ControllerPort, FrameReader, Readings, steer
from evswarm.env import SwarmEnv, SwarmParallelEnv, SwarmVectorEnv, register

WEIGHTS = np.array(
    [
        [0.942, -0.22],
        [0.63, -0.1],
        [0.5, -0.06],
        [-0.06, -0.06],
        [-0.06, -0.06],
        [-0.06, 0.5],
        [-0.19, 0.63],
        [-0.13, 0.942],
    ],
    dtype=np.float32,
)


class Braitenberg(Controller):
    """The vehicle that is built in as ``braitenberg``, for all robots at once."""

    def act(self, readings: Readings) -> ArrayLike:
        total = np.zeros((len(readings.sensors), 2), np.float32)
        for sensor, weights in enumerate(WEIGHTS):
            part = np.float32(1) - readings.sensors[:, sensor] / np.float32(512)
            total += weights * part[:, None]
        return np.clip(np.float32(0.5) * total, -1, 1)


@pytest.fixture(autouse=True)
def home(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    # A short path: the transport's sockets lie below it.
    with tempfile.TemporaryDirectory(prefix="ev") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        monkeypatch.setenv("EVSWARM_PROGRAM", str(program()))
        yield Path(folder)


def spec(method: dict[str, object]) -> str:
    whole = {
        "arena": "maze",
        "robots": 3,
        "placement": "random",
        "epochs": 3,
        "steps_per_epoch": 200,
        "controller": method,
        "channels": True,
    }
    return json.dumps(whole)


def start(home: Path, method: dict[str, object], name: str) -> subprocess.Popen[bytes]:
    (home / f"{name}.json").write_text(spec(method))
    arguments = ["run", f"{home}/{name}.json", "--out", f"{home}/{name}", "--external-name", name]
    with (home / f"{name}.log").open("w") as log:
        return subprocess.Popen([program(), *arguments], stderr=log, env=os.environ)


def test_a_controller_in_python_gives_the_bits_of_the_one_built_in(home: Path) -> None:
    assert start(home, {"method": "braitenberg"}, "built-in").wait(60) == 0
    run = start(home, {"method": "external", "deadline_ms": 60_000}, "outside")
    # One that is killed in the middle, and another that goes on.
    with ControllerPort("outside") as port:
        for _ in range(200):
            question = port.question(30)
            assert question is not None
            assert not question.readings.robots.flags.writeable
            question.answer(Braitenberg().act(question.readings))
    assert steer("outside", Braitenberg(), idle_s=3) == 400
    assert run.wait(60) == 0
    for file in ["curve.csv", "metrics.csv", "visits.npy"]:
        assert (home / "built-in" / file).read_bytes() == (home / "outside" / file).read_bytes()


@pytest.mark.parametrize(
    ("part", "missing"), [("channels", "iceoryx2"), ("env", "gymnasium"), ("env", "pettingzoo")]
)
def test_what_has_to_be_installed_is_named(part: str, missing: str) -> None:
    code = f"import sys; sys.modules[{missing!r}] = None; import evswarm.{part}"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ended.returncode == 1
    assert f"needs {missing}: pip install 'evswarm[{part}]'" in ended.stderr


def test_wrong_commands_are_refused_before_they_are_sent(home: Path) -> None:
    run = start(home, {"method": "external", "deadline_ms": 60_000}, "wrong")
    with ControllerPort("wrong") as port:
        question = port.question(30)
        assert question is not None
        with pytest.raises(ValueError, match=r"allowed: \(3, 2\)"):
            question.answer([[0.0, 0.0]])
        question.answer(np.full((3, 2), np.nan))
        assert run.wait(60) == 1


def test_frames_are_seen_without_copying(home: Path) -> None:
    run = start(home, {"method": "external", "deadline_ms": 60_000}, "outside")
    with ControllerPort("outside") as port:
        question = port.question(30)
        assert question is not None
        found = re.search(r"swarm/([0-9a-f]+)/frames", (home / "outside.log").read_text())
        assert found is not None
        with FrameReader(found[1]) as reader:
            frame, moments = None, {}
            while frame is None or frame.arena_step < 2:
                question.answer(Braitenberg().act(question.readings))
                question = port.question(30)
                assert question is not None, "a frame came before the end"
                moments[question.readings.arena_step] = question.readings.positions_m.copy()
                frame = reader.read() or frame
            assert len(frame.robots) == 3 and not frame.robots.flags.owndata
            with pytest.raises(ValueError):
                frame.robots["x_m"][0] = 1.0
            assert np.array_equal(frame.positions_m, moments[frame.arena_step])
            assert frame.phase == "exploration"
    run.kill()
    run.wait()
    with pytest.raises(ChannelError, match="frames of the run"):
        FrameReader("no-such-run")


@pytest.mark.parametrize("environment", [SwarmEnv, SwarmVectorEnv, SwarmParallelEnv])
def test_a_seed_that_no_run_can_have_is_named(environment: Any) -> None:
    env = environment()
    for seed in (2**70, 2**53, -1):
        with pytest.raises(ValueError, match=rf"seed {seed} \(allowed: 0 to {2**53 - 1}\)"):
            env.reset(seed=seed)
    env.reset(seed=2**53 - 1)
    env.close()


def test_a_robot_is_an_environment_that_gymnasium_accepts() -> None:
    register()
    env = gymnasium.make("evswarm/Swarm-v0", spec={"arena": "easy"}, steps=50)
    check_env(env.unwrapped, skip_render_check=True)
    first, _ = env.reset(seed=3)
    seen = [env.step(np.array([0.8, 0.9], np.float32)) for _ in range(50)]
    assert seen[-1][3] and not seen[-2][3], "episodes end by their length"
    assert seen[-2][4]["coverage"] > 5
    assert sum(reward for _, reward, *_ in seen) == seen[-1][4]["coverage"] - 1
    again, _ = env.reset(seed=3)
    assert np.array_equal(first, again)
    env.close()


def test_a_swarm_is_an_environment_that_pettingzoo_accepts() -> None:
    env = SwarmParallelEnv({"arena": {"from": "easy", "tile": [2, 2]}}, steps=30)
    parallel_api_test(env, num_cycles=70)
    env.close()
    parallel_seed_test(lambda: SwarmParallelEnv({"arena": "easy"}, steps=20), num_cycles=20)


def test_tiles_are_environments_of_their_own() -> None:
    env = SwarmVectorEnv("easy", num_envs=6, steps=40)
    seen, _ = env.reset(seed=1)
    assert seen.shape == (6, 8)
    total = np.zeros(6)
    for _ in range(41):
        _, rewards, _, truncated, _ = env.step(np.full((6, 2), 0.7, np.float32))
        total += rewards
    assert (total > 3).all() and not truncated.any()
    env.close()
