"""Where servers and programs of one user meet, and memory of the transport as numpy arrays."""

from __future__ import annotations

import ctypes
import os
import tempfile
from pathlib import Path
from typing import Any

import iceoryx2 as iox2
import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

iox2.set_log_level_from_env_or(iox2.LogLevel.Error)


class ChannelError(RuntimeError):
    """The transport refuses something; the text says what was tried."""


def default_root() -> Path:
    """``$XDG_RUNTIME_DIR/evswarm``, else ``evswarm-<user>`` in the folder for temporary files."""
    folder = os.environ.get("XDG_RUNTIME_DIR", "")
    if os.path.isabs(folder):
        return Path(folder) / "evswarm"
    return Path(tempfile.gettempdir()) / f"evswarm-{os.getuid()}"


def _fnv1a(data: bytes) -> int:
    digest = 0xCBF29CE484222325
    for byte in data:
        digest = (digest ^ byte) * 0x100000001B3 % 2**64
    return digest


def open_node(root: Path | None) -> Any:
    """A node of this process under a root (by default the one of this user)."""
    path = os.fspath(root or default_root())
    if not os.path.isabs(path) or len(path.encode()) > 120:
        raise ChannelError(f"root path {path!r}: it must be absolute and at most 120 bytes long")
    os.makedirs(path, mode=0o700, exist_ok=True)
    config = iox2.config.default()
    config.global_cfg.root_path = iox2.Path.new(path)
    config.global_cfg.prefix = iox2.FileName.new(f"evswarm_{_fnv1a(path.encode()):016x}_")
    builder = iox2.NodeBuilder.new().config(config)
    builder = builder.signal_handling_mode(iox2.SignalHandlingMode.Disabled)
    return attempt("a node of the transport", lambda: builder.create(iox2.ServiceType.Ipc))


def attempt(what: str, act: Any) -> Any:
    """Does something with the transport; says what it was when that is refused."""
    try:
        return act()
    except Exception as error:
        raise ChannelError(f"{what}: {error}") from error


def as_array(pointer: int, count: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Elements of a sample without copying; whoever has the array must keep the sample too."""
    if count == 0:
        return np.empty(0, dtype)
    buffer = (ctypes.c_char * (count * dtype.itemsize)).from_address(pointer)
    array: NDArray[Any] = np.frombuffer(memoryview(buffer), dtype=dtype)
    return array


def columns(robots: NDArray[Any], first: str, count: int) -> NDArray[np.float32]:
    """Neighbouring fields of 32 bits of all robots as one array, read-only and without copying."""
    strides = (robots.dtype.itemsize, 4)
    return as_strided(robots[first], (len(robots), count), strides, writeable=False)
