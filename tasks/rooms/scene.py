"""From a room to a compiled scene: the robot, the floor and the goal of the project's own rooms, and its obstacles."""

import re
from collections import Counter
from functools import cache, lru_cache

import mujoco
import numpy as np
from scipy import ndimage

from tasks.errors import TaskError
from tasks.laser import BeamRing, set_beams
from tasks.physics import FloatArray
from tasks.robots.names import PIONEER
from tasks.robots.replacement import replace_robot
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.free_space import CELL
from tasks.room_geometry.grid import BoolArray, Grid
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.fence import build_fence, find_extent, find_fence
from tasks.rooms.free_floor import label_pieces
from tasks.rooms.limits import MAX_AREA, MAX_WIDTH, check_obstacles
from tasks.rooms.room import HEIGHT, Point, Room, Shape
from tasks.rooms.slots import add_slots
from tasks.scene.checks import find_invalid_number
from tasks.scene.loading import MODELS

TEMPLATE = MODELS / "own_room.xml"
# A room has walls if they enclose so much free floor, m², and so large a share of what lies open around it: a closet on
# an open floor is no room.
ENCLOSED_FROM, ENCLOSED_SHARE = 2.0, 0.25
SLOTS = 256  # a generated room has up to 250 obstacles, and a fence four
CAMERA_ANGLE = 45.0  # degrees, of the camera above
_TYPES = {
    Shape.BOX: mujoco.mjtGeom.mjGEOM_BOX,
    Shape.CYLINDER: mujoco.mjtGeom.mjGEOM_CYLINDER,
    Shape.SPHERE: mujoco.mjtGeom.mjGEOM_SPHERE,
    Shape.HULL: mujoco.mjtGeom.mjGEOM_MESH,
}


def compile_room(room: Room, ring: BeamRing | None = None, robot: str = PIONEER) -> mujoco.MjModel:
    """The compiled scene of a room; arguments and errors are those of build_scene."""
    return _compile(build_scene(room, ring, robot))


@lru_cache(maxsize=4)
def build_scene(room: Room, ring: BeamRing | None = None, robot: str = PIONEER) -> mujoco.MjSpec:
    """A room with the robot, at the widest free place, as a scene; around one without walls stands a fence.

    It is built once for all robots of a process; do not change it.

    Args:
        room: its obstacles.
        ring: beams of the laser; None leaves the robot's own.
        robot: its name.

    Raises:
        TaskError: MuJoCo takes an obstacle for invalid, or no place is free.
    """
    check_obstacles(room.obstacles)
    spec = _add_obstacles(room, ring, robot)
    low, high = find_extent(room)
    _check_area(low, high)
    floor = _enclosed_floor(_compile(spec)) if _holds_pairs(room) else None
    if floor is None:
        low, high = find_fence(low, high)
        _check_area(low, high)
        _add_fence(spec, low, high)
        floor = _enclosed_floor(_compile(spec))
    if floor is None:
        raise TaskError("the room leaves no free place that the robot fits in")
    x, y = room.pairs[0][0][:2] if room.pairs else _widest_place(*floor)
    spec.body("base").pos = [x, y, 0.0]
    _add_camera(spec, low, high)
    return spec


@cache
def _template(ring: BeamRing | None, robot: str) -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(TEMPLATE))
    replace_robot(spec, robot)
    if ring is not None:
        set_beams(spec, ring)
    return spec


def _compile(spec: mujoco.MjSpec) -> mujoco.MjModel:
    try:
        model = spec.compile()
    except ValueError as error:
        raise TaskError(f"the room cannot be compiled: {' '.join(str(error).split())}") from error
    if fault := find_invalid_number(model):
        raise TaskError(f"the room {fault}")
    return model


# Obstacles ------------------------------------------------------------------------------------------------------------


def _add_obstacles(room: Room, ring: BeamRing | None, robot: str) -> mujoco.MjSpec:
    spec = _template(ring, robot).copy()
    for name, obstacle in zip(_choose_names(room, spec), room.obstacles, strict=True):
        mesh = f"{name}_points" if obstacle.shape is Shape.HULL else ""
        if mesh:
            spec.add_mesh(name=mesh, uservert=np.ravel(obstacle.points))
        if obstacle.mass:
            body = spec.worldbody.add_body(name=name, pos=obstacle.position, quat=obstacle.quaternion)
            body.add_freejoint()
            geom = body.add_geom(spec.find_default("movable"), name=name, mass=obstacle.mass)
        else:
            geom = spec.worldbody.add_geom(spec.find_default("obstacle"), name=name)
            geom.pos, geom.quat = obstacle.position, obstacle.quaternion
        geom.type, geom.meshname = _TYPES[obstacle.shape], mesh
        geom.size[: len(obstacle.size)] = obstacle.size
    return spec


