"""Robots of a run in shared memory: frames to watch, and controllers in another process.

Needs the extra ``channels`` (``pip install evswarm[channels]``) and a server, or ``evswarm run``,
on the same machine and of the same user.
"""

try:
    from evswarm.channels.controller import Controller, ControllerPort, Question, Readings, steer
    from evswarm.channels.frames import Frame, FrameReader
    from evswarm.channels.transport import ChannelError, default_root
except ModuleNotFoundError as error:
    needed = f"evswarm.channels needs {error.name}: pip install 'evswarm[channels]'"
    raise ModuleNotFoundError(needed, name=error.name) from error

__all__ = [
    "ChannelError",
    "Controller",
    "ControllerPort",
    "Frame",
    "FrameReader",
    "Question",
    "Readings",
    "default_root",
    "steer",
]
