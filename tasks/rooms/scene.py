"""From a room to a compiled scene: the robot, the floor and the goal of the project's own rooms, and its obstacles."""

import re
from functools import cache

import mujoco
import numpy as np
from scipy import ndimage

from tasks.errors import TaskError
from tasks.laser import set_beams
from tasks.physics import FloatArray
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.free_space import CELL
from tasks.room_geometry.grid import BoolArray, Grid
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.limits import check_obstacles
from tasks.rooms.room import HEIGHT, Obstacle, Point, Room, Shape
from tasks.scene.checks import find_invalid_number
from tasks.scene.loading import MODELS

TEMPLATE = MODELS / "own_room.xml"
FENCE_MARGIN = 6.0  # m around a room without walls: out of the laser's range, 5.6 m, from its obstacles
FENCE_THICKNESS = 0.05  # m
# A room has walls if they enclose so much free floor, m², and so large a share of what lies open around it: a closet on
# an open floor is no room.
ENCLOSED_FROM, ENCLOSED_SHARE = 2.0, 0.25
CAMERA_ANGLE = 45.0  # degrees, of the camera above
_TYPES = {
    Shape.BOX: mujoco.mjtGeom.mjGEOM_BOX,
    Shape.CYLINDER: mujoco.mjtGeom.mjGEOM_CYLINDER,
    Shape.SPHERE: mujoco.mjtGeom.mjGEOM_SPHERE,
    Shape.HULL: mujoco.mjtGeom.mjGEOM_MESH,
}


def compile_room(room: Room, num_beams: int | None = None) -> mujoco.MjModel:
    """The compiled scene of a room; arguments and errors are those of build_scene."""
    return _compile(build_scene(room, num_beams))


def build_scene(room: Room, num_beams: int | None = None) -> mujoco.MjSpec:
    """A room with the robot, at the widest free place, as a scene; around one without walls stands a fence.

    Args:
        room: its obstacles.
        num_beams: of the laser; None leaves the robot's own.

    Raises:
        TaskError: MuJoCo takes an obstacle for invalid, or no place is free.
    """
    check_obstacles(room.obstacles)
    spec = _add_obstacles(room, num_beams)
    low, high = _extent(room)
    floor = _enclosed_floor(_compile(spec)) if _holds_pairs(room) else None
    if floor is None:
        low, high = low - FENCE_MARGIN, high + FENCE_MARGIN
        _add_fence(spec, low, high)
        floor = _enclosed_floor(_compile(spec))
    if floor is None:
        raise TaskError("the room leaves no free place that the robot fits in")
    x, y = room.pairs[0][0][:2] if room.pairs else _widest_place(*floor)
    spec.body("base").pos = [x, y, 0.0]
    _add_camera(spec, low, high)
    return spec


@cache
def _template(num_beams: int | None) -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(TEMPLATE))
    if num_beams is not None:
        set_beams(spec, num_beams)
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


def _add_obstacles(room: Room, num_beams: int | None) -> mujoco.MjSpec:
    spec = _template(num_beams).copy()
    names = _Names(spec)
    for obstacle in room.obstacles:
        name = names.choose(obstacle.name or str(obstacle.shape))
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


class _Names:
    """Gives each obstacle a name of its own that no part of the robot has."""

    def __init__(self, spec: mujoco.MjSpec) -> None:
        self._taken = {element.name for part in (spec.geoms, spec.bodies, spec.meshes) for element in part}
        self._last: dict[str, int] = {}

    def choose(self, wanted: str) -> str:
        """The wanted name, or the first of name_1, name_2, … that is free."""
        wanted = re.sub(r"\W+", "_", wanted).strip("_")[:60] or "obstacle"
        name = wanted
        while name in self._taken:
            self._last[wanted] = self._last.get(wanted, 0) + 1
            name = f"{wanted}_{self._last[wanted]}"
        self._taken.add(name)
        return name


