"""Obstacles out of flat outlines: boxes and prisms of HEIGHT on the floor."""

import math

import numpy as np

from tasks.physics import FloatArray
from tasks.rooms.room import HEIGHT, Obstacle, Quaternion, Shape, box

THINNEST = 1e-6  # m², the area of a triangle that is left out
FLAT = 1e-12  # m², twice the area of a triangle whose corners count as in line


def to_quaternion(yaw: float) -> Quaternion:
    """The rotation by an angle about the vertical, rad, counter-clockwise."""
    return (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))


def wall(begin: FloatArray, end: FloatArray, thickness: float, name: str = "wall") -> Obstacle:
    """A box along a line, and half its thickness beyond either end, so that walls close at corners; metres."""
    (x, y), (along_x, along_y) = ((begin + end) / 2).tolist(), (end - begin).tolist()
    half_length = (math.hypot(along_x, along_y) + thickness) / 2
    return box(x, y, half_length, thickness / 2, to_quaternion(math.atan2(along_y, along_x)), name)


def prism(corners: FloatArray, name: str = "") -> Obstacle:
    """The upright prism over the convex hull of some corners, (n, 2), metres."""
    x, y = corners.mean(axis=0).tolist()
    points = [(cx - x, cy - y, z) for cx, cy in corners.tolist() for z in (-HEIGHT / 2, HEIGHT / 2)]
    return Obstacle(Shape.HULL, (x, y, HEIGHT / 2), points=tuple(points), name=name)


def split_polygon(corners: FloatArray) -> list[FloatArray]:
    """A simple polygon as convex pieces: itself, or triangles.

    Args:
        corners: (n, 2), in order, either way round; metres.

    Returns:
        Corners of each piece, counter-clockwise; none of a polygon without area.

    Raises:
        ValueError: its edges cross or touch.
    """
    corners = corners[np.any(corners != np.roll(corners, 1, axis=0), axis=1)]  # the last may repeat the first
    if len(corners) < 3:
        return []
    if _edges_cross(corners):
        raise ValueError("edges of the polygon cross or touch")
    if abs(_area(corners)) < THINNEST:
        return []
    corners = _drop_flat(corners if _area(corners) > 0.0 else corners[::-1])
    pieces = [corners] if (_corner_turns(corners) > 0.0).all() else _cut_ears(corners)
    return [piece for piece in pieces if _area(piece) >= THINNEST]


def _area(corners: FloatArray) -> float:
    x, y = corners.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2


def _turns(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Twice the area of triangles a, b, c; positive where they turn to the left."""
    (ab, ac) = b - a, c - a
    return np.asarray(ab[..., 0] * ac[..., 1] - ab[..., 1] * ac[..., 0])


def _corner_turns(corners: FloatArray) -> FloatArray:
    return _turns(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0))


def _drop_flat(corners: FloatArray) -> FloatArray:
    """Without corners in the middle of a straight edge."""
    return corners[np.abs(_corner_turns(corners)) > FLAT]


def _edges_cross(corners: FloatArray) -> bool:
    """Whether an edge meets one that is not beside it, or doubles back on one that is."""
    count = len(corners)
    first, second = np.triu_indices(count, 2)
    apart = (second - first) % count != count - 1
    a, b = corners[first[apart]], corners[(first[apart] + 1) % count]
    c, d = corners[second[apart]], corners[(second[apart] + 1) % count]
    straddles = (_turns(a, b, c) * _turns(a, b, d) <= 0.0) & (_turns(c, d, a) * _turns(c, d, b) <= 0.0)
    overlaps = (np.minimum(a, b) <= np.maximum(c, d)).all(axis=1) & (np.minimum(c, d) <= np.maximum(a, b)).all(axis=1)
    before, after = corners - np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0) - corners
    doubles = (_turns(np.zeros(2), before, after) == 0.0) & (np.sum(before * after, axis=1) < 0.0)
    return bool((straddles & overlaps).any() or doubles.any())


def _cut_ears(corners: FloatArray) -> list[FloatArray]:
    """Triangles of a simple polygon, both counter-clockwise: cut off a corner with no other in its triangle, repeat."""
    triangles = []
    while len(corners) > 3:
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        turns = _turns(before, corners, after)
        for ear in np.argsort(-turns):  # large triangles first: fewer are slender
            a, b, c = before[ear], corners[ear], after[ear]
            others = np.delete(corners, [ear - 1, ear, (ear + 1) % len(corners)], axis=0)
            inside = (_turns(a, b, others) >= 0.0) & (_turns(b, c, others) >= 0.0) & (_turns(c, a, others) >= 0.0)
            if turns[ear] > 0.0 and not inside.any():
                break
        else:
            raise ValueError("the polygon cannot be split")
        triangles.append(np.stack([a, b, c]))
        corners = _drop_flat(np.delete(corners, ear, axis=0))
    return [*triangles, corners]
