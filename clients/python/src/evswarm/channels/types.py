"""What lies in shared memory, as the server writes it: the types of ``api/src/frames.rs`` and
``api/src/external.rs``. Names hold the version; another version is refused when a channel opens."""

from __future__ import annotations

import ctypes
from typing import ClassVar

import numpy as np

EXTERNAL_VERSION = 1
"""Version of the questions and answers."""


class _Shared(ctypes.Structure):
    _name: ClassVar[str]

    @classmethod
    def type_name(cls) -> str:
        """Name under which the transport checks the type."""
        return cls._name


class RobotState(_Shared):
    """One robot in a frame."""

    _name = "swarm.RobotState.v1"
    _fields_ = [
        ("number", ctypes.c_uint32),
        ("x_m", ctypes.c_float),
        ("y_m", ctypes.c_float),
        ("heading_cos", ctypes.c_float),
        ("heading_sin", ctypes.c_float),
        ("sensors", ctypes.c_float * 8),
        ("commands", ctypes.c_float * 2),
    ]


class FrameHeader(_Shared):
    """What a frame shows, beside the robots."""

    _name = "swarm.FrameHeader.v1"
    _fields_ = [
        ("sequence", ctypes.c_uint64),
        ("arena_step", ctypes.c_uint64),
        ("robot_steps_done", ctypes.c_uint64),
        ("robot_steps_total", ctypes.c_uint64),
        ("sim_time_s", ctypes.c_double),
        ("step_s", ctypes.c_double),
        ("version", ctypes.c_uint32),
        ("phase", ctypes.c_uint32),
        ("epochs_done", ctypes.c_uint32),
        ("epochs_total", ctypes.c_uint32),
        ("robots", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
    ]


class RobotSense(_Shared):
    """What a robot reads. Position and first entries are for rewards; a robot knows neither."""

    _name = "swarm.RobotSense.v1"
    _fields_ = [
        ("number", ctypes.c_uint32),
        ("sensors", ctypes.c_float * 8),
        ("x_m", ctypes.c_float),
        ("y_m", ctypes.c_float),
        ("heading_cos", ctypes.c_float),
        ("heading_sin", ctypes.c_float),
        ("first_entries", ctypes.c_uint32),
    ]


class Asked(_Shared):
    """The moment that a question is about."""

    _name = "swarm.Asked.v1"
    _fields_ = [
        ("arena_step", ctypes.c_uint64),
        ("sim_time_s", ctypes.c_double),
        ("step_s", ctypes.c_double),
        ("width_m", ctypes.c_double),
        ("height_m", ctypes.c_double),
        ("epoch", ctypes.c_uint32),
        ("epoch_step", ctypes.c_uint32),
        ("epochs", ctypes.c_uint32),
        ("steps_per_epoch", ctypes.c_uint32),
        ("robots", ctypes.c_uint32),
        ("first_robot", ctypes.c_uint32),
        ("columns", ctypes.c_uint32),
        ("rows", ctypes.c_uint32),
        ("asked_robots", ctypes.c_uint32),
        ("version", ctypes.c_uint32),
    ]


class Answered(_Shared):
    """The header of an answer."""

    _name = "swarm.Answered.v1"
    _fields_ = [
        ("arena_step", ctypes.c_uint64),
        ("version", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
    ]


class WheelCommand(_Shared):
    """What a robot is to do in a step."""

    _name = "swarm.WheelCommand.v1"
    _fields_ = [("left", ctypes.c_float), ("right", ctypes.c_float)]


ROBOT_STATE = np.dtype(RobotState)
"""A robot of a frame, for numpy."""
ROBOT_SENSE = np.dtype(RobotSense)
"""A robot of a question, for numpy."""
