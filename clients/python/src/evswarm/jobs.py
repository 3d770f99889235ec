"""A job: its state, waiting for it, and what its runs found."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from evswarm import frames
from evswarm.errors import JobFailed, WaitTimeout
from evswarm.runs import Run
from evswarm.transport import Transport

if TYPE_CHECKING:
    import pandas
    import polars

FINAL = frozenset({"done", "failed", "cancelled"})
"""States from which nothing more happens by itself."""
POLL_S = (0.2, 5.0)
"""First and longest time between two looks at a job."""


class Job:
    """A job as it was when it was last asked for; :meth:`refresh` asks again."""

    def __init__(self, transport: Transport, document: dict[str, Any]):
        self._transport = transport
        self.document = document
        """The job as the server shows it."""

    def __repr__(self) -> str:
        return f"Job({self.id}, {self.name!r}, {self.state}, {self.progress:.0%})"

    @property
    def id(self) -> str:
        """Its id."""
        return str(self.document["id"])

    @property
    def name(self) -> str:
        """The name that it was given."""
        return str(self.document["name"])

    @property
    def state(self) -> str:
        """``queued``, ``running``, ``paused``, ``done``, ``failed`` or ``cancelled``."""
        return str(self.document["state"])

    @property
    def progress(self) -> float:
        """Share of its work that is done, 0 to 1."""
        return float(self.document["progress"])

    @property
    def eta_s(self) -> float | None:
        """Seconds left, as far as that is known."""
        eta_s = self.document.get("eta_s")
        return None if eta_s is None else float(eta_s)

    @property
    def counts(self) -> dict[str, int]:
        """Its runs by state, and ``total``."""
        return dict(self.document["runs"])

    def refresh(self) -> Job:
        """Asks the server again."""
        self.document = self._transport.json(self._path())
        return self

    def wait(
        self,
        *,
        timeout_s: float | None = None,
        progress: bool | Callable[[Job], None] = False,
        check: bool = True,
    ) -> Job:
        """Returns when nothing more happens by itself.

        ``progress`` shows a bar (with ``tqdm`` if that is installed, else lines), or is called with
        the job after each look. With ``check`` a job with failed runs raises.

        :raises JobFailed: runs of it failed.
        :raises WaitTimeout: it takes longer than ``timeout_s``; it goes on.
        """
        give_up = math.inf if timeout_s is None else time.monotonic() + timeout_s
        show = _meter(progress)
        pause_s = POLL_S[0]
        try:
            while True:
                self.refresh()
                show(self)
                if self.state in FINAL:
                    break
                left_s = give_up - time.monotonic()
                if left_s <= 0:
                    raise WaitTimeout(f"job {self.id} is {self.state} at {self.progress:.0%}")
                time.sleep(min(pause_s, left_s))
                pause_s = min(pause_s * 1.5, POLL_S[1])
        finally:
            close = getattr(show, "close", None)
            if close is not None:
                close()
        if check and self.state == "failed":
            raise JobFailed(self._why())
        return self

    def runs(self) -> Iterator[Run]:
        """Its runs, in order of their places in the job."""
        for document in self._transport.pages(f"{self._path()}/runs"):
            yield Run(self._transport, document)

    def summary(self) -> dict[str, Any]:
        """What it found, seeds pooled, with intervals."""
        return dict(self._transport.json(f"{self._path()}/summary"))

    def table(self) -> list[dict[str, Any]]:
        """A row for each run: seed, arena, method, what it has of the matrix, state and results."""
        return [run.row() for run in self.runs()]

    def runs_csv(self) -> str:
        """A line for each run, as the server's table ``runs`` has it."""
        return self._transport.get(f"{self._path()}/runs.csv").text

    def parquet(self, table: str) -> bytes:
        """A Parquet file: ``runs``, ``curves`` or ``metrics``; columns do not depend on the job."""
        return self._transport.get(f"{self._path()}/{table}.parquet").content

    def to_pandas(self) -> pandas.DataFrame:
        """A row for each run: every field of its spec under its dotted path, and its results."""
        return frames.parquet_pandas(self.parquet("runs"))

    def to_polars(self) -> polars.DataFrame:
        """:meth:`to_pandas` for polars."""
        return frames.parquet_polars(self.parquet("runs"))

    def curves_pandas(self) -> pandas.DataFrame:
        """Coverage after each epoch of its finished runs, for pandas."""
        return frames.parquet_pandas(self.parquet("curves"))

    def curves_polars(self) -> polars.DataFrame:
        """Coverage after each epoch of its finished runs, for polars."""
        return frames.parquet_polars(self.parquet("curves"))

    def metrics_pandas(self) -> pandas.DataFrame:
        """Swarm metrics over time of its finished runs, for pandas."""
        return frames.parquet_pandas(self.parquet("metrics"))

    def metrics_polars(self) -> polars.DataFrame:
        """Swarm metrics over time of its finished runs, for polars."""
        return frames.parquet_polars(self.parquet("metrics"))

    def curves(self) -> list[dict[str, Any]]:
        """The coverage curves of its finished runs: a row for each run and epoch."""
        return [
            {"run": run.id, "seed": run.seed, "method": run.method, "label": run.label, **row}
            for run in self.runs()
            if run.state == "done"
            for row in run.curve()
        ]

    def cancel(self) -> Job:
        """Stops it for good."""
        return self._post("cancel")

    def pause(self) -> Job:
        """Stops it, to go on later."""
        return self._post("pause")

    def resume(self) -> Job:
        """Goes on."""
        return self._post("resume")

    def retry(self) -> Job:
        """Runs again what failed or was cancelled."""
        return self._post("retry")

    def delete(self) -> None:
        """Deletes it, with the results that only it has."""
        self._transport.request("DELETE", self._path())

    def _path(self) -> str:
        return f"/v1/jobs/{self.id}"

    def _post(self, what: str) -> Job:
        self.document = self._transport.request("POST", f"{self._path()}/{what}").json()
        return self

    def _why(self) -> str:
        reasons = [f"  {run.id[:12]}: {run.error}" for run in self.runs() if run.state == "failed"]
        shown = reasons[:5] + ([f"  and {len(reasons) - 5} more"] if len(reasons) > 5 else [])
        return "\n".join([f"{len(reasons)} runs of job {self.id} failed:", *shown])


def _meter(progress: bool | Callable[[Job], None]) -> Callable[[Job], None]:
    if callable(progress):
        return progress
    if not progress:
        return lambda job: None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _Lines()
    return _Bar(tqdm)


class _Bar:
    def __init__(self, tqdm: Any):
        self._bar = tqdm(total=1.0, bar_format="{desc} {percentage:3.0f}% |{bar}| {postfix}")

    def __call__(self, job: Job) -> None:
        counts = job.counts
        self._bar.set_description_str(job.name or f"job {job.id}", refresh=False)
        self._bar.set_postfix_str(f"{counts['done']}/{counts['total']} runs", refresh=False)
        self._bar.update(job.progress - self._bar.n)

    def close(self) -> None:
        self._bar.close()


class _Lines:
    """A line on standard error whenever another twentieth is done."""

    def __init__(self) -> None:
        self._shown = -1

    def __call__(self, job: Job) -> None:
        twentieth = int(job.progress * 20)
        if twentieth != self._shown:
            self._shown = twentieth
            left = "" if job.eta_s is None else f", {job.eta_s:.0f} s left"
            print(f"job {job.id}: {job.state}, {job.progress:.0%}{left}", file=sys.stderr)
