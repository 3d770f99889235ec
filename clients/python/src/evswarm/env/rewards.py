"""Rewards for each robot and step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Reward = Callable[["Squares", NDArray[Any]], NDArray[np.float64]]


class Squares:
    """Which squares of the arena were entered in an episode, and how often."""

    def __init__(self, size_m: tuple[float, float], squares: tuple[int, int]) -> None:
        self._counts = np.array(squares)
        self._scale = self._counts / np.array(size_m)
        self.entered = np.zeros(squares[::-1], dtype=bool)
        self.visits = np.zeros(squares[::-1], dtype=np.int64)
        self.at: NDArray[np.int64] | None = None

    def reset(self, positions_m: NDArray[Any]) -> None:
        """An episode begins with robots where they stand."""
        self.entered[:] = False
        self.visits[:] = 0
        self.at = None
        self.enter(positions_m)

    def enter(self, positions_m: NDArray[Any]) -> NDArray[np.float64]:
        """Takes in where robots stand; 1 for each that is the first in its square, else 0."""
        index = np.clip((positions_m * self._scale).astype(np.int64), 0, self._counts - 1)
        columns, rows = index[:, 0], index[:, 1]
        flat = rows * self._counts[0] + columns
        moved = np.ones(len(flat), bool) if self.at is None else flat != self.at
        self.at = flat
        new = np.zeros(len(flat))
        fresh = moved & ~self.entered[rows, columns]
        # Of several robots the one with the lowest number is the first.
        _, first = np.unique(flat[fresh], return_index=True)
        new[np.flatnonzero(fresh)[first]] = 1.0
        self.entered[rows, columns] = True
        np.add.at(self.visits, (rows[moved], columns[moved]), 1)
        return new

    @property
    def coverage(self) -> int:
        """Squares entered in this episode."""
        return int(self.entered.sum())


def coverage(squares: Squares, positions_m: NDArray[Any]) -> NDArray[np.float64]:
    """1 for each robot that is the first of the episode in its square."""
    return squares.enter(positions_m)


def entropy(squares: Squares, positions_m: NDArray[Any]) -> NDArray[np.float64]:
    """Growth of the entropy of entries over squares, in nats, shared by all robots."""
    before = _entropy(squares.visits)
    squares.enter(positions_m)
    grown = (_entropy(squares.visits) - before) / len(positions_m)
    return np.full(len(positions_m), grown)


def _entropy(visits: NDArray[np.int64]) -> float:
    counts = visits[visits > 0]
    shares = counts / counts.sum() if len(counts) else counts
    return float(-(shares * np.log(shares)).sum()) if len(counts) else 0.0


REWARDS: dict[str, Reward] = {"coverage": coverage, "entropy": entropy}
"""Rewards by name."""
