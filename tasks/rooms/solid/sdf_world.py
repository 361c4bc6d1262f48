"""Gazebo worlds and other SDF files as rooms."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree.ElementTree import Element

from tasks.errors import TaskError
from tasks.rooms.room import Room
from tasks.rooms.solid.collector import Collector, quote
from tasks.rooms.solid.files import UnreadError
from tasks.rooms.solid.sdf_files import SdfFiles
from tasks.rooms.solid.sdf_frames import Frames
from tasks.rooms.solid.sdf_geometry import Geometries, Solid
from tasks.rooms.solid.transforms import IDENTITY, Transform
from tasks.rooms.solid.xml_file import parse_sizes, shorten

MAX_MODELS = 20_000
_MAX_NESTING = 20  # of models in models
_LEFT_OUT = {"actor": "actors are not read", "population": "populations are not read"}


def read_world(path: Path, search: Sequence[Path] = ()) -> Room:
    """A Gazebo world or another SDF file, version 1.4 or later, as a room.

    A link is movable if it is one solid of a model that is neither static nor has joints. <state> is ignored.

    Args:
        path: of the file; a world, or models.
        search: folders that hold models, for model:// and relative URIs; the file's own is searched too.

    Raises:
        TaskError: the file is broken, has an invalid number, or is beyond a limit.
    """
    try:
        return _WorldReader(path, search).read()
    except TaskError as error:
        if str(path) in str(error):
            raise
        raise TaskError(f"the world {path} cannot be read: {error}") from error


@dataclass(frozen=True)
class _Model:
    """A model while it is read.

    Attributes:
        name: with those of the models around it.
        pose: in the world.
        files: that it stands in, the innermost last; a model of one of them would include itself.
        is_static: it, or a model around it.
        has_joints: it, or a model around it.
        depth: models around it.
    """

    name: str
    pose: Transform
    files: tuple[Path, ...]
    is_static: bool = False
    has_joints: bool = False
    depth: int = 0


class _WorldReader:
    def __init__(self, path: Path, search: Sequence[Path]) -> None:
        self._path = path
        self._files = SdfFiles(path, search)
        self._collector = Collector()
        self._geometries = Geometries(self._files, self._collector)
        self._num_models = 0

    def read(self) -> Room:
        root = self._files.world
        worlds = root.findall("world")
        if not worlds and root.find("model") is None:
            raise TaskError("it has neither a world nor a model")
        for world in worlds[1:]:
            self._collector.omit(f"the world {quote(world.get('name', ''))}", "only the first of a file is read")
        self._read_models(worlds[0] if worlds else root, _Model("", IDENTITY, (self._path.resolve(),)))
        return self._collector.room()

    def _read_models(self, element: Element, outer: _Model) -> Frames:
        """Read the models inside a world or model; its frames."""
        others, models = [], []
        for child in element:
            if child.tag == "model":
                models.append((child, outer.files))
            elif child.tag == "include":
                models += self._include(child, outer)
            else:
                others.append(child)
            if child.tag in _LEFT_OUT:
                self._collector.omit(f"{child.tag} {quote(child.get('name', ''))}", _LEFT_OUT[child.tag])
        frames = Frames([*others, *(model for model, _ in models)])
        for model, files in models:
            self._read_model(model, files, outer, frames)
        return frames

    def _include(self, include: Element, outer: _Model) -> list[tuple[Element, tuple[Path, ...]]]:
        """The included model and the files it stands in; nothing, and named, where it is not found."""
        uri = shorten(include.findtext("uri", ""))
        try:
            model, path = self._files.read_include(include, outer.files[-1].parent)
        except UnreadError as error:
            self._collector.omit(f"the model {uri}", str(error))
            return []
        if path in outer.files:
            raise TaskError(f"the model {uri} includes itself")
        return [(model, (*outer.files, path))]

    def _read_model(self, element: Element, files: tuple[Path, ...], outer: _Model, frames: Frames) -> None:
        self._num_models += 1
        if self._num_models > MAX_MODELS or outer.depth >= _MAX_NESTING:
            raise TaskError(f"it has more than {MAX_MODELS:,} models, or more than {_MAX_NESTING} inside one another")
        name = _join(outer.name, element)
        pose = self._place(element, name, frames)
        if pose is None:
            return
        is_static = outer.is_static or _is_true(element.findtext("static"))
        has_joints = outer.has_joints or element.find("joint") is not None
        model = _Model(name, outer.pose @ pose, files, is_static, has_joints, outer.depth + 1)
        inner = self._read_models(element, model)
        links = element.findall("link")
        for link in links:
            self._read_link(link, replace(model, name=_join(name, link)) if len(links) > 1 else model, inner)

    def _read_link(self, link: Element, model: _Model, frames: Frames) -> None:
        """Read a link; `model` has the link's name too, if the model has several."""
        inside = self._place(link, model.name, frames)
        if inside is None:
            return
        collisions = [each for each in link.findall("collision") if _is_solid(each)]
        found: list[tuple[str, Transform, Solid]] = []
        for collision in collisions:
            name = _join(model.name, collision) if len(collisions) > 1 else model.name
            if (pose := self._place(collision, name, frames, inside)) is not None:
                solids = self._geometries.read(collision, name, model.pose @ pose, model.files[-1].parent)
                found += [(name, model.pose @ pose, solid) for solid in solids]
        mass = self._mass(link, model, len(found)) if found else 0.0
        for name, pose, solid in found:
            self._collector.add(solid.shape, pose, solid.size, solid.points, mass=mass, name=name)

    def _place(self, element: Element, name: str, frames: Frames, inside: Transform = IDENTITY) -> Transform | None:
        """The pose of an element in its model; None, and named, where it cannot be known."""
        try:
            return frames.pose_of(element, inside)
        except UnreadError as error:
            self._collector.omit(quote(name), str(error))
            return None

    def _mass(self, link: Element, model: _Model, num_solids: int) -> float:
        """Of a link that is movable, kg; 0 for one that stands fixed, which is named unless it is static."""
        if model.is_static:
            return 0.0
        if model.has_joints:
            reason = "it has joints"
        elif num_solids > 1:
            reason = "it consists of several solids"
        elif _is_true(link.findtext("kinematic")) or not _is_true(link.findtext("gravity", "1")):
            reason = "no gravity acts on it"
        else:
            return parse_sizes(link.findtext("inertial/mass", "1"), 1, f"the mass of {quote(model.name)}")[0]
        self._collector.omit(f"the mobility of {quote(model.name)}", f"{reason}, so it stands fixed")
        return 0.0


def _join(outer: str, element: Element) -> str:
    return "_".join(filter(None, (outer, shorten(element.get("name", "") or element.tag))))


def _is_true(text: str | None) -> bool:
    return (text or "").strip().lower() in ("1", "true")


def _is_solid(collision: Element) -> bool:
    """Whether anything bounces off it: zones that only notice a contact have a bit mask of 0."""
    return collision.findtext("surface/contact/collide_bitmask", "1").strip().lower() not in ("0", "0x0", "0x00")
