"""Outlines of a model's geoms on the floor within a range of heights, as convex polygons.

MuJoCo's geoms are convex, and so is their part between two heights: its outline on the floor is the hull of a few
projected points.
"""

import mujoco
import numpy as np

from tasks.physics import FloatArray
from tasks.room_geometry.geom_shapes import IntArray, polyhedron

# Corners of a convex polygon on the floor, counter-clockwise; metres. Tuples, so that rooms can be compared and cached.
Corner = tuple[float, float]
Outline = tuple[Corner, ...]

FAR = 1000.0  # m; extent of an infinite plane behind its face

_HORIZONTAL = 1e-6  # a plane whose normal has a smaller horizontal part is a floor or a ceiling, not a wall


def outline(model: mujoco.MjModel, data: mujoco.MjData, geom: int, low: float, high: float) -> Outline | None:
    """The outline on the floor of a geom's part between two heights; None where it has none.

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
    solid = polyhedron(model, geom)
    points = _slice(solid.corners @ rotation.T + position, solid.edges, low, high)
    return convex_hull(points[:, :2]) if len(points) else None


def _half_plane(position: FloatArray, normal: FloatArray, low: float, high: float) -> Outline | None:
    """A plane as a rectangle of side FAR behind its face."""
    level = float(np.hypot(normal[0], normal[1]))
    if level < _HORIZONTAL:
        return None
    outward = normal[:2] / level
    # A leaning plane reaches farthest at one end of the slab.
    reach = max(float(normal @ position - normal[2] * height) / level for height in (low, high))
    face, along = reach * outward, FAR * np.array([-outward[1], outward[0]])
    back = face - FAR * outward
    return convex_hull(np.stack([face + along, face - along, back + along, back - along]))


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


def convex_hull(points: FloatArray) -> Outline:
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
