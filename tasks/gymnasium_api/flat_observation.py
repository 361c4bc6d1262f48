"""The flat observation: stacked scans, velocity, goal."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from tasks.errors import TaskError
from tasks.options import between
from tasks.physics import FloatArray

SCANS = between(1, 100)

Float32Array = npt.NDArray[np.float32]


class ScanStack:
    """Keeps the last scans of an episode and writes the flat observation.

    Layout, float32 (num_scans · num_beams + 4,): the scans, newest first, each r/max_range − 0.5, then v (m/s),
    ω (rad/s) and the goal's x and y in the robot frame (m), as in the released code.
    """

    def __init__(self, num_scans: int, num_beams: int, max_range: float) -> None:
        self.num_scans = num_scans
        self.num_beams = num_beams
        self._max_range = max_range
        self._flat = np.zeros(num_scans * num_beams + 4, dtype=np.float32)

    def state(self) -> Float32Array:
        """The last observation, a copy."""
        return self._flat.copy()

    def load_state(self, flat: Float32Array) -> None:
        """Restore what state() returned; TaskError where it has another size."""
        if np.shape(flat) != self._flat.shape:
            raise TaskError(f"the state's observation has {np.size(flat)} numbers, not {self._flat.size}")
        self._flat[:] = flat

    def reset(self, observation: Mapping[str, FloatArray]) -> Float32Array:
        """Begin an episode: its first scan stands for those before it."""
        scan = observation["ranges"] / self._max_range - 0.5
        self._flat[:-4].reshape(self.num_scans, self.num_beams)[:] = scan
        return self._finished(observation)

    def push(self, observation: Mapping[str, FloatArray]) -> Float32Array:
        """Add a step's scan and drop the oldest."""
        beams = self.num_beams
        self._flat[beams:-4] = self._flat[: -4 - beams].copy()
        self._flat[:beams] = observation["ranges"] / self._max_range - 0.5
        return self._finished(observation)

    def replace_goal(self, goal: tuple[float, float]) -> Float32Array:
        """The last observation once more, with another goal: x and y in the robot frame, metres."""
        self._flat[-2:] = goal
        return self._flat.copy()

    def _finished(self, observation: Mapping[str, FloatArray]) -> Float32Array:
        self._flat[-4:-2] = observation["velocity"]
        self._flat[-2:] = observation["goal"]
        return self._flat.copy()
