"""A room's obstacles as outlines on the floor, from the compiled model."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import numpy.typing as npt

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.room_geometry.footprints import Footprint, colliding_robot_geoms
from tasks.room_geometry.outlines import Corner, Outline, outline

LOWEST = 0.001  # m; a geom that rises no higher counts as floor


@dataclass(frozen=True)
class Obstacles:
    """Convex polygons on the floor.

    Attributes:
        outlines: of all obstacles, corners in metres, world frame, counter-clockwise.
        low: corner (x, y) of the smallest rectangle around all fixed obstacles, metres.
        high: its opposite corner.
    """

    outlines: tuple[Outline, ...]
    low: Corner
    high: Corner

    @classmethod
    def from_model(cls, model: mujoco.MjModel, without: Sequence[str] = ()) -> "Obstacles":
        """Every geom but the floor that the robot can touch, in its initial position.

        Geoms wholly above the robot, such as table tops, are no obstacles.

        Args:
            model: compiled scene.
            without: names of geoms to leave out; `desk_1` leaves out desk_1_leg_0 and so on too.

        Raises:
            TaskError: the scene has no fixed obstacle, or none of such a name.
        """
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        top = float(data.body("base").xpos[2]) + Footprint.from_model(model).height
        kept = _leave_out(model, _touchable(model), without)
        found = ((geom, outline(model, data, geom, LOWEST, top)) for geom in kept)
        shapes = {geom: shape for geom, shape in found if shape}
        is_fixed = np.asarray(model.body_weldid)[model.geom_bodyid] == 0
        low, high = _extent(model, data, {geom: shape for geom, shape in shapes.items() if is_fixed[geom]})
        return cls(tuple(shapes.values()), low, high)

    def clearance(self, points: npt.ArrayLike) -> FloatArray:
        """Distance from each point to the nearest outline, 0 inside one.

        Args:
            points: (..., 2), metres, world frame.

        Returns:
            float64 (...), metres.
        """
        begins, edges, squares, firsts = self._edges
        offsets = np.asarray(points, dtype=np.float64)[..., None, :] - begins  # [..., edges, 2]
        share = np.clip(np.sum(offsets * edges, axis=-1) / squares, 0.0, 1.0)
        from_edge = offsets - share[..., None] * edges
        distances = np.minimum.reduceat(np.hypot(from_edge[..., 0], from_edge[..., 1]), firsts, axis=-1)
        inside = edges[:, 0] * offsets[..., 1] - edges[:, 1] * offsets[..., 0] >= 0.0
        distances[np.logical_and.reduceat(inside, firsts, axis=-1)] = 0.0
        return np.asarray(distances.min(axis=-1))

    @cached_property
    def _edges(self) -> tuple[FloatArray, FloatArray, FloatArray, npt.NDArray[np.intp]]:
        """Begins, vectors and squared lengths of all edges, and the index of each outline's first edge."""
        begins = np.concatenate([np.array(shape) for shape in self.outlines])
        edges = np.concatenate([np.roll(shape, -1, axis=0) - np.array(shape) for shape in self.outlines])
        sizes = [len(shape) for shape in self.outlines]
        # A shape that is cut to a point still has a distance.
        return begins, edges, np.maximum(np.sum(edges**2, axis=1), 1e-18), np.cumsum([0, *sizes[:-1]])


def _touchable(model: mujoco.MjModel) -> list[int]:
    """Geoms but the floor that collide with a geom of the robot by MuJoCo's rule."""
    contype, conaffinity = np.asarray(model.geom_contype), np.asarray(model.geom_conaffinity)
    robot = colliding_robot_geoms(model)
    touching = (contype[:, None] & conaffinity[robot]) | (conaffinity[:, None] & contype[robot])
    others = np.asarray(model.body_rootid)[model.geom_bodyid] != model.body("base").id
    floor = np.arange(model.ngeom) == model.geom("floor").id
    return [int(geom) for geom in np.flatnonzero(touching.any(axis=1) & others & ~floor)]


def obstacle_names(model: mujoco.MjModel) -> list[str]:
    """Names of the room's obstacles, in order of the alphabet; legs of one piece of furniture have its name."""
    names = [model.geom(geom).name for geom in _touchable(model)]
    return sorted({re.sub(r"(_\d+)?_leg_\d+$", "", name) for name in names if name})


def _leave_out(model: mujoco.MjModel, geoms: list[int], without: Sequence[str]) -> list[int]:
    names = {geom: model.geom(geom).name for geom in geoms}
    for name in without:
        chosen = {geom for geom, each in names.items() if each == name or each.startswith(f"{name}_")}
        if not chosen:
            raise TaskError(f"the room has no obstacle {name!r}; it has {', '.join(obstacle_names(model))}")
        names = {geom: each for geom, each in names.items() if geom not in chosen}
    return list(names)


def _extent(model: mujoco.MjModel, data: mujoco.MjData, shapes: dict[int, Outline]) -> tuple[Corner, Corner]:
    """The rectangle around outlines; an infinite plane counts by its position."""
    corners: list[Corner] = []
    for geom, shape in shapes.items():
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            x, y, _ = data.geom_xpos[geom].tolist()
            corners.append((x, y))
        else:
            corners.extend(shape)
    if not corners:
        raise TaskError("the scene has no walls: a room needs fixed geoms that bound the floor")
    xs, ys = zip(*corners, strict=True)
    return (min(xs), min(ys)), (max(xs), max(ys))
