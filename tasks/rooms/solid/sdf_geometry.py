"""What collides in SDF: the geometry of a collision as solids."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.rooms.room import Shape
from tasks.rooms.solid.collector import Collector, quote
from tasks.rooms.solid.files import UnreadError
from tasks.rooms.solid.meshes import (
    MAX_PIECES,
    THICKNESS,
    Pieces,
    ellipsoid_points,
    plates,
    read_mesh,
    reduce_to_hull,
    split_into_hulls,
)
from tasks.rooms.solid.sdf_files import SdfFiles
from tasks.rooms.solid.transforms import Transform
from tasks.rooms.solid.xml_file import parse_numbers, parse_sizes, shorten

_HORIZONTAL = 0.9999  # of the vertical part of a plane's normal: a floor


class Solid(NamedTuple):
    """A shape in its own frame: sizes as an Obstacle has them, points (n, 3) of a hull, metres."""

    shape: Shape
    size: tuple[float, ...] = ()
    points: FloatArray | None = None


@dataclass(frozen=True)
class _Where:
    """Of a collision: its name, its pose in the world, and the folder of the file it stands in."""

    name: str
    pose: Transform
    folder: Path


class Geometries:
    """Reads the geometry of collisions; each mesh file once."""

    def __init__(self, files: SdfFiles, collector: Collector) -> None:
        """Floors and what is not read go to the collector."""
        self._files = files
        self._collector = collector
        self._meshes: dict[tuple[str, Path, str], Pieces | UnreadError] = {}

    def read(self, collision: Element, name: str, pose: Transform, folder: Path) -> list[Solid]:
        """The solids of a collision; one that cannot be taken is named.

        Args:
            collision: its element.
            name: for messages.
            pose: in the world.
            folder: of the file that it stands in.

        Raises:
            TaskError: a number is invalid.
        """
        where = _Where(name, pose, folder)
        solids: list[Solid] = []
        for element in collision.iterfind("geometry/*"):
            try:
                reader = _READERS.get(element.tag)
                if reader is None:
                    raise UnreadError(f"the geometry {shorten(element.tag)} is not read")
                solids += reader(self, element, where)
            except UnreadError as error:
                self._collector.omit(quote(name), str(error))
        return solids

    def _box(self, element: Element, where: _Where) -> list[Solid]:
        return [Solid(Shape.BOX, tuple(side / 2 for side in _sizes(element, "size", where, 3)))]

    def _sphere(self, element: Element, where: _Where) -> list[Solid]:
        return [Solid(Shape.SPHERE, _sizes(element, "radius", where))]

    def _cylinder(self, element: Element, where: _Where) -> list[Solid]:
        radius, length = _sizes(element, "radius", where) + _sizes(element, "length", where)
        return [Solid(Shape.CYLINDER, (radius, length / 2))]

    def _capsule(self, element: Element, where: _Where) -> list[Solid]:
        radius, length = _sizes(element, "radius", where) + _sizes(element, "length", where)
        return [_hull(ellipsoid_points([radius] * 3, length / 2))]

    def _ellipsoid(self, element: Element, where: _Where) -> list[Solid]:
        return [_hull(ellipsoid_points(_sizes(element, "radii", where, 3)))]

    def _empty(self, element: Element, where: _Where) -> list[Solid]:
        return []

    def _plane(self, element: Element, where: _Where) -> list[Solid]:
        what = f"the normal of the plane of {quote(where.name)}"
        normal = np.array(parse_numbers(element.findtext("normal", "0 0 1"), 3, what))
        length = np.hypot.reduce(normal)
        if length < 1e-6:
            raise TaskError(f"{what} is 0 0 0, which is no direction")
        if (where.pose.rotation @ normal)[2] < _HORIZONTAL * length:
            raise UnreadError("a plane that is not a floor is not read")
        self._collector.add_floor(quote(where.name), where.pose.position[2])
        return []

    def _polyline(self, element: Element, where: _Where) -> list[Solid]:
        """A prism on z = 0; one whose outline is not convex, as a wall along it."""
        what = f"a point of the polyline of {quote(where.name)}"
        outline = np.array([parse_numbers(point.text, 2, what) for point in element.iterfind("point")]).reshape(-1, 2)
        (height,) = _sizes(element, "height", where)
        low, high = (np.insert(outline, 2, z, axis=1) for z in (0.0, height))
        try:
            area = ConvexHull(outline).volume
        except (QhullError, ValueError) as error:
            raise UnreadError("the polyline encloses no area") from error
        x, y = outline.T
        if abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2 > 0.99 * area:
            return [_hull(np.concatenate([low, high]))]
        if len(outline) > MAX_PIECES:
            raise UnreadError(f"the polyline has more than {MAX_PIECES:,} points")
        self._name_hollow(where, "the polyline is not convex")
        sides = np.stack([low, np.roll(low, -1, axis=0), np.roll(high, -1, axis=0), high], axis=1)
        return [_hull(points) for points in plates(sides)]

    def _mesh(self, element: Element, where: _Where) -> list[Solid]:
        if element.find("submesh") is not None:
            raise UnreadError("a part of a mesh, <submesh>, is not read")
        uri, scale = element.findtext("uri", "").strip(), element.findtext("scale", "1 1 1")
        key = (uri, where.folder, scale)
        if key not in self._meshes:
            try:
                self._meshes[key] = self._split(uri, scale, where)
            except UnreadError as error:
                self._meshes[key] = UnreadError(f"the mesh {shorten(uri)} is left out: {error}")
        pieces = self._meshes[key]
        if isinstance(pieces, UnreadError):
            raise pieces
        if pieces.is_hollow:
            self._name_hollow(where, f"not all parts of the mesh {shorten(uri)} are convex")
        if pieces.is_filled:
            reason = f"a part of the mesh {shorten(uri)} is not convex and has more than {MAX_PIECES:,} triangles"
            self._collector.omit(f"the hollows of {quote(where.name)}", f"{reason}, so that its hull stands for it")
        return [Solid(Shape.HULL, points=points) for points in pieces.hulls]

    def _split(self, uri: str, scale: str, where: _Where) -> Pieces:
        factors = parse_numbers(scale, 3, f"the scale of the mesh of {quote(where.name)}")
        if not all(factors):
            raise TaskError(f"the scale of the mesh of {quote(where.name)} is {shorten(scale)!r}, but must not be 0")
        path = self._files.find(uri, where.folder)
        try:
            points, triangles = read_mesh(path)
        except TaskError as error:
            raise UnreadError(str(error)) from error
        return split_into_hulls(points * factors, triangles)

    def _name_hollow(self, where: _Where, reason: str) -> None:
        what = f"{reason}, so that plates of {THICKNESS * 100:g} cm stand for the surface"
        self._collector.omit(f"the inside of {quote(where.name)}", what)


def _sizes(element: Element, tag: str, where: _Where, count: int = 1) -> tuple[float, ...]:
    what = f"the {tag} of the {element.tag} {quote(where.name)}"
    return tuple(parse_sizes(element.findtext(tag), count, what))


def _hull(points: FloatArray) -> Solid:
    return Solid(Shape.HULL, points=reduce_to_hull(points))


_READERS: dict[str, Callable[[Geometries, Element, _Where], list[Solid]]] = {
    kind: getattr(Geometries, f"_{kind}")
    for kind in ("box", "sphere", "cylinder", "capsule", "ellipsoid", "empty", "plane", "polyline", "mesh")
}