# Around them ----------------------------------------------------------------------------------------------------------


def _extent(room: Room) -> tuple[FloatArray, FloatArray]:
    """Corners of the smallest rectangle around obstacles and pairs, metres; about the origin for a room without any."""
    places = [each[:2] for start, goal in room.pairs for each in (start, goal)]
    corners = [np.array([(0.0, 0.0), *places])] if places or not room.obstacles else []
    corners += [_corners(obstacle) for obstacle in room.obstacles]
    points = np.concatenate(corners)
    return points.min(axis=0), points.max(axis=0)


def _holds_pairs(room: Room) -> bool:
    """Whether its starts and goals lie among its obstacles."""
    low, high = _extent(Room(room.obstacles))
    places = np.array([each[:2] for start, goal in room.pairs for each in (start, goal)]).reshape(-1, 2)
    return bool(((places > low) & (places < high)).all())


def _corners(obstacle: Obstacle) -> FloatArray:
    """Two corners of a rectangle around an obstacle, however it is turned: (2, 2), metres."""
    reach = np.hypot.reduce(np.abs(obstacle.points).max(axis=0)) if obstacle.points else np.hypot.reduce(obstacle.size)
    centre = np.array(obstacle.position[:2])
    return np.stack([centre - reach, centre + reach])


def _add_fence(spec: mujoco.MjSpec, low: FloatArray, high: FloatArray) -> None:
    (x, y), (half_x, half_y), half = (low + high) / 2, (high - low) / 2 + FENCE_THICKNESS, FENCE_THICKNESS / 2
    sides = {
        "fence_east": (x + half_x, y, half, half_y),
        "fence_north": (x, y + half_y, half_x, half),
        "fence_west": (x - half_x, y, half, half_y),
        "fence_south": (x, y - half_y, half_x, half),
    }
    for name, (at_x, at_y, size_x, size_y) in sides.items():
        geom = spec.worldbody.add_geom(spec.find_default("wall"), name=name)
        geom.type, geom.pos, geom.size = (
            mujoco.mjtGeom.mjGEOM_BOX,
            (at_x, at_y, HEIGHT / 2),
            (size_x, size_y, HEIGHT / 2),
        )


def _add_camera(spec: mujoco.MjSpec, low: FloatArray, high: FloatArray) -> None:
    """The camera `top`, which sees the whole room."""
    (x, y), (width, depth) = (low + high) / 2, high - low
    height = 1.1 * max(width, depth) / 2 / np.tan(np.radians(CAMERA_ANGLE / 2)) + HEIGHT
    spec.worldbody.add_camera(name="top", pos=(x, y, height), quat=(1, 0, 0, 0), fovy=CAMERA_ANGLE)


# Free floor -----------------------------------------------------------------------------------------------------------


def _enclosed_floor(model: mujoco.MjModel) -> tuple[Grid, BoolArray] | None:
    """The largest piece of free floor that walls enclose, as cells (rows, columns) of a grid; None without one."""
    try:
        grid = Grid(Obstacles.from_model(model), Footprint.from_model(model).radius, CELL)
    except TaskError:  # the room has no obstacle
        return None
    pieces, count = ndimage.label(grid.free.reshape(grid.shape))
    border = np.concatenate([pieces[0], pieces[-1], pieces[:, 0], pieces[:, -1]])
    areas = np.bincount(pieces.ravel(), minlength=count + 1)
    areas[0] = 0
    outside = areas[np.unique(border)].sum()
    areas[border] = 0
    is_room = areas.max() >= max(ENCLOSED_FROM / CELL**2, ENCLOSED_SHARE * outside)
    return (grid, pieces == areas.argmax()) if is_room else None


def _widest_place(grid: Grid, floor: BoolArray) -> Point:
    """The place of a piece of floor that is farthest from its edges, metres."""
    x, y = grid.points[int(ndimage.distance_transform_edt(floor).argmax())].tolist()
    return x, y
