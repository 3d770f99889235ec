"""What can go wrong, as exceptions. What the server refuses carries its problem document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


class EvswarmError(Exception):
    """Anything that this package raises."""


class ConnectionFailed(EvswarmError):
    """The server did not answer, or broke off."""


class WaitTimeout(EvswarmError):
    """What was waited for did not end in time; it goes on."""


class JobFailed(EvswarmError):
    """A job that was waited for ended with failed runs; its message has their reasons."""


@dataclass(frozen=True)
class FieldError:
    """A field of a document that cannot be used."""

    pointer: str
    """JSON pointer into the document that was sent."""
    message: str
    """Why it was refused."""
    allowed: str
    """What is allowed."""

    def __str__(self) -> str:
        allowed = f" (allowed: {self.allowed})" if self.allowed else ""
        return f"{self.pointer or '(document)'}: {self.message}{allowed}"


class Problem(EvswarmError):
    """A refusal of the server (RFC 9457)."""

    def __init__(self, status: int, document: Mapping[str, Any], retry_after_s: float | None):
        self.status = status
        """HTTP status."""
        self.code: str = str(document.get("code") or "")
        """What kind of problem, by a name that stays."""
        self.title: str = str(document.get("title") or "")
        """What kind of problem, in a few words."""
        self.detail: str = str(document.get("detail") or "")
        """What happened here."""
        self.errors: list[FieldError] = [
            FieldError(
                str(error.get("pointer", "")),
                str(error.get("message", "")),
                str(error.get("allowed", "")),
            )
            for error in document.get("errors") or []
        ]
        """Every wrong field."""
        self.retry_after_s = retry_after_s
        """When to try again, where the server said so."""
        head = f"{status} {self.title}" + (f": {self.detail}" if self.detail else "")
        super().__init__("\n".join([head, *(f"  {error}" for error in self.errors)]))


class SpecRefused(Problem):
    """The document is wrong; ``errors`` has every wrong field (400, 413, 415, 422)."""


class Unauthorized(Problem):
    """The token is missing, wrong or not allowed to do this (401, 403)."""


class NotFound(Problem):
    """There is no such thing (404)."""


class Conflict(Problem):
    """The present state does not allow it (409)."""


class ServerBusy(Problem):
    """The server cannot take it now; ``retry_after_s`` says when to try again (429, 503, 507)."""


_BY_STATUS: dict[int, type[Problem]] = {
    400: SpecRefused,
    401: Unauthorized,
    403: Unauthorized,
    404: NotFound,
    409: Conflict,
    413: SpecRefused,
    415: SpecRefused,
    422: SpecRefused,
    429: ServerBusy,
    503: ServerBusy,
    507: ServerBusy,
}


def problem(status: int, document: Mapping[str, Any], retry_after: str | None) -> Problem:
    """The exception for an answer of this status."""
    try:
        retry_after_s = float(retry_after) if retry_after is not None else None
    except ValueError:
        retry_after_s = None
    return _BY_STATUS.get(status, Problem)(status, document, retry_after_s)
