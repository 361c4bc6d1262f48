"""Poses in the plane: x, y (metres) and yaw (radians)."""

import numpy as np
import numpy.typing as npt

from asddpg.planning.occupancy_grid import FloatArray


def wrap_angle(angle: npt.ArrayLike) -> FloatArray:
    """Angles, radians, as the equal ones in [−π, π)."""
    return np.asarray((np.asarray(angle, dtype=np.float64) + np.pi) % (2 * np.pi) - np.pi)


def compose(poses: npt.ArrayLike, motion: npt.ArrayLike) -> FloatArray:
    """Poses after a motion.

    Args:
        poses: (..., 3).
        motion: (3,), in the frame of each pose.

    Returns:
        (..., 3), in the frame that `poses` are in.
    """
    start = np.asarray(poses, dtype=np.float64)
    x, y, turn = np.asarray(motion, dtype=np.float64)
    cos, sin = np.cos(start[..., 2]), np.sin(start[..., 2])
    moved = (start[..., 0] + cos * x - sin * y, start[..., 1] + sin * x + cos * y, wrap_angle(start[..., 2] + turn))
    return np.stack(moved, axis=-1)


def pose_between(before: npt.ArrayLike, after: npt.ArrayLike) -> FloatArray:
    """Pose `after` (3,) in the frame of pose `before` (3,): compose(before, it) is `after`."""
    start, end = np.asarray(before, dtype=np.float64), np.asarray(after, dtype=np.float64)
    (x, y), cos, sin = end[:2] - start[:2], np.cos(start[2]), np.sin(start[2])
    return np.array([cos * x + sin * y, cos * y - sin * x, wrap_angle(end[2] - start[2])])


def mean_pose(poses: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted mean of poses (n, 3), that of yaw on the circle: (3,). The weights (n,) need not sum to 1."""
    x, y = weights @ poses[:, :2] / weights.sum()
    return np.array([x, y, np.arctan2(weights @ np.sin(poses[:, 2]), weights @ np.cos(poses[:, 2]))])


def pose_covariance(poses: FloatArray, weights: FloatArray, center: FloatArray) -> FloatArray:
    """Weighted covariance (3, 3) of poses (n, 3) about `center` (3,); the weights (n,) sum to 1."""
    offsets = poses - center
    offsets[:, 2] = wrap_angle(offsets[:, 2])
    return np.asarray((offsets * weights[:, None]).T @ offsets)
