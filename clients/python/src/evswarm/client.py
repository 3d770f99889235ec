"""A server: submit jobs, find jobs and runs, arenas and methods."""

from __future__ import annotations

import uuid
from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import Any

from evswarm.errors import EvswarmError
from evswarm.jobs import Job
from evswarm.runs import Run
from evswarm.transport import Transport


class Client:
    """A server, by default the one that ``EVSWARM_SERVER`` names, else the one of this machine.

    ``token`` is needed where the server has one; by default it is that of ``EVSWARM_TOKEN``.
    """

    def __init__(
        self, server: str | None = None, *, token: str | None = None, timeout_s: float = 60.0
    ):
        self._transport = Transport(server, token, timeout_s)

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Client({self.server!r})"

    @property
    def server(self) -> str:
        """Address of the server."""
        return self._transport.server

    def close(self) -> None:
        """Closes the connections."""
        self._transport.close()

    def submit(self, job: Mapping[str, Any], *, idempotency_key: str | None = None) -> Job:
        """Posts a job: ``base``, ``matrix`` and ``seeds``, or a ``template`` (see the README).

        The request carries a key, so that it may be sent again without making the job twice; name
        one of your own to make a whole script repeatable.

        :raises SpecRefused: with every wrong field.
        """
        key = idempotency_key or str(uuid.uuid4())
        answer = self._transport.request(
            "POST", "/v1/jobs", json=dict(job), headers={"idempotency-key": key}
        )
        return Job(self._transport, answer.json())

    def submit_run(self, spec: Mapping[str, Any], *, name: str = "") -> Job:
        """Posts a job of one run."""
        return self.submit({"name": name, "base": dict(spec)})

    def job(self, job_id: str | int) -> Job:
        """A job by its id.

        :raises NotFound: there is none.
        """
        return Job(self._transport, self._transport.json(f"/v1/jobs/{job_id}"))

    def jobs(self) -> Iterator[Job]:
        """Every job, newest first."""
        for document in self._transport.pages("/v1/jobs"):
            yield Job(self._transport, document)

    def run(self, run_id: str) -> Run:
        """A run by its id.

        :raises NotFound: there is none.
        """
        return Run(self._transport, self._transport.json(f"/v1/runs/{run_id}"))

    def controllers(self) -> dict[str, Any]:
        """Methods and presets, and each parameter with default, range, unit and source."""
        return dict(self._transport.json("/v1/controllers"))

    def templates(self) -> list[dict[str, Any]]:
        """Prepared jobs."""
        return list(self._transport.json("/v1/templates")["items"])

    def arenas(self) -> list[dict[str, Any]]:
        """The arenas that a spec may name."""
        return list(self._transport.json("/v1/arenas")["items"])

    def add_arena(self, arena: Mapping[str, Any]) -> dict[str, Any]:
        """Uploads an arena, to be named in specs.

        :raises SpecRefused: with every wrong field.
        :raises Conflict: another arena has its name.
        """
        return dict(self._transport.request("POST", "/v1/arenas", json=dict(arena)).json())

    def delete_arena(self, name: str) -> None:
        """Deletes an uploaded arena that no run uses."""
        self._transport.request("DELETE", f"/v1/arenas/{name}")

    def is_ready(self) -> bool:
        """Whether the server answers and its store does."""
        try:
            self._transport.request("GET", "/health/readyz")
        except EvswarmError:
            return False
        return True
