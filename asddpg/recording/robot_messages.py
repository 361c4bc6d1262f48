"""Foxglove's messages of where things are and what the laser sees."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from foxglove.messages import (
    LaserScan,
    Odometry,
    Pose,
    PoseInFrame,
    Quaternion,
    Timestamp,
    Vector3,
)

from asddpg.recording.moments import NANOSECONDS
from tasks.constants import FIELD_OF_VIEW, MAX_RANGE
from tasks.physics import FloatArray
from tasks.scene_parts import WORLD

_IDENTITY = Pose(position=Vector3(), orientation=Quaternion(w=1.0))
# Ranges are kept in steps of 1/512 m, places and quaternions of 1/4096: the lower bytes of a double are zeros then,
# which take no room once compressed.
_RANGE_GRID = 512.0
_GRID = 4096.0


def on_grid(values: npt.NDArray[np.floating]) -> FloatArray:
    """Numbers as they are kept, at most 1/8192 off: 0.12 mm."""
    kept: FloatArray = np.rint(values * _GRID) / _GRID + 0.0  # without the sign of −0
    return kept


def timestamp(time: int) -> Timestamp:
    """Simulated nanoseconds as Foxglove has them."""
    return Timestamp(sec=time // NANOSECONDS, nsec=time % NANOSECONDS)


def kept_ranges(observations: npt.NDArray[np.floating], num_beams: int) -> FloatArray:
    """The newest scan of each observation, (m, size), as it is kept: (m, num_beams) metres, at most 1 mm off."""
    kept: FloatArray = np.rint((observations[:, :num_beams] + 0.5) * (MAX_RANGE * _RANGE_GRID)) / _RANGE_GRID
    return kept


def laser_scan(ranges: list[float], time: int) -> LaserScan:
    """What the policy saw: ranges in metres from right to left, at a simulated time in ns."""
    half = FIELD_OF_VIEW / 2
    return LaserScan(
        timestamp=timestamp(time), frame_id="laser", pose=_IDENTITY, start_angle=-half, end_angle=half, ranges=ranges
    )


def odometry(base: Sequence[float], velocity: Sequence[float], time: int) -> Odometry:
    """Pose of the base in the world, its velocity in its own frame.

    Args:
        base: x, y, z in metres and the quaternion w, x, y, z.
        velocity: forward in m/s, turning in rad/s.
        time: simulated ns.
    """
    x, y, z, qw, qx, qy, qz = base
    linear, angular = velocity
    return Odometry(
        timestamp=timestamp(time),
        frame_id=WORLD,
        body_frame_id="base",
        pose=Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=qx, y=qy, z=qz, w=qw)),
        linear_velocity=Vector3(x=linear),
        angular_velocity=Vector3(z=angular),
    )


def goal_pose(goal: tuple[float, float], time: int) -> PoseInFrame:
    """The goal on the floor, metres, world frame."""
    x, y = goal
    pose = Pose(position=Vector3(x=x, y=y), orientation=Quaternion(w=1.0))
    return PoseInFrame(timestamp=timestamp(time), frame_id=WORLD, pose=pose)
