"""Meshes and round solids as convex hulls of points."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError

from tasks.physics import FloatArray
from tasks.rooms.limits import read_bytes
from tasks.rooms.solid.collada import read_collada
from tasks.rooms.solid.files import UnreadError
from tasks.rooms.solid.triangles import IntArray, read_obj, read_stl

MAX_TRIANGLES = 200_000  # of a mesh
MAX_PIECES = 1_000  # that a mesh may become
MAX_POINTS = 100  # of a hull; more make contacts slow
DEEPEST = 0.05  # m below the hull of a part that its surface may lie for the hull to stand for it
_LIKE = 0.2  # of a hull's area that the area of such a part may differ by
_LOOKED_AT = 2_000  # triangles, the largest, of a part
THICKNESS = 0.01  # m, of the surface that stands for other pieces
_LARGEST = 1e6
_THINNEST = 1e-4  # m, of a triangle or a hull; MuJoCo refuses solids without volume
_WELD = 1e-6  # of a mesh's extent; nearer corners are one


@dataclass(frozen=True)
class Pieces:
    """Convex pieces of a mesh.

    Attributes:
        hulls: points (n, 3) of each, metres, the mesh's frame.
        is_hollow: a part that is not convex, or open, became plates on its surface.
        is_filled: a part that is not convex has too many triangles for plates: its hull stands for it.
    """

    hulls: tuple[FloatArray, ...]
    is_hollow: bool = False
    is_filled: bool = False


def read_mesh(path: Path) -> tuple[FloatArray, IntArray]:
    """Corners (n, 3), the file's unit, and triangles (m, 3) of their indices, of an OBJ, STL or COLLADA file.

    Raises:
        TaskError: no such file, another format, or a file that is broken or too large; mostly UnreadError.
    """
    match path.suffix.lower():
        case ".obj":
            points, triangles = read_obj(read_bytes(path))
        case ".stl":
            points, triangles = read_stl(read_bytes(path))
        case ".dae":
            points, triangles = read_collada(path)
        case suffix:
            raise UnreadError(f"{suffix or 'a file without a suffix'} is not read, but .obj, .stl and .dae are")
    if not len(triangles):
        raise UnreadError("it has no triangles")
    if len(triangles) > MAX_TRIANGLES:
        raise UnreadError(f"it has {len(triangles):,} triangles, but at most {MAX_TRIANGLES:,} are read")
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise UnreadError("a triangle has a corner that does not exist")
    if not np.all(np.abs(points) <= _LARGEST):
        raise UnreadError(f"a corner has a coordinate that is not a number of at most {_LARGEST:,.0f}")
    return points, triangles


def split_into_hulls(points: FloatArray, triangles: IntArray) -> Pieces:
    """Convex pieces of a mesh: the hull of each part whose triangles hang together, if the part fills it.

    Args:
        points: corners (n, 3), metres.
        triangles: (m, 3), indices of corners.

    Raises:
        UnreadError: the mesh has too many pieces.
    """
    corners, triangles = _weld(points, triangles)
    graph = coo_array((np.ones(2 * len(triangles)), (triangles[:, :2].ravel(), triangles[:, 1:].ravel())))
    graph.resize((len(corners), len(corners)))
    labels = connected_components(graph, directed=False)[1][triangles[:, 0]]
    order = np.argsort(labels, kind="stable")
    parts = np.split(triangles[order], np.flatnonzero(np.diff(labels[order])) + 1)
    hulls: list[FloatArray] = []
    is_hollow = is_filled = False
    for part in parts:
        hull = _hull(corners[np.unique(part)])
        is_convex = hull is not None and _fills(corners[part], hull)
        if hull is not None and (is_convex or len(part) > MAX_PIECES):
            hulls.append(_reduce(hull.points[hull.vertices]))
            is_filled = is_filled or not is_convex
        else:
            hulls += plates(corners[part])
            is_hollow = True
        if len(hulls) > MAX_PIECES:
            raise UnreadError(f"it has more than {MAX_PIECES:,} convex pieces")
    return Pieces(tuple(hulls), is_hollow, is_filled)


def plates(polygons: FloatArray) -> list[FloatArray]:
    """Flat convex polygons (n, corners, 3) as plates of THICKNESS: points of each, metres; tiny ones are left out."""
    normals = np.cross(polygons[:, 1] - polygons[:, 0], polygons[:, 2] - polygons[:, 0])
    lengths = np.hypot.reduce(normals, axis=1)
    longest = np.hypot.reduce(polygons - np.roll(polygons, 1, axis=1), axis=2).max(axis=1)
    kept = lengths > _THINNEST * longest
    offsets = (normals[kept] / lengths[kept, None])[:, None] * THICKNESS / 2
    return list(np.concatenate([polygons[kept] - offsets, polygons[kept] + offsets], axis=1))


def reduce_to_hull(points: FloatArray) -> FloatArray:
    """The points (n, 3), metres, that span the convex hull of others, at most MAX_POINTS.

    Raises:
        UnreadError: they lie in a plane.
    """
    hull = _hull(points)
    if hull is None:
        raise UnreadError("it has no volume")
    return _reduce(hull.points[hull.vertices])


def ellipsoid_points(semi_axes: npt.ArrayLike, half_length: float = 0.0) -> FloatArray:
    """Points (n, 3), metres, on an ellipsoid; one cut at its equator and drawn apart along z is a capsule."""
    turn, height = np.meshgrid(np.arange(12) * np.pi / 6, np.linspace(-np.pi / 2, np.pi / 2, 8))
    ring = np.stack([np.cos(turn) * np.cos(height), np.sin(turn) * np.cos(height), np.sin(height)], axis=-1)
    points = ring.reshape(-1, 3) * np.asarray(semi_axes)
    points[:, 2] += np.copysign(half_length, points[:, 2])
    return np.unique(points.round(9), axis=0)


def _weld(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Make corners at one place one; drop corners of no triangle, and triangles with two corners at one place."""
    used = points[triangles.ravel()]
    unit = max(float(np.ptp(used, axis=0).max()) * _WELD, 1e-12)
    _, first, index = np.unique(np.round(used / unit), axis=0, return_index=True, return_inverse=True)
    welded = index.reshape(-1, 3)
    is_whole = (welded != np.roll(welded, 1, axis=1)).all(axis=1)
    if not is_whole.any():
        raise UnreadError("all its triangles are points or lines")
    return used[first], welded[is_whole]


