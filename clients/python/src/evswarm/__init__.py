"""Client of evswarm: submit jobs, wait for them, and read what their runs found."""

from evswarm.client import Client
from evswarm.errors import (
    Conflict,
    ConnectionFailed,
    EvswarmError,
    FieldError,
    JobFailed,
    NotFound,
    Problem,
    ServerBusy,
    SpecRefused,
    Unauthorized,
    WaitTimeout,
)
from evswarm.jobs import Job
from evswarm.runs import Run

__all__ = [
    "Client",
    "Conflict",
    "ConnectionFailed",
    "EvswarmError",
    "FieldError",
    "Job",
    "JobFailed",
    "NotFound",
    "Problem",
    "Run",
    "ServerBusy",
    "SpecRefused",
    "Unauthorized",
    "WaitTimeout",
]
