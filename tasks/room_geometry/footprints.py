"""The robot's footprint on the floor, from the compiled model."""

from typing import NamedTuple

import mujoco
import numpy as np

from tasks.room_geometry.geom_shapes import reach
from tasks.room_geometry.outlines import Outline, convex_hull, outline

UP = np.array([0.0, 0.0, 1.0])


class Footprint(NamedTuple):
    """The robot seen from its base's axis, all in metres.

    Attributes:
        outline: its convex hull on the floor, corners counter-clockwise, x ahead and y to the left.
        radius: of the circle it needs for turning on the spot.
        half_width: from the axis to either side, the space it needs for driving straight through a gap.
        height: of its highest part that can touch anything.
    """

    outline: Outline
    radius: float
    half_width: float
    height: float

    @property
    def inscribed_radius(self) -> float:
        """Of the largest circle about the axis inside the outline."""
        begins = np.array(self.outline)
        edges = np.roll(begins, -1, axis=0) - begins
        return float(np.min(np.abs(edges[:, 0] * begins[:, 1] - edges[:, 1] * begins[:, 0]) / np.hypot(*edges.T)))

    @classmethod
    def from_model(cls, model: mujoco.MjModel) -> "Footprint":
        """Of the colliding geoms of body `base` and its children, in the model's initial state."""
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        base = model.body("base").id
        rotation, position = data.xmat[base].reshape(3, 3), data.xpos[base]
        geoms = colliding_robot_geoms(model)
        outlines = [outline(model, data, geom, -np.inf, np.inf) for geom in geoms]
        corners = np.array([corner for shape in outlines for corner in shape or ()]) - position[:2]
        # Corners from the world's axes into the base's.
        corners = corners @ rotation[:2, :2]
        return cls(
            outline=convex_hull(corners),
            radius=float(np.hypot(*corners.T).max()),
            half_width=float(np.abs(corners[:, 1]).max()),
            height=max(reach(model, data, geom, UP) for geom in geoms) - float(position[2]),
        )


def colliding_robot_geoms(model: mujoco.MjModel) -> list[int]:
    """Indices of the robot's geoms that can touch something."""
    robot = np.asarray(model.body_rootid)[model.geom_bodyid] == model.body("base").id
    collides = (np.asarray(model.geom_contype) != 0) | (np.asarray(model.geom_conaffinity) != 0)
    return [int(geom) for geom in np.flatnonzero(robot & collides)]
