"""The convex shapes of MuJoCo's geoms: how far one reaches along a direction, and a polyhedron around it.

A geom of a kind that is not known here, as a height field, counts as its bounding box.
"""

from collections.abc import Sequence
from functools import cache
from math import cos, pi
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, QhullError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]

_SIDES = 32  # of the polyhedra around round geoms

_BOX = mujoco.mjtGeom.mjGEOM_BOX
_CAPSULES = (mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_SPHERE)  # a sphere's size[1] is 0
_ELLIPSOID = mujoco.mjtGeom.mjGEOM_ELLIPSOID
_CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
_MESH = mujoco.mjtGeom.mjGEOM_MESH


class Polyhedron(NamedTuple):
    """Corners, float64 (n, 3), metres, and the pairs of them that edges join, (m, 2)."""

    corners: FloatArray
    edges: IntArray


def reach(model: mujoco.MjModel, data: mujoco.MjData, geom: int, direction: FloatArray) -> float:
    """Largest coordinate of a geom's surface along a unit vector, (3,) world frame; metres."""
    local = data.geom_xmat[geom].reshape(3, 3).T @ direction
    return float(data.geom_xpos[geom] @ direction) + _local_reach(model, geom, local)


def extent(
    model: mujoco.MjModel, data: mujoco.MjData, geoms: Sequence[int], direction: FloatArray
) -> tuple[float, float]:
    """Least and largest coordinate of some geoms along a unit vector, (3,) world frame; metres."""
    low = -max(reach(model, data, geom, -direction) for geom in geoms)
    return low, max(reach(model, data, geom, direction) for geom in geoms)


def _local_reach(model: mujoco.MjModel, geom: int, local: FloatArray) -> float:
    """The same in the geom's own frame."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    if kind in _CAPSULES:
        return float(size[0] + size[1] * abs(local[2]))
    if kind == _CYLINDER:
        return float(size[0] * np.hypot(local[0], local[1]) + size[1] * abs(local[2]))
    if kind == _ELLIPSOID:
        return float(np.linalg.norm(size * local))
    if kind == _MESH:
        return float(np.max(_mesh_vertices(model, geom) @ local))
    centre, half = _bounding_box(model, geom)
    return float(centre @ local + half @ np.abs(local))


def polyhedron(model: mujoco.MjModel, geom: int) -> Polyhedron:
    """A polyhedron around a geom, in the geom's frame: round ones up to 1 % too large, never too small."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    if kind == _MESH:
        return _hull(_mesh_vertices(model, geom))
    if kind == _CYLINDER:
        prism = _prism()
        return Polyhedron(prism.corners * [size[0], size[0], size[1]], prism.edges)
    ball = _ball()
    if kind == _ELLIPSOID:
        return Polyhedron(ball.corners * size, ball.edges)
    if kind in _CAPSULES:
        shift = np.sign(ball.corners[:, 2:]) * [0.0, 0.0, size[1]]
        return Polyhedron(ball.corners * size[0] + shift, ball.edges)
    centre, half = _bounding_box(model, geom)
    return Polyhedron(_cube().corners * half + centre, _cube().edges)


def _mesh_vertices(model: mujoco.MjModel, geom: int) -> FloatArray:
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    return model.mesh_vert[first : first + count].astype(np.float64)  # type: ignore[no-any-return]


def _bounding_box(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, FloatArray]:
    """Centre and half sides in the geom's frame, metres; a box itself."""
    if model.geom_type[geom] == _BOX:
        return np.zeros(3), model.geom_size[geom]
    centre, half = np.split(model.geom_aabb[geom], 2)
    return centre, half


@cache
def _cube() -> Polyhedron:
    return _hull(np.stack(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0]), axis=-1).reshape(-1, 3))


@cache
def _prism() -> Polyhedron:
    """Around a cylinder of radius 1 and half height 1."""
    angles = np.arange(_SIDES) * (2 * pi / _SIDES)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) / cos(pi / _SIDES)
    return _hull(np.concatenate([np.insert(ring, 2, height, axis=1) for height in (-1.0, 1.0)]))


@cache
def _ball() -> Polyhedron:
    """Around a sphere of radius 1; no corner lies on the equator, so that a capsule can be pulled apart there."""
    angles, heights = np.arange(_SIDES) * (2 * pi / _SIDES), (np.arange(_SIDES // 2) + 0.5) * (2 * pi / _SIDES) - pi / 2
    turn, rise = np.meshgrid(angles, heights)
    points = np.stack([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)], axis=-1).reshape(-1, 3)
    inner_radius = -ConvexHull(points).equations[:, 3].max()
    return _hull(points / inner_radius)


def _hull(points: FloatArray) -> Polyhedron:
    """The convex hull of points, (n, 3); flat ones are joined each with each."""
    try:
        triangles = ConvexHull(points).simplices
    except QhullError:
        return Polyhedron(points, np.stack(np.triu_indices(len(points), 1), axis=1))
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    used, renumbered = np.unique(np.sort(edges, axis=1), return_inverse=True)
    return Polyhedron(points[used], np.unique(renumbered.reshape(-1, 2), axis=0))