def _hull(points: FloatArray) -> ConvexHull | None:
    """None for points in a plane."""
    try:
        hull = ConvexHull(points)
    except QhullError:
        return None
    return hull if 2 * hull.volume > _THINNEST * hull.area else None


def _fills(triangles: FloatArray, hull: ConvexHull) -> bool:
    """Whether a surface (n, 3, 3) is about that of its hull: it has its area, and lies nowhere deep below it."""
    sides = triangles[:, 1:] - triangles[:, :1]
    areas = np.hypot.reduce(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2
    if abs(areas.sum() - hull.area) > _LIKE * hull.area:
        return False
    facets = ConvexHull(_reduce(hull.points[hull.vertices])).equations  # of fewer points
    middles = triangles[np.argsort(areas)[-_LOOKED_AT:]].mean(axis=1)
    return bool((middles @ facets[:, :3].T + facets[:, 3]).max(axis=1).min() >= -DEEPEST)


def _reduce(points: FloatArray) -> FloatArray:
    """At most MAX_POINTS of a hull's points: the farthest in directions spread over the sphere."""
    if len(points) <= MAX_POINTS:
        return points
    number = np.arange(MAX_POINTS)
    z, turn = (2 * number + 1) / MAX_POINTS - 1, number * np.pi * (3 - np.sqrt(5))
    flat = np.sqrt(1 - z**2)
    directions = np.stack([flat * np.cos(turn), flat * np.sin(turn), z])
    return np.asarray(points[np.unique((points @ directions).argmax(axis=0))])
