"""Files that an SDF world is made of: included models and meshes, through a search path."""

import copy
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from xml.etree.ElementTree import Element

from tasks.errors import TaskError
from tasks.rooms.solid.files import UnreadError, find_within
from tasks.rooms.solid.xml_file import MAX_ELEMENTS, read_xml, shorten

_OVERRIDES = ("pose", "static")  # what an <include> says of the model it brings


class SdfFiles:
    """Finds and reads them, each once."""

    def __init__(self, path: Path, search: Sequence[Path]) -> None:
        """Of a world.

        Args:
            path: of its file; what is beside it is found first.
            search: folders that hold models.
        """
        self.path = path
        self._folders = (path.parent, *search)
        self._roots: dict[Path, Element] = {}
        self._found: dict[tuple[str, Path], Path] = {}
        self._descriptions: dict[Path, Path] = {}
        self._num_elements = 0

    @cached_property
    def world(self) -> Element:
        """The root of the world's file."""
        return self._read(self.path)

    def find(self, uri: str, folder: Path) -> Path:
        """The file or folder of a URI that stands in a file of `folder`. UnreadError without one."""
        if (uri, folder) not in self._found:
            self._found[uri, folder] = self._find(uri, folder)
        return self._found[uri, folder]

    def _find(self, uri: str, folder: Path) -> Path:
        scheme, colon, rest = uri.rpartition("://")
        if colon and scheme not in ("model", "package", "file"):
            raise UnreadError("only model://, package:// and file:// are read")
        beside = () if scheme in ("model", "package") else (folder / rest,)
        return find_within((*beside, *(each / rest for each in self._folders)), self._folders)

    def read_include(self, include: Element, folder: Path) -> tuple[Element, Path]:
        """The model that an <include> in a file of `folder` brings, as placed there, and its file.

        Raises:
            UnreadError: it is not found, or has no model.
            TaskError: as read_xml.
        """
        path = self.find(include.findtext("uri", "").strip(), folder)
        if path.is_dir():
            if path not in self._descriptions:
                self._descriptions[path] = _find_description(path)
            path = self._descriptions[path]
        found = self._read(path).find("model")
        if found is None:
            raise UnreadError(f"{path.name} has no model")
        model = copy.copy(found)
        name = include.findtext("name", "").strip()
        model.attrib = {**found.attrib, **({"name": name} if name else {})}
        for tag in _OVERRIDES:
            if (override := include.find(tag)) is not None:
                model[:] = [child for child in model if child.tag != tag]
                model.append(override)
        if placed := include.findtext("placement_frame", "").strip():
            model.set("placement_frame", placed)
        return model, path

    def _read(self, path: Path) -> Element:
        if path not in self._roots:
            root = read_xml(path, ("sdf",))
            self._num_elements += sum(1 for _ in root.iter())
            if self._num_elements > MAX_ELEMENTS:
                raise TaskError(f"it has, with its models, more than {MAX_ELEMENTS:,} elements")
            if not (1, 4) <= _version(root) < (2,):
                version = shorten(root.get("version", ""))
                raise TaskError(f"the file {path} is of SDF version {version!r}, but 1.4 and later are read")
            self._roots[path] = root
        return self._roots[path]


def _find_description(folder: Path) -> Path:
    """The SDF file of a model's folder, of the highest version that its model.config names."""
    name = "model.sdf"
    if (folder / "model.config").exists():
        config = read_xml(find_within([folder / "model.config"], [folder]), ("model",))
        versions = {_version(each): (each.text or "").strip() for each in config.iterfind("sdf")}
        name = versions[max(versions)] if versions else name
    return find_within([folder / name], [folder])


def _version(element: Element) -> tuple[int, ...]:
    words = element.get("version", "").split(".")
    return tuple(int(word) for word in words) if all(word.isdecimal() and len(word) < 5 for word in words) else ()
