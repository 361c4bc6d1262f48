"""OBJ and STL files: corners and triangles from bytes. What is broken raises UnreadError."""

import re

import numpy as np
import numpy.typing as npt

from tasks.physics import FloatArray
from tasks.rooms.solid.files import UnreadError

IntArray = npt.NDArray[np.intp]

_STL_HEADER = 84  # bytes, the number of triangles last
_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("colour", "<u2")])
_STL_CORNER = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)")


def read_stl(data: bytes) -> tuple[FloatArray, IntArray]:
    """Corners (3 m, 3) and triangles (m, 3) of a binary or ASCII STL file."""
    count = int.from_bytes(data[_STL_HEADER - 4 : _STL_HEADER], "little")
    if len(data) == _STL_HEADER + count * _STL_TRIANGLE.itemsize:
        corners = np.frombuffer(data, _STL_TRIANGLE, count, _STL_HEADER)["corners"].astype(np.float64).reshape(-1, 3)
    elif data.lstrip()[:5] == b"solid" and b"endsolid" in data:
        try:
            corners = np.array(_STL_CORNER.findall(data), dtype=np.float64).reshape(-1, 3)
        except ValueError as error:
            raise UnreadError("a corner of the STL file is no number") from error
    else:
        raise UnreadError("the STL file is truncated or broken")
    if len(corners) % 3:
        raise UnreadError("a triangle of the STL file lacks a corner")
    return corners, np.arange(len(corners)).reshape(-1, 3)


def read_obj(data: bytes) -> tuple[FloatArray, IntArray]:
    """Corners (n, 3) and triangles (m, 3) of an OBJ file; polygons become fans."""
    corners: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    try:
        for line in data.splitlines():
            kind, *words = line.split() or [b""]
            if kind == b"v":
                x, y, z = words[:3]
                corners.append([float(x), float(y), float(z)])
            elif kind == b"f":
                numbers = [int(word.split(b"/")[0]) for word in words]
                face = [number - 1 if number > 0 else len(corners) + number for number in numbers]
                triangles += [(face[0], face[i], face[i + 1]) for i in range(1, len(face) - 1)]
        indices = np.array(triangles, dtype=np.intp).reshape(-1, 3)
    except (ValueError, OverflowError) as error:
        raise UnreadError("the OBJ file is broken: a corner or face has something else than its numbers") from error
    return np.array(corners, dtype=np.float64).reshape(-1, 3), indices