def _choose_names(room: Room, spec: mujoco.MjSpec) -> list[str]:
    """A name for each obstacle that no other and no part of the robot has: those of the same name are numbered.

    All of them, from 1: `box` beside `box_1` would name both, as a table's name does its legs.
    """
    wanted = [_plain(obstacle.name or str(obstacle.shape)) for obstacle in room.obstacles]
    counts, numbers = Counter(wanted), Counter[str]()
    robot = {element.name for part in (spec.geoms, spec.bodies, spec.meshes) for element in part}
    taken = robot | {name for name in wanted if counts[name] == 1}
    names = []
    for name in wanted:
        chosen = name
        while counts[name] > 1 or name in robot:
            numbers[name] += 1
            chosen = f"{name}_{numbers[name]}"
            if chosen not in taken:
                break
        taken.add(chosen)
        names.append(chosen)
    return names


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name).strip("_")[:60] or "obstacle"


# Around them ----------------------------------------------------------------------------------------------------------


def _check_area(low: FloatArray, high: FloatArray) -> None:
    width, depth = (high - low).tolist()
    if width * depth > MAX_AREA or max(width, depth) > MAX_WIDTH:
        size = f"larger than {MAX_AREA:,} m² or longer than {MAX_WIDTH:g} m"
        raise TaskError(f"a room of {width:.0f} × {depth:.0f} m is {size}")


def _holds_pairs(room: Room) -> bool:
    """Whether its starts and goals lie among its obstacles."""
    low, high = find_extent(Room(room.obstacles))
    places = np.array([each[:2] for start, goal in room.pairs for each in (start, goal)]).reshape(-1, 2)
    return bool(((places > low) & (places < high)).all())


def _add_fence(spec: mujoco.MjSpec, low: FloatArray, high: FloatArray) -> None:
    for side in build_fence(low, high):
        geom = spec.worldbody.add_geom(spec.find_default("wall"), name=side.name)
        geom.type, geom.pos, geom.size = mujoco.mjtGeom.mjGEOM_BOX, side.position, side.size


def _add_camera(spec: mujoco.MjSpec, low: FloatArray, high: FloatArray) -> None:
    """The camera `top`, which sees the whole room."""
    spec.worldbody.add_camera(name="top", pos=place_camera(low, high), quat=(1, 0, 0, 0), fovy=CAMERA_ANGLE)


def place_camera(low: FloatArray, high: FloatArray) -> tuple[float, float, float]:
    """Place above a floor of these corners from where the whole of it is seen, metres."""
    (x, y), (width, depth) = (low + high) / 2, high - low
    return x, y, 1.1 * max(width, depth) / 2 / np.tan(np.radians(CAMERA_ANGLE / 2)) + HEIGHT


def compile_slots(ring: BeamRing | None = None, robot: str = PIONEER) -> mujoco.MjModel:
    """The compiled scene of a room that changes at run time; it is empty."""
    spec = _template(ring, robot).copy()
    add_slots(spec, SLOTS)
    _add_camera(spec, np.full(2, -4.0), np.full(2, 4.0))
    return _compile(spec)


# Free floor -----------------------------------------------------------------------------------------------------------


def _enclosed_floor(model: mujoco.MjModel) -> tuple[Grid, BoolArray] | None:
    """The largest piece of free floor that walls enclose, as cells (rows, columns) of a grid; None without one."""
    try:
        grid = Grid(Obstacles.from_model(model), Footprint.from_model(model).radius, CELL)
    except TaskError:  # the room has no obstacle
        return None
    pieces = label_pieces(grid)
    is_room = pieces.enclosed.max() >= max(ENCLOSED_FROM, ENCLOSED_SHARE * pieces.outside)
    return (grid, pieces.labels == pieces.enclosed.argmax()) if is_room else None


def _widest_place(grid: Grid, floor: BoolArray) -> Point:
    """The place of a piece of floor that is farthest from its edges, metres."""
    x, y = grid.points[int(ndimage.distance_transform_edt(floor).argmax())].tolist()
    return x, y
