"""Odometry of a differential drive: wheel encoders to a pose, and the motion between two poses."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from asddpg.planning.occupancy_grid import FloatArray
from asddpg.planning.poses import wrap_angle

MIN_TRANSLATION = 0.01  # m; the direction of a shorter motion is noise


@dataclass(frozen=True)
class OdometryErrors:
    """Systematic errors: what odometry takes a length for, divided by what it is (Borenstein and Feng, 1996).

    Attributes:
        left_radius: factor of the left wheel's radius.
        right_radius: factor of the right wheel's radius.
        track: factor of the track.
    """

    left_radius: float = 1.0
    right_radius: float = 1.0
    track: float = 1.0


class WheelOdometry:
    """Integrates the encoders of two wheels to a pose."""

    def __init__(
        self, wheel_radius: float, track: float, resolution: int, errors: OdometryErrors | None = None
    ) -> None:
        """Start at the origin, with both wheels at angle 0.

        Args:
            wheel_radius: of both wheels, metres.
            track: distance between the wheels, metres.
            resolution: encoder ticks a revolution.
            errors: systematic errors, none by default.
        """
        wrong = errors or OdometryErrors()
        tick_length = 2 * math.pi * wheel_radius / resolution
        self._tick_lengths = tick_length * wrong.left_radius, tick_length * wrong.right_radius
        self._track = track * wrong.track
        self._resolution = resolution
        self.reset()

    def reset(self, pose: npt.ArrayLike = (0.0, 0.0, 0.0), wheel_angles: tuple[float, float] = (0.0, 0.0)) -> None:
        """Be at a pose (x, y, yaw; metres, radians), with the wheels (left, right) at these angles, radians."""
        self._x, self._y, self._yaw = np.asarray(pose, dtype=np.float64).tolist()
        self._ticks = self._ticks_at(wheel_angles)

    @property
    def pose(self) -> FloatArray:
        """The pose (x, y, yaw) in the frame of the first one, metres and radians in [−π, π), (3,)."""
        return np.array([self._x, self._y, wrap_angle(self._yaw)])

    def update(self, wheel_angles: tuple[float, float]) -> FloatArray:
        """Add the arc since the last update.

        Args:
            wheel_angles: true angles of the wheels (left, right), radians, not wrapped.

        Returns:
            The pose, as in `pose`.
        """
        # Ticks of absolute angles: the rounding of one step is made good by the next.
        ticks = self._ticks_at(wheel_angles)
        left, right = (
            (now - last) * length for now, last, length in zip(ticks, self._ticks, self._tick_lengths, strict=True)
        )
        self._ticks = ticks
        half_turn = 0.5 * (right - left) / self._track
        chord = 0.5 * (left + right) * (math.sin(half_turn) / half_turn if half_turn else 1.0)
        self._x += chord * math.cos(self._yaw + half_turn)
        self._y += chord * math.sin(self._yaw + half_turn)
        self._yaw += 2 * half_turn
        return self.pose

    def _ticks_at(self, wheel_angles: tuple[float, float]) -> tuple[int, int]:
        left, right = (math.floor(angle / (2 * math.pi) * self._resolution) for angle in wheel_angles)
        return left, right


class RelativeMotion(NamedTuple):
    """A motion as a turn, a straight line and a turn.

    Attributes:
        rot1: turn towards the line, radians in [−π, π).
        trans: length of the line, metres, not negative.
        rot2: turn after it, radians in [−π, π).
    """

    rot1: float
    trans: float
    rot2: float


def relative_motion(before: npt.ArrayLike, after: npt.ArrayLike) -> RelativeMotion:
    """The motion between two poses (x, y, yaw; metres, radians); a line below 1 cm has no turn before it."""
    start, end = np.asarray(before, dtype=np.float64), np.asarray(after, dtype=np.float64)
    x, y, turn = end - start
    trans = math.hypot(x, y)
    rot1 = 0.0 if trans < MIN_TRANSLATION else float(wrap_angle(math.atan2(y, x) - start[2]))
    return RelativeMotion(rot1, trans, float(wrap_angle(turn - rot1)))


@dataclass(frozen=True)
class MotionNoise:
    """Variances of the motion model (Thrun, Burgard and Fox, Probabilistic Robotics, table 5.6).

    Attributes:
        alpha1: variance of a turn for each rad² turned.
        alpha2: variance of a turn, rad², for each m² travelled.
        alpha3: variance of a line for each m² travelled.
        alpha4: variance of a line, m², for each rad² turned.
    """

    alpha1: float = 0.2
    alpha2: float = 0.2
    alpha3: float = 0.2
    alpha4: float = 0.2

    def deviations(self, motion: RelativeMotion) -> tuple[float, float, float]:
        """Standard deviations of rot1 (rad), trans (m) and rot2 (rad); a motion backwards has those of one forwards."""
        # A motion backwards is a half turn, a line and a half turn; the wheels turn no half turn.
        turn1, turn2 = (min(abs(turn), math.pi - abs(turn)) ** 2 for turn in (motion.rot1, motion.rot2))
        line = motion.trans**2
        variances = (
            self.alpha1 * turn1 + self.alpha2 * line,
            self.alpha3 * line + self.alpha4 * (turn1 + turn2),
            self.alpha1 * turn2 + self.alpha2 * line,
        )
        first, second, third = map(math.sqrt, variances)
        return first, second, third


def sample_motion(
    poses: FloatArray, motion: RelativeMotion, noise: MotionNoise, rng: np.random.Generator
) -> FloatArray:
    """Poses (n, 3) after a motion, each with noise of its own: (n, 3)."""
    draws = rng.standard_normal((len(poses), 3)) * noise.deviations(motion) + motion
    rot1, trans, rot2 = draws.T
    direction = poses[:, 2] + rot1
    x, y = poses[:, 0] + trans * np.cos(direction), poses[:, 1] + trans * np.sin(direction)
    return np.stack((x, y, wrap_angle(direction + rot2)), axis=-1)
