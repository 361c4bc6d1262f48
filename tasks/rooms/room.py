"""A room as data: what every reader and every generator makes, and what becomes a scene."""

from dataclasses import dataclass
from enum import StrEnum

from tasks.physics import Pose

Point = tuple[float, float]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

HEIGHT = 0.5  # m, of obstacles whose file has no height: above the laser, 0.287 m
UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)


class Shape(StrEnum):
    """The shapes that a room is made of."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"
    HULL = "hull"


@dataclass(frozen=True)
class Obstacle:
    """A solid of a room.

    Attributes:
        shape: of the solid.
        position: of its centre, metres, world frame; the floor is at z = 0. A hull's points are about it.
        size: half the sides of a box; radius and half the height of a cylinder; radius of a sphere; metres. Empty for a
            hull.
        quaternion: w, x, y, z, from its own frame into the world's.
        points: of a hull, metres, its own frame, four or more that do not lie in a plane.
        mass: kg, of a movable thing that the robot may push; 0 for a fixed obstacle.
        name: as its file has it; may be empty, and need not be unique.
    """

    shape: Shape
    position: Vector
    size: tuple[float, ...] = ()
    quaternion: Quaternion = UPRIGHT
    points: tuple[Vector, ...] = ()
    mass: float = 0.0
    name: str = ""


@dataclass(frozen=True)
class Room:
    """A room.

    Attributes:
        obstacles: all that the robot can touch but the floor.
        omitted: what its file holds and the room lacks, and why, a sentence each.
        pairs: starts (x, y, yaw; m, rad) and goals (x, y; m) that belong to it; empty where the geometry gives them.
    """

    obstacles: tuple[Obstacle, ...]
    omitted: tuple[str, ...] = ()
    pairs: tuple[tuple[Pose, Point], ...] = ()


def box(x: float, y: float, half_x: float, half_y: float, yaw: Quaternion = UPRIGHT, name: str = "") -> Obstacle:
    """An upright box of HEIGHT on the floor; x, y of its centre and half its sides, metres."""
    return Obstacle(Shape.BOX, (x, y, HEIGHT / 2), (half_x, half_y, HEIGHT / 2), yaw, name=name)


def cylinder(x: float, y: float, radius: float, name: str = "") -> Obstacle:
    """An upright cylinder of HEIGHT on the floor; x, y of its axis and its radius, metres."""
    return Obstacle(Shape.CYLINDER, (x, y, HEIGHT / 2), (radius, HEIGHT / 2), name=name)
