"""The static boxes of a room as rectangles on the floor, read from the compiled model."""

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from tasks.physics import MOVABLE_GROUP, FloatArray


@dataclass(frozen=True)
class Obstacles:
    """Rectangles on the floor.

    Attributes:
        centres: float64 (n, 2), metres, world frame.
        half_sizes: float64 (n, 2), metres, along each rectangle's own axes.
        yaws: float64 (n,), radians.
    """

    centres: FloatArray
    half_sizes: FloatArray
    yaws: FloatArray

    @classmethod
    def from_model(cls, model: mujoco.MjModel) -> "Obstacles":
        """Every colliding box that is fixed to the world and cannot be pushed."""
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        chosen = np.flatnonzero(
            (np.asarray(model.geom_type) == mujoco.mjtGeom.mjGEOM_BOX)
            & (np.asarray(model.body_weldid)[model.geom_bodyid] == 0)
            & (np.asarray(model.geom_group) != MOVABLE_GROUP)
            & (np.asarray(model.geom_contype) != 0)
        )
        rotations = data.geom_xmat[chosen].reshape(-1, 3, 3)
        return cls(
            centres=data.geom_xpos[chosen, :2].copy(),
            half_sizes=model.geom_size[chosen, :2].copy(),
            yaws=np.arctan2(rotations[:, 1, 0], rotations[:, 0, 0]),
        )

    def clearance(self, points: npt.ArrayLike) -> FloatArray:
        """Distance from each point to the nearest rectangle, 0 inside one.

        Args:
            points: (..., 2), metres, world frame.

        Returns:
            float64 (...), metres.
        """
        offsets = np.asarray(points, dtype=np.float64)[..., None, :] - self.centres  # [..., n, 2]
        cos, sin = np.cos(self.yaws), np.sin(self.yaws)
        along = np.abs(offsets[..., 0] * cos + offsets[..., 1] * sin) - self.half_sizes[:, 0]
        across = np.abs(offsets[..., 1] * cos - offsets[..., 0] * sin) - self.half_sizes[:, 1]
        distances = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
        return np.asarray(distances.min(axis=-1, initial=np.inf))
