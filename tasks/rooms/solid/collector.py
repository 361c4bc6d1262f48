"""What a reader finds in its file, until it is a room."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.rooms.room import Obstacle, Room, Shape
from tasks.rooms.solid.transforms import Transform
from tasks.rooms.solid.xml_file import shorten

MAX_OBSTACLES = 20_000
MAX_HULLS = 2_000  # among them; MuJoCo takes 1 to 2 ms to compile one
FARTHEST = 200.0  # m from the origin along an axis; farther things would make the grid of the free floor too large
_FLAT = 0.001  # m; what rises no higher is floor


class Collector:
    """Obstacles, the floor and what is left out."""

    def __init__(self) -> None:
        self._obstacles: list[Obstacle] = []
        self._num_hulls = 0
        self._floors: list[tuple[str, float]] = []
        self._omitted: dict[str, list[str]] = {}

    def add(
        self,
        shape: Shape,
        pose: Transform,
        size: Sequence[float] = (),
        points: FloatArray | None = None,
        *,
        mass: float = 0.0,
        name: str = "",
    ) -> None:
        """Add a solid; TaskError for one too many. Of a hull, `points` are (n, 3), metres, in the frame of its pose."""
        if len(self._obstacles) >= MAX_OBSTACLES:
            raise TaskError(f"it has more than {MAX_OBSTACLES:,} obstacles")
        self._num_hulls += shape is Shape.HULL
        if self._num_hulls > MAX_HULLS:
            raise TaskError(f"its meshes and capsules become more than {MAX_HULLS:,} convex hulls")
        corners: tuple[tuple[float, float, float], ...] = ()
        if points is not None:
            middle = (points.min(axis=0) + points.max(axis=0)) / 2
            pose = Transform(pose.rotation, pose.apply(middle))
            corners = tuple((x, y, z) for x, y, z in (points - middle).tolist())
        self._obstacles.append(Obstacle(shape, pose.position, tuple(size), pose.quaternion, corners, mass, name))

    def add_floor(self, name: str, height: float) -> None:
        """Add a horizontal plane; the first is the floor."""
        self._floors.append((name, height))

    def omit(self, subject: str, reason: str) -> None:
        """Name something that the room will lack; things of one reason share a sentence."""
        self._omitted.setdefault(reason, []).append(subject)

    def room(self) -> Room:
        """The room, its floor at z = 0."""
        floor = self._floors[0][1] if self._floors else 0.0
        for name, height in self._floors:
            if abs(height - floor) > _FLAT:
                self.omit(name, f"it is another floor, at {height - floor:g} m")
        kept = []
        for obstacle in self._obstacles:
            x, y, z = obstacle.position
            reach = _reach(obstacle)
            if not obstacle.mass and z - floor + reach[2] <= _FLAT:
                continue  # ground
            if max(abs(x) + reach[0], abs(y) + reach[1], abs(z - floor) + reach[2]) > FARTHEST:
                self.omit(quote(obstacle.name), f"it reaches farther than {FARTHEST:g} m from the origin")
                continue
            kept.append(dataclasses.replace(obstacle, position=(x, y, z - floor)))
        return Room(tuple(kept), tuple(_sentence(names, reason) for reason, names in self._omitted.items()))


def quote(name: str) -> str:
    """A name from a file, for a sentence."""
    return repr(shorten(name))


def _sentence(names: list[str], reason: str) -> str:
    different = list(dict.fromkeys(names))
    more = f" and {len(different) - 3} more" if len(different) > 3 else ""
    return f"{', '.join(different[:3])}{more}: {reason}"


def _reach(obstacle: Obstacle) -> FloatArray:
    """Half the sides of a box along the world's axes around a solid, about its position: (3,), metres."""
    rotation = Transform.from_quaternion((0, 0, 0), obstacle.quaternion).rotation
    if obstacle.shape is Shape.HULL:
        return np.asarray(np.abs(np.array(obstacle.points) @ rotation.T).max(axis=0))
    if obstacle.shape is Shape.SPHERE:
        return np.full(3, obstacle.size[0])
    if obstacle.shape is Shape.BOX:
        return np.asarray(np.abs(rotation) @ obstacle.size)
    axis, (radius, half_length) = rotation[:, 2], obstacle.size
    return np.asarray(half_length * np.abs(axis) + radius * np.sqrt(np.maximum(1 - axis**2, 0)))
