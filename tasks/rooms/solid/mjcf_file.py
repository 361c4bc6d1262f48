"""MJCF of others before MuJoCo sees it: includes in their place, nothing but solids, and bounded.

MuJoCo would read any file that the MJCF names, and build a million geoms of one <replicate>.
"""

from collections.abc import Callable
from pathlib import Path
from xml.etree.ElementTree import Element

from tasks.errors import TaskError
from tasks.rooms.limits import MAX_BYTES
from tasks.rooms.solid.collector import MAX_OBSTACLES, Collector, quote
from tasks.rooms.solid.files import UnreadError, find_within
from tasks.rooms.solid.meshes import read_mesh
from tasks.rooms.solid.xml_file import MAX_DEPTH, MAX_ELEMENTS, parse_numbers, read_xml, shorten

_ASSETS = ("mesh", "hfield")
_BODY = ("body", "frame", "replicate", "geom", "joint", "freejoint", "inertial")
_DEFAULTS = ("default", "geom", "joint", "mesh")
_NAMED = ("composite", "flexcomp", "attach")  # of a body, and solid
# Attributes that solids need; numbers are checked.
_WORDS = """angle eulerseq autolimits inertiafromgeom inertiagrouprange balanceinertia name class childclass type mesh
    hfield file content_type inertia builtin shellinertia mocap sep align contype conaffinity group count nrow ncol
    maxhullvert"""
_NUMBERS = """pos size quat euler axisangle xyaxes zaxis axis fromto offset scale vertex face params refpos refquat ref
    mass density fitscale diaginertia fullinertia boundmass boundinertia settotalmass"""
_KEPT = {*_WORDS.split(), *_NUMBERS.split()}
_FINEST = 200  # of the resolution of a mesh that MuJoCo makes
_MAX_CELLS = 4_000_000  # of a height field


def read_solids(path: Path, collector: Collector) -> Element:
    """The root of an MJCF file with its includes, reduced to compiler, defaults, meshes, bodies, joints and geoms.

    The project's robot and its goal are left out. Names of files are absolute.

    Args:
        path: of the file.
        collector: takes the names of solids that are left out.

    Raises:
        TaskError: a file is broken, lies elsewhere than in the folder of the first or below, or is beyond a limit.
    """
    root = _Includes(path).read()
    folders = _Folders(root, path.parent)
    for section in list(root):
        match section.tag:
            case "compiler":
                _keep(section, ())
            case "default":
                _keep(section, _DEFAULTS)
            case "asset":
                _keep(section, _ASSETS)
                for asset in section:
                    _check_asset(asset, folders)
            case "worldbody":
                _leave_out_robot(section)
                _name_unread(section, collector)
                _keep(section, _BODY)
            case tag:
                if tag == "deformable":
                    collector.omit("deformable things", "they are not read")
                root.remove(section)
    _check_numbers(root)
    num_geoms = sum(_count_geoms(section) for section in root.iterfind("worldbody"))
    if num_geoms > MAX_OBSTACLES:
        raise TaskError(f"it has more than {MAX_OBSTACLES:,} geoms")
    return root


