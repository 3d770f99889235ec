"""One ``evswarm run`` whose robots are steered from here, an epoch an episode."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
import uuid
from pathlib import Path
from typing import Any

from evswarm.channels import ControllerPort, Question, Readings
from evswarm.channels.transport import ChannelError

_EPOCHS = 100_000
_START_S = 60.0


def program() -> str:
    """The program ``evswarm``: ``EVSWARM_PROGRAM``, or the one on the path."""
    found = os.environ.get("EVSWARM_PROGRAM") or shutil.which("evswarm")
    if not found:
        raise FileNotFoundError("evswarm is not on the path, and EVSWARM_PROGRAM is not set")
    return found


class Simulation:
    """A run of a spec that answers to ``step``.

    ``spec`` says only what differs from the defaults, as for ``evswarm run``; ``controller`` and
    ``seed`` are set here.
    """

    def __init__(self, spec: dict[str, Any], deadline_s: float = 600.0) -> None:
        self._spec = {
            **spec,
            "controller": {"method": "external", "deadline_ms": int(deadline_s * 1000)},
            "epochs": _EPOCHS,
        }
        self._process: subprocess.Popen[bytes] | None = None
        self._port: ControllerPort | None = None
        self._question: Question | None = None
        self._folder: str | None = None

    @property
    def is_running(self) -> bool:
        """Whether there is a run."""
        return self._question is not None

    @property
    def readings(self) -> Readings:
        """What robots read now."""
        if self._question is None:
            raise ChannelError("no run: reset first")
        return self._question.readings

    def start(self, seed: int) -> Readings:
        """Starts anew with a seed."""
        self.close()
        name = uuid.uuid4().hex
        self._folder = tempfile.mkdtemp(prefix="evswarm-")
        spec = Path(self._folder) / "spec.json"
        spec.write_text(json.dumps({**self._spec, "seed": seed}))
        self._port = ControllerPort(name)
        log = (Path(self._folder) / "log").open("wb")
        arguments = ["run", str(spec), "--out", f"{self._folder}/out", "--external-name", name]
        self._process = subprocess.Popen(
            [program(), *arguments], stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )
        log.close()
        return self._next(_START_S)

    def step(self, commands: Any) -> Readings:
        """Steers all robots by one step, (robots, 2), and gives what they read then. At the end of
        an epoch they are back at their starts."""
        if self._question is None:
            raise ChannelError("no run: reset first")
        question, self._question = self._question, None
        question.answer(commands)
        return self._next(_START_S)

    def _next(self, timeout_s: float) -> Readings:
        if self._port is None or self._process is None:
            raise ChannelError("no run: reset first")
        waited = 0.0
        while (question := self._port.question(0.5)) is None:
            waited += 0.5
            if self._process.poll() is not None or waited >= timeout_s:
                said = self._said()
                self.close()
                raise ChannelError(f"the run ended or is silent: {said}")
        self._question = question
        return question.readings

    def _said(self) -> str:
        if self._folder is None:
            return ""
        return (Path(self._folder) / "log").read_text(errors="replace")[-2000:]

    def close(self) -> None:
        """Ends the run; nothing is kept."""
        self._question = None
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None
        if self._port is not None:
            self._port.close()
            self._port = None
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None

    def __del__(self) -> None:
        self.close()
