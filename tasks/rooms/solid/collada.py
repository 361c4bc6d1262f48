"""COLLADA files: the triangles of their scene, as Gazebo takes them: in metres, without regard to the axis that is up.

What is not read or broken raises UnreadError.
"""

from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np
from scipy.spatial.transform import Rotation

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.rooms.solid.files import UnreadError
from tasks.rooms.solid.triangles import IntArray
from tasks.rooms.solid.xml_file import parse_numbers, read_xml

_MAX_INSTANCES = 1_000
_MAX_CORNERS = 1_000_000  # of all instances
_Matrix = FloatArray  # (4, 4)


def read_collada(path: Path) -> tuple[FloatArray, IntArray]:
    """Corners (n, 3), metres, and triangles (m, 3) of all geometries that the scene's nodes instantiate."""
    root = read_xml(path, ("COLLADA",))
    unit = root.find("asset/unit")
    scale = parse_numbers(unit.get("meter", "1"), 1, "its unit")[0] if unit is not None else 1.0
    geometries = {f"#{geometry.get('id')}": geometry for geometry in root.iterfind("library_geometries/geometry")}
    meshes: dict[str, tuple[FloatArray, IntArray]] = {}
    pieces: list[tuple[FloatArray, IntArray]] = []
    first = 0
    try:
        for scene in root.iterfind("library_visual_scenes/visual_scene"):
            for url, matrix in _instances(scene, np.eye(4)):
                if url not in meshes:
                    meshes[url] = _read_geometry(geometries[url])
                corners, triangles = meshes[url]
                pieces.append((corners @ matrix[:3, :3].T + matrix[:3, 3], triangles + first))
                first += len(corners)
                if len(pieces) > _MAX_INSTANCES or first > _MAX_CORNERS:
                    raise UnreadError(f"it has more than {_MAX_INSTANCES:,} geometries or {_MAX_CORNERS:,} corners")
    except (ValueError, KeyError, IndexError, AttributeError) as error:
        raise error if isinstance(error, TaskError) else UnreadError("the COLLADA file is broken") from error
    if not pieces:
        raise UnreadError("its scene has no geometry; scenes by reference, such as instance_node, are not read")
    corners, triangles = (np.concatenate(each) for each in zip(*pieces, strict=True))
    return corners * scale, triangles


def _instances(node: Element, outer: _Matrix) -> list[tuple[str, _Matrix]]:
    """Geometries below a node by their URL, each with its matrix into the scene."""
    matrix, found = outer, []
    for child in node:
        if child.tag in ("matrix", "translate", "rotate", "scale"):
            matrix = matrix @ _matrix(child)
        elif child.tag == "instance_geometry":
            found.append((child.get("url", ""), matrix))
        elif child.tag == "node":
            found += _instances(child, matrix)
        elif child.tag.startswith("instance_") and child.tag not in ("instance_light", "instance_camera"):
            raise UnreadError(f"COLLADA's {child.tag[:40]} is not read")
    return found


def _matrix(element: Element) -> _Matrix:
    if element.tag == "matrix":
        return np.array(parse_numbers(element.text, 16, "a matrix of a node")).reshape(4, 4)
    matrix = np.eye(4)
    if element.tag == "translate":
        matrix[:3, 3] = parse_numbers(element.text, 3, "a translation of a node")
    elif element.tag == "scale":
        matrix[:3, :3] = np.diag(parse_numbers(element.text, 3, "a scale of a node"))
    else:
        *axis, angle = parse_numbers(element.text, 4, "a rotation of a node")
        length = np.hypot.reduce(axis)
        if length:
            matrix[:3, :3] = Rotation.from_rotvec(np.array(axis) / length * angle, degrees=True).as_matrix()
    return matrix


def _read_geometry(geometry: Element) -> tuple[FloatArray, IntArray]:
    mesh = geometry.find("mesh")
    if mesh is None:
        raise UnreadError("one of its geometries is no mesh")
    sources = {f"#{source.get('id')}": source for source in mesh.iterfind("source")}
    position = mesh.find("vertices/input[@semantic='POSITION']")
    if position is None:
        raise UnreadError("one of its meshes has no corners")
    numbers = np.array(sources[position.get("source", "")].findtext("float_array", "").split(), dtype=np.float64)
    triangles = [_read_faces(faces) for faces in mesh if faces.tag in ("triangles", "polylist", "polygons")]
    if unread := [child.tag for child in mesh if child.tag in ("trifans", "tristrips")]:
        raise UnreadError(f"COLLADA's {unread[0]} is not read")
    return numbers.reshape(-1, 3), np.concatenate([np.zeros((0, 3), np.intp), *triangles])


def _read_faces(faces: Element) -> IntArray:
    """Triangles (m, 3) of corners; polygons become fans."""
    stride = max(int(each.get("offset", "0")) for each in faces.iterfind("input")) + 1
    vertex = faces.find("input[@semantic='VERTEX']")
    corner = int(vertex.get("offset", "0")) if vertex is not None else 0
    lists = [np.array((each.text or "").split(), dtype=np.intp) for each in faces.iterfind("p")]
    indices = [each.reshape(-1, stride)[:, corner] for each in lists]
    if faces.tag == "triangles":
        return np.concatenate(indices).reshape(-1, 3)
    if faces.tag == "polylist":
        counts = np.array(faces.findtext("vcount", "").split(), dtype=np.intp)
        indices = np.split(np.concatenate(indices), np.cumsum(counts)[:-1])
    fans = [(each[0], each[i], each[i + 1]) for each in indices for i in range(1, len(each) - 1)]
    return np.array(fans, dtype=np.intp).reshape(-1, 3)
