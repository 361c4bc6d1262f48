"""Rooms from worlds of IR-SIM."""

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray, Pose
from tasks.rooms.flat.flat_shapes import prism, split_polygon, to_quaternion, wall
from tasks.rooms.flat.plain_yaml import read_mapping
from tasks.rooms.limits import MAX_OBSTACLES, check_obstacles, to_length, to_number
from tasks.rooms.room import Obstacle, Room, box, cylinder

LINE_THICKNESS = 0.02  # m, of lines, which have none in IR-SIM
WALL_THICKNESS = 0.1  # m, of the walls around the world, outside of it
MAX_VERTICES = 200  # of a polygon or a line
MAX_ALL_VERTICES = 50_000
_ONLY_SHOWN = {"gui", "custom"}
_DEFAULT_STATE = ["1", "1", "0"]  # IR-SIM's


def read_irsim(path: Path) -> Room:
    """The room of an IR-SIM file: its obstacles at their states, and walls around its width and height.

    The robots are left out, and with them their starts and goals: a task has many.

    Raises:
        TaskError: the file is missing, broken or too large, or a value is out of range.
    """
    content = read_mapping(path)
    content = content["irsim"] if isinstance(content.get("irsim"), dict) else content
    try:
        if not content.keys() & {"world", "obstacle"}:
            raise TaskError("a world of IR-SIM has `world` or `obstacle`, and it has neither")
        reader = _Reader()
        reader.add_world(_mapping(content.get("world") or {}, "world"))
        entries = content.get("obstacle") or []
        for number, entry in enumerate(entries if isinstance(entries, list) else [entries], 1):
            reader.add_entry(f"obstacle {number}", _mapping(entry, f"obstacle {number}"))
        for name in content.keys() - {"world", "obstacle"} - _ONLY_SHOWN:
            reader.omit(
                str(name)[:40],
                "not taken, the task has a robot of its own" if name == "robot" else "no such key is read",
            )
        check_obstacles(reader.obstacles)
        return Room(tuple(reader.obstacles), tuple(reader.omitted))
    except TaskError as error:
        raise TaskError(f"{path}: {error}") from error


