"""Observations of many robots, each scan kept once: a stack of scans shares all but its newest with the one before."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from asddpg.episodes.batch_steps import Float32Array, IntArray

_NONE = -1  # of a robot that has observed nothing yet


class ObservationRing:
    """The newest observations, by running number: the n-th that was added is number n, counted from 0.

    An observation is a stack of scans, newest first, and a rest. One without scans counts as a stack of one.
    """

    def __init__(self, capacity: int, observation_size: int, scan_shape: tuple[int, int] | None, robots: int) -> None:
        """Hold `capacity` observations; memory grows as it fills.

        Args:
            capacity: observations.
            observation_size: numbers in each.
            scan_shape: (scans, beams) at the head of an observation; None for observations of another kind.
            robots: whose stacks grow side by side.
        """
        self._scans_in_stack, self._beams = scan_shape or (1, observation_size)
        self._capacity = capacity
        self._scans = np.zeros((capacity, self._beams), np.float32)
        self._rests = np.zeros((capacity, observation_size - self._scans_in_stack * self._beams), np.float32)
        self._stacks = np.zeros((capacity, self._scans_in_stack), np.int64)  # numbers of the scans, newest first
        self._count = 0
        self._newest = np.full(robots, _NONE)

    @property
    def first(self) -> int:
        """Number of the oldest scan that is held; negative as long as the ring is not full."""
        return self._count - self._capacity

    def add(self, observations: Float32Array, robots: IntArray) -> IntArray:
        """Keep an observation of each of these robots; returns their numbers, (k,).

        Args:
            observations: (k, observation_size).
            robots: (k,), each once.

        Raises:
            ValueError: a stack neither goes on from the robot's last one nor holds one scan throughout.
        """
        depth, beams = self._scans_in_stack, self._beams
        scans = observations[:, : depth * beams].reshape(-1, depth, beams)
        numbers = np.arange(self._count, self._count + len(robots))
        before = self._stacks[self._newest[robots] % self._capacity]
        goes_on = (scans[:, 1:] == self._scans[before[:, :-1] % self._capacity]).all(axis=(1, 2))
        goes_on &= self._newest[robots] != _NONE
        if not (goes_on | (scans[:, 1:] == scans[:, :1]).all(axis=(1, 2))).all():
            raise ValueError("the scans of an observation must be those before it, moved by one, or all the same")
        older = np.where(goes_on[:, None], before[:, :-1], numbers[:, None])
        at = numbers % self._capacity
        self._scans[at], self._rests[at] = scans[:, 0], observations[:, depth * beams :]
        self._stacks[at, 0], self._stacks[at, 1:] = numbers, older
        self._newest[robots] = numbers
        self._count += len(robots)
        return numbers

    def oldest_scans(self, numbers: IntArray) -> IntArray:
        """Number of the oldest scan that each of these observations holds, (k,)."""
        oldest: IntArray = self._stacks[numbers % self._capacity].min(axis=1)
        return oldest

    def write(self, numbers: IntArray, out: Float32Array) -> None:
        """Write the observations of these numbers into `out`, (k, observation_size)."""
        at, width = numbers % self._capacity, self._scans_in_stack * self._beams
        scans = self._scans[self._stacks[at] % self._capacity]
        out[:, :width] = scans.reshape(len(numbers), width)
        out[:, width:] = self._rests[at]

    def state(self) -> dict[str, Any]:
        """Views of what is held, the count of all that were added, and each robot's newest number."""
        size = min(self._count, self._capacity)
        return {
            "scans": self._scans[:size],
            "rests": self._rests[:size],
            "stacks": self._stacks[:size],
            "count": self._count,
            "newest": self._newest.copy(),
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            ValueError: it is of a ring of another size, or of other observations.
        """
        size = min(state["count"], self._capacity)
        if len(state["scans"]) != size or len(state["newest"]) != len(self._newest):
            raise ValueError(f"{len(state['scans'])} observations do not fit into a ring of {self._capacity}")
        self._count, self._newest = state["count"], state["newest"].copy()
        self._scans[:size], self._rests[:size] = state["scans"], state["rests"]
        self._stacks[:size] = state["stacks"]
