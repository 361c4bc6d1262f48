"""What a model's geoms cover of the floor within a range of heights, as convex polygons.

MuJoCo's geoms are convex, and so is what a slab of heights cuts out of them: its shadow on the floor is the hull of the
shadows of a few points. Round geoms are taken as polyhedra around them, up to 1 % too large and never too small.
"""

from functools import cache
from math import cos, pi
from typing import NamedTuple

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull, QhullError

from tasks.physics import FloatArray

IntArray = npt.NDArray[np.intp]

# Corners of a convex polygon on the floor, counter-clockwise; metres. Tuples, so that rooms can be compared and cached.
Corner = tuple[float, float]
Outline = tuple[Corner, ...]

FAR = 1000.0  # m; how far behind its face a plane, which has no end, is taken to reach

_SIDES = 32  # of the polyhedra around round geoms
_HORIZONTAL = 1e-6  # a plane whose normal lies this little along the floor is a floor or a ceiling, not a wall

_BOX = mujoco.mjtGeom.mjGEOM_BOX
_SPHERE = mujoco.mjtGeom.mjGEOM_SPHERE
_CAPSULE = mujoco.mjtGeom.mjGEOM_CAPSULE
_ELLIPSOID = mujoco.mjtGeom.mjGEOM_ELLIPSOID
_CYLINDER = mujoco.mjtGeom.mjGEOM_CYLINDER
_MESH = mujoco.mjtGeom.mjGEOM_MESH


class _Polyhedron(NamedTuple):
    """Corners, float64 (n, 3), metres, and the pairs of them that edges join, (m, 2)."""

    corners: FloatArray
    edges: IntArray


def outline(model: mujoco.MjModel, data: mujoco.MjData, geom: int, low: float, high: float) -> Outline | None:
    """The outline on the floor of what a geom has between two heights; None where it has nothing there.

    Args:
        model: compiled scene.
        data: its state, kinematics done.
        geom: index of the geom.
        low: metres above the floor.
        high: metres above the floor.
    """
    position, rotation = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
        return _half_plane(position, rotation[:, 2], low, high)
    solid = _solid(model, geom)
    points = _slice(solid.corners @ rotation.T + position, solid.edges, low, high)
    return _hull(points[:, :2]) if len(points) else None


def _half_plane(position: FloatArray, normal: FloatArray, low: float, high: float) -> Outline | None:
    """A plane as the rectangle behind its face, as wide and deep as anything may be."""
    level = float(np.hypot(normal[0], normal[1]))
    if level < _HORIZONTAL:
        return None
    outward = normal[:2] / level
    # A leaning plane reaches farthest at one end of the slab.
    reach = max(float(normal @ position - normal[2] * height) / level for height in (low, high))
    face, along = reach * outward, FAR * np.array([-outward[1], outward[0]])
    back = face - FAR * outward
    return _hull(np.stack([face + along, face - along, back + along, back - along]))


def _solid(model: mujoco.MjModel, geom: int) -> _Polyhedron:
    """A geom as a polyhedron in its own frame; what has no shape of its own here is taken as its bounding box."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    if kind == _MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        return _hull_solid(model.mesh_vert[first : first + count].astype(np.float64))
    if kind == _CYLINDER:
        prism = _prism()
        return _Polyhedron(prism.corners * [size[0], size[0], size[1]], prism.edges)
    if kind in (_SPHERE, _CAPSULE, _ELLIPSOID):
        ball = _ball()
        corners = ball.corners * (size if kind == _ELLIPSOID else size[0])
        if kind == _CAPSULE:
            corners[:, 2] += np.sign(ball.corners[:, 2]) * size[1]
        return _Polyhedron(corners, ball.edges)
    centre, half = (np.zeros(3), size) if kind == _BOX else np.split(model.geom_aabb[geom], 2)
    return _Polyhedron(_cube().corners * half + centre, _cube().edges)


@cache
def _cube() -> _Polyhedron:
    return _hull_solid(np.stack(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0]), axis=-1).reshape(-1, 3))


@cache
def _prism() -> _Polyhedron:
    """Around a cylinder of radius 1 and half height 1."""
    angles = np.arange(_SIDES) * (2 * pi / _SIDES)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) / cos(pi / _SIDES)
    return _hull_solid(np.concatenate([np.insert(ring, 2, height, axis=1) for height in (-1.0, 1.0)]))


@cache
def _ball() -> _Polyhedron:
    """Around a sphere of radius 1; no corner lies on the equator, so that a capsule can be pulled apart there."""
    angles, heights = np.arange(_SIDES) * (2 * pi / _SIDES), (np.arange(_SIDES // 2) + 0.5) * (2 * pi / _SIDES) - pi / 2
    turn, rise = np.meshgrid(angles, heights)
    points = np.stack([np.cos(turn) * np.cos(rise), np.sin(turn) * np.cos(rise), np.sin(rise)], axis=-1).reshape(-1, 3)
    inner_radius = -ConvexHull(points).equations[:, 3].max()
    return _hull_solid(points / inner_radius)


def _hull_solid(points: FloatArray) -> _Polyhedron:
    """The convex hull of points, (n, 3); flat ones are joined each with each."""
    try:
        triangles = ConvexHull(points).simplices
    except QhullError:
        return _Polyhedron(points, np.stack(np.triu_indices(len(points), 1), axis=1))
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    used, renumbered = np.unique(np.sort(edges, axis=1), return_inverse=True)
    return _Polyhedron(points[used], np.unique(renumbered.reshape(-1, 2), axis=0))


def _slice(corners: FloatArray, edges: IntArray, low: float, high: float) -> FloatArray:
    """Points whose hull is the part of a polyhedron between two heights, (k, 3); none where it has no such part."""
    heights = corners[:, 2]
    parts = [corners[(heights >= low) & (heights <= high)]]
    begin, end = corners[edges[:, 0]], corners[edges[:, 1]]
    for level in (low, high):
        across = (begin[:, 2] - level) * (end[:, 2] - level) < 0.0
        share = (level - begin[across, 2]) / (end[across, 2] - begin[across, 2])
        parts.append(begin[across] + share[:, None] * (end[across] - begin[across]))
    return np.concatenate(parts)


def _hull(points: FloatArray) -> Outline:
    """Convex hull of points on the floor, (n, 2), by Andrew's monotone chain."""
    ordered = sorted(set(map(tuple, points.tolist())))
    return tuple(_half_hull(ordered)[:-1] + _half_hull(ordered[::-1])[:-1]) or tuple(ordered)


def _half_hull(ordered: list[Corner]) -> list[Corner]:
    chain: list[Corner] = []
    for x, y in ordered:
        while len(chain) > 1 and _turns_right(chain[-2], chain[-1], (x, y)):
            chain.pop()
        chain.append((x, y))
    return chain


def _turns_right(a: Corner, b: Corner, c: Corner) -> bool:
    """Whether a → b → c turns right or hardly at all (points of one edge, an ulp apart)."""
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]) <= 1e-12
