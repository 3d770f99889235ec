"""A real server for the tests, on a free port, ended with them."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

import evswarm

REPOSITORY = Path(__file__).parents[3]


def program() -> Path:
    target = Path(os.environ.get("CARGO_TARGET_DIR") or REPOSITORY / "target")
    path = Path(os.environ.get("EVSWARM_PROGRAM") or target / "release" / "evswarm")
    assert path.is_file(), f"{path} is missing: run `make build` before"
    return path


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    home = tmp_path_factory.mktemp("server")
    environment = {**os.environ, "XDG_RUNTIME_DIR": str(home)}
    environment.pop("EVSWARM_TOKEN", None)
    with (home / "log").open("w") as log:
        process = subprocess.Popen(
            [program(), "serve", "--listen", "127.0.0.1:0", "--data", home / "data"],
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
            env=environment,
        )
    assert process.stdout is not None
    line = process.stdout.readline()
    assert "listens on" in line, (line, (home / "log").read_text())
    yield line.split()[-1].rstrip("/")
    process.terminate()
    assert process.wait(timeout=30) == 0


@pytest.fixture
def client(server: str) -> Iterator[evswarm.Client]:
    with evswarm.Client(server) as client:
        yield client