class _Reader:
    """Collects what becomes of a file's entries."""

    def __init__(self) -> None:
        self.obstacles: list[Obstacle] = []
        self.omitted: dict[str, None] = {}  # in order, each once
        self._vertices = 0

    def omit(self, name: str, reason: str) -> None:
        self.omitted[f"{name}: {reason}"] = None

    def add_world(self, world: dict[str, Any]) -> None:
        """Walls around the world's width (x) and height (y)."""
        width, height = (to_length(world.get(side, 10.0), f"the world's {side}") for side in ("width", "height"))
        x, y = _points([world.get("offset", ["0", "0"])], "the world's offset")[0]
        out = WALL_THICKNESS / 2
        east, north = x + width + out, y + height + out
        ring = np.array([(x - out, y - out), (east, y - out), (east, north), (x - out, north)])
        for begin, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            self.obstacles.append(wall(begin, end, WALL_THICKNESS, "world_wall"))
        if world.get("obstacle_map", "null") not in ("", "null", "~", "None"):
            self.omit("world", "its obstacle_map is not read; a picture is a room of its own")

    def add_entry(self, name: str, entry: dict[str, Any]) -> None:
        """The obstacles of one entry of `obstacle`."""
        count = int(to_number(entry.get("number", 1), f"{name}: number", 0, MAX_OBSTACLES))
        distribution = _mapping(entry.get("distribution") or {}, f"{name}: distribution").get("name", "manual")
        if distribution != "manual":
            return self.omit(name, f"its places are drawn anew each time (distribution {_quote(distribution)})")
        if _is_true(entry.get("unobstructed")):
            return self.omit(name, "robots drive through it (unobstructed)")
        kinematics = _mapping(entry.get("kinematics") or {}, f"{name}: kinematics").get("name", "static")
        if kinematics != "static" and not _is_true(entry.get("static")):
            self.omit(name, f"its motion (kinematics {_quote(kinematics)}) is not taken, it stands where it begins")
        if "mass" in entry:
            self.omit(name, "its mass is not taken, it stands fast")
        states = _spread(entry.get("state", _DEFAULT_STATE), count, f"{name}: state")
        shapes = _spread(entry.get("shape") or {"name": "circle"}, count, f"{name}: shape")
        for state, shape in zip(states, shapes, strict=True):
            self._add_shape(name, _to_pose(state, f"{name}: state"), _mapping(shape, f"{name}: shape"))
            if len(self.obstacles) > MAX_OBSTACLES:
                raise TaskError(f"its obstacles are more than {MAX_OBSTACLES:,}")
        return None

    def _add_shape(self, name: str, pose: Pose, shape: dict[str, Any]) -> None:
        kind = str(shape.get("name", "circle")).lower()
        if _is_true(shape.get("random_shape")):
            return self.omit(name, "its shape is drawn anew each time (random_shape)")
        ahead = to_number(shape.get("wheelbase", 0.0), f"{name}: wheelbase") / 2  # of the rear axle, a car's place
        if kind == "circle":
            local = _points([shape.get("center", ["0", "0"])], f"{name}: center") + np.array([ahead, 0.0])
            (x, y), radius = _place(local, pose)[0].tolist(), to_length(shape.get("radius", 0.2), f"{name}: radius")
            self.obstacles.append(cylinder(x, y, radius, name))
        elif kind == "rectangle":
            x, y = _place(np.array([[ahead, 0.0]]), pose)[0].tolist()
            length, width = (to_length(shape.get(side, 1.0), f"{name}: {side}") for side in ("length", "width"))
            self.obstacles.append(box(x, y, length / 2, width / 2, to_quaternion(pose.yaw), name))
        elif kind in ("polygon", "linestring"):
            corners = _place(_points(shape.get("vertices"), f"{name}: vertices"), pose)
            self._vertices += len(corners)
            if self._vertices > MAX_ALL_VERTICES:
                raise TaskError(f"its polygons and lines have more than {MAX_ALL_VERTICES:,} vertices")
            self._add_polygon(name, corners) if kind == "polygon" else self._add_line(name, corners)
        else:
            self.omit(name, f"shape {_quote(kind)} is not read; circle, rectangle, polygon and linestring are")
        return None

    def _add_polygon(self, name: str, corners: FloatArray) -> None:
        try:
            pieces = split_polygon(corners)
        except ValueError as error:
            return self.omit(name, str(error))
        self.obstacles += [prism(piece, name) for piece in pieces]
        return None if pieces else self.omit(name, "the polygon has no area")

    def _add_line(self, name: str, corners: FloatArray) -> None:
        self.obstacles += [wall(begin, end, LINE_THICKNESS, name) for begin, end in pairwise(corners)]


def _spread(value: object, count: int, name: str) -> list[Any]:
    """A value for each of `count` obstacles: the same for all, or a list's values, whose last stands for the rest."""
    if isinstance(value, list) and value and not isinstance(value[0], str):
        return [value[min(index, len(value) - 1)] for index in range(count)]
    if not value:
        raise TaskError(f"{name} must not be empty")
    return [value] * count


def _to_pose(state: object, name: str) -> Pose:
    if not isinstance(state, list) or len(state) < 2:
        raise TaskError(f"{name} must be [x, y, theta]")
    return Pose(*(to_number(each, name) for each in [*state, 0.0][:3]))


def _points(value: object, name: str) -> FloatArray:
    """Points [x, y], one or more: (n, 2), metres."""
    if not isinstance(value, list) or not 1 <= len(value) <= MAX_VERTICES:
        raise TaskError(f"{name} must be 1 to {MAX_VERTICES} points")
    if not all(isinstance(point, list) and len(point) >= 2 for point in value):
        raise TaskError(f"{name} must be of numbers [x, y]")
    return np.array([[to_number(each, name) for each in point[:2]] for point in value])


def _place(points: FloatArray, pose: Pose) -> FloatArray:
    """Points of an object's own frame in the world, metres."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]) + [pose.x, pose.y])


def _mapping(value: object, name: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise TaskError(f"{name} must be a mapping of names and values")
    return value


def _is_true(value: object) -> bool:
    return str(value).lower() in ("true", "yes", "on", "1")


def _quote(value: object) -> str:
    return repr(str(value)[:40])