class _Includes:
    """Puts the content of included files where MuJoCo does, each file once."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._seen = {path.resolve()}
        self._num_elements = 0

    def read(self) -> Element:
        root = read_xml(self._path, ("mujoco",))
        self._expand(root, self._path.parent, 0)
        return root

    def _expand(self, element: Element, folder: Path, depth: int) -> None:
        if depth > MAX_DEPTH:
            raise TaskError(f"it has more than {MAX_DEPTH} elements inside one another")
        children = []
        for child in element:
            self._num_elements += 1
            if self._num_elements > MAX_ELEMENTS:
                raise TaskError(f"it has more than {MAX_ELEMENTS:,} elements")
            if child.tag == "include":
                children += self._read_include(child.get("file", ""), folder, depth)
            else:
                self._expand(child, folder, depth + 1)
                children.append(child)
        element[:] = children

    def _read_include(self, name: str, folder: Path, depth: int) -> list[Element]:
        try:
            path = find_within([self._path.parent / name, folder / name], [self._path.parent])
        except UnreadError as error:
            raise TaskError(f"it includes {quote(name)}, but {error}") from error
        if path in self._seen:
            raise TaskError(f"it includes {quote(name)} twice, or in a circle")
        self._seen.add(path)
        root = read_xml(path, ("mujoco", "mujocoinclude"))
        self._expand(root, path.parent, depth)
        return list(root)


class _Folders:
    """Where files of assets lie, as the compiler element says."""

    def __init__(self, root: Element, home: Path) -> None:
        options: dict[str, str] = {}
        for compiler in root.iterfind("compiler"):
            options |= compiler.attrib
        self._home = home
        self._meshes = home / options.get("meshdir", options.get("assetdir", ""))
        self._strips = options.get("strippath") == "true"

    def find(self, asset: Element) -> Path:
        name = asset.get("file", "")
        folder = self._meshes if asset.tag == "mesh" else self._home
        try:
            path = find_within([folder / (Path(name).name if self._strips else name)], [self._home])
        except UnreadError as error:
            raise TaskError(f"it has the {asset.tag} {quote(name)}, but {error}") from error
        if path.stat().st_size > MAX_BYTES:
            raise TaskError(f"its {asset.tag} {quote(name)} is larger than {MAX_BYTES // 1_000_000} MB")
        return path


def _keep(element: Element, tags: tuple[str, ...]) -> None:
    """Remove all below an element but elements of these tags, and all attributes that solids do not need."""
    element[:] = [child for child in element if child.tag in tags]
    element.attrib = {name: text for name, text in element.attrib.items() if name in _KEPT}
    for child in element:
        _keep(child, tags)


def _check_asset(asset: Element, folders: _Folders) -> None:
    if asset.get("file"):
        path = folders.find(asset)
        if path.suffix.lower() in (".obj", ".stl"):  # what is broken in them, MuJoCo's Qhull prints over many lines
            try:
                read_mesh(path)
            except TaskError as error:
                raise TaskError(f"its mesh {quote(asset.get('file', ''))} cannot be read: {error}") from error
        asset.attrib.setdefault("name", Path(asset.get("file", "")).stem)
        asset.set("file", str(path))
    elif asset.tag == "hfield":
        rows, columns = (_whole(asset.get(each), f"the {each} of a height field") for each in ("nrow", "ncol"))
        if rows * columns > _MAX_CELLS:
            raise TaskError(f"it has a height field of more than {_MAX_CELLS:,} cells")


def _leave_out_robot(worldbody: Element) -> None:
    """Remove the body `base` with the joint `base`, and with it the mocap body `goal`."""

    def is_robot(body: Element) -> bool:
        joints = [child.get("name") for child in body if child.tag in ("joint", "freejoint")]
        return body.tag == "body" and body.get("name") == "base" and "base" in joints

    def is_goal(body: Element) -> bool:
        return body.tag == "body" and body.get("name") == "goal" and body.get("mocap") == "true"

    _remove(worldbody, is_robot)
    _remove(worldbody, is_goal)


def _name_unread(worldbody: Element, collector: Collector) -> None:
    """Remove what MuJoCo would build of plugins, and name it with all else that is solid and not read."""
    for element in worldbody.iter():
        if element.tag in _NAMED:
            subject = element.get("name") or element.get("prefix") or element.get("model") or ""
            collector.omit(f"{element.tag} {quote(subject)}", f"<{element.tag}> is not read")

    def is_unread(element: Element) -> bool:
        is_shape_of_plugin = element.get("type") == "sdf" or element.find("plugin") is not None
        if is_geom := element.tag == "geom" and is_shape_of_plugin:
            collector.omit(f"geom {quote(element.get('name', ''))}", "shapes of plugins are not read")
        return is_geom

    _remove(worldbody, is_unread)


def _remove(element: Element, is_wanted: Callable[[Element], bool]) -> None:
    element[:] = [child for child in element if not is_wanted(child)]
    for child in element:
        _remove(child, is_wanted)


def _check_numbers(root: Element) -> None:
    for element in root.iter():
        for name in _NUMBERS.split():
            if (text := element.get(name)) is not None:
                what = f"the {name} of the {shorten(element.tag)} {quote(element.get('name', ''))}"
                numbers = parse_numbers(text, len(text.split()), what)
                if name == "params" and max(numbers, default=0.0) > _FINEST:
                    raise TaskError(f"{what} is {shorten(text)!r}, but must be at most {_FINEST}")


def _count_geoms(element: Element) -> int:
    """Geoms and bodies below an element, with those that <replicate> makes."""
    count = sum(_count_geoms(child) for child in element) + (element.tag in ("geom", "body"))
    if element.tag == "replicate":
        count = max(count, 1) * _whole(element.get("count"), "the count of a <replicate>")
    return count


def _whole(text: str | None, what: str) -> int:
    return round(parse_numbers(text or "0", 1, what)[0])
