"""A run: its state, and what it found, also while it is under way."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import httpx
import numpy as np
from numpy.typing import NDArray

from evswarm import frames
from evswarm.transport import Transport

if TYPE_CHECKING:
    import pandas
    import polars


class Run:
    """A run as it was when it was last asked for; :meth:`refresh` asks again."""

    def __init__(self, transport: Transport, document: dict[str, Any]):
        self._transport = transport
        self.document = document
        """The run as the server shows it."""

    def __repr__(self) -> str:
        what = [self.id[:12], self.method, self.arena, f"seed {self.seed}", self.label, self.state]
        return f"Run({', '.join(filter(None, what))})"

    @property
    def id(self) -> str:
        """Its id."""
        return str(self.document["id"])

    @property
    def job_id(self) -> str:
        """The job that it belongs to."""
        return str(self.document["job_id"])

    @property
    def seed(self) -> int:
        """Seed of its random numbers."""
        return int(self.document["seed"])

    @property
    def arena(self) -> str:
        """Name of its target arena."""
        return str(self.document["arena"])

    @property
    def method(self) -> str:
        """Name of its method."""
        return str(self.document["method"])

    @property
    def label(self) -> str:
        """What of the job's matrix it has, in words."""
        return str(self.document.get("label") or "")

    @property
    def state(self) -> str:
        """``queued``, ``running``, ``paused``, ``done``, ``failed`` or ``cancelled``."""
        return str(self.document["state"])

    @property
    def error(self) -> str | None:
        """Why it failed."""
        return self.document.get("error")

    def refresh(self) -> Run:
        """Asks the server again."""
        self.document = self._transport.json(self._path())
        return self

    def spec(self) -> dict[str, Any]:
        """Its spec, every default filled in."""
        return dict(self._get("spec").json())

    def result(self) -> dict[str, Any]:
        """What it found in the end.

        :raises Conflict: it is not done.
        """
        return dict(self._get("result").json())

    def curve(self, *, points: int | None = None) -> list[dict[str, int]]:
        """Coverage after each epoch; with ``points``, that many rows at most, evenly spread."""
        params = None if points is None else {"points": points}
        return list(self._transport.json(f"{self._path()}/curve", params))

    def curve_pandas(self) -> pandas.DataFrame:
        """:meth:`curve` for pandas."""
        return frames.to_pandas(self.curve())

    def curve_polars(self) -> polars.DataFrame:
        """:meth:`curve` for polars."""
        return frames.to_polars(self.curve())

    def metrics_pandas(self) -> pandas.DataFrame:
        """Swarm metrics over time, for pandas."""
        return frames.parquet_pandas(self._get("metrics.parquet").content)

    def metrics_polars(self) -> polars.DataFrame:
        """Swarm metrics over time, for polars."""
        return frames.parquet_polars(self._get("metrics.parquet").content)

    def robots_pandas(self) -> pandas.DataFrame:
        """What each robot did, for pandas."""
        return frames.csv_pandas(self._get("robots.csv").text)

    def visits(self) -> NDArray[np.uint32]:
        """Entries counted a square; row 0 is the lowest y."""
        return self._array("coverage.npy")

    def dwell(self) -> NDArray[np.uint32]:
        """Steps spent a square; row 0 is the lowest y."""
        return self._array("dwell.npy")

    def coverage_png(self) -> bytes:
        """The visits over the arena's walls, as a picture."""
        return self._get("coverage.png").content

    def coverage_svg(self) -> str:
        """The same as a drawing."""
        return self._get("coverage.svg").text

    def recording(self, name: str = "live", *, form: str | None = None) -> bytes:
        """A recording as its file, or as ``csv``, ``parquet`` or ``mcap``; ``live`` is the one
        that the run made of itself, the others have numbers."""
        end = "" if form is None else f".{form}"
        return self._get(f"recordings/{name}{end}").content

    def recording_slice(self, name: str = "live", **query: Any) -> dict[str, Any]:
        """A slice of a recording: ``from_step``, ``steps``, ``every``, ``robots="0,3"``."""
        path = f"{self._path()}/recordings/{name}.json"
        return dict(self._transport.json(path, query))

    def cancel(self) -> Run:
        """Stops it for good, in every job that has it."""
        self.document = self._transport.request("POST", f"{self._path()}/cancel").json()
        return self

    def row(self) -> dict[str, Any]:
        """What identifies it and its result; names of nested fields are joined by dots."""
        own = {
            "run": self.id,
            "job": self.job_id,
            "index": int(self.document["index"]),
            "seed": self.seed,
            "arena": self.arena,
            "method": self.method,
            "label": self.label,
            "state": self.state,
        }
        result = self.document.get("result") or {}
        return {**own, **dict(_flat(result, ""))}

    def _array(self, name: str) -> NDArray[np.uint32]:
        array: NDArray[np.uint32] = np.load(io.BytesIO(self._get(name).content), allow_pickle=False)
        return array

    def _get(self, what: str) -> httpx.Response:
        return self._transport.get(f"{self._path()}/{what}")

    def _path(self) -> str:
        return f"/v1/runs/{self.id}"


def _flat(document: Mapping[str, Any], before: str) -> Any:
    """Scalars of a nested document with their dotted names; lists are left out."""
    for name, value in document.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{before}{name}.")
        elif not isinstance(value, list):
            yield f"{before}{name}", value
