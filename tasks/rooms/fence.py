"""The rectangle around a room, and a fence around one without walls."""

from collections.abc import Sequence

import numpy as np

from tasks.physics import FloatArray
from tasks.rooms.room import Obstacle, Room, Shape, box

FENCE_MARGIN = 6.0  # m around a room without walls: out of the laser's range, 5.6 m, from its obstacles
FENCE_THICKNESS = 0.05  # m


def find_fence(low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Corners of the floor inside the fence around a room with these corners, metres."""
    return low - FENCE_MARGIN, high + FENCE_MARGIN


def build_fence(low: FloatArray, high: FloatArray) -> tuple[Obstacle, ...]:
    """Four walls around the floor with these corners, metres."""
    (x, y), (half_x, half_y), half = (low + high) / 2, (high - low) / 2 + FENCE_THICKNESS, FENCE_THICKNESS / 2
    return (
        box(x + half_x, y, half, half_y, name="fence_east"),
        box(x, y + half_y, half_x, half, name="fence_north"),
        box(x - half_x, y, half, half_y, name="fence_west"),
        box(x, y - half_y, half_x, half, name="fence_south"),
    )


def find_extent(room: Room) -> tuple[FloatArray, FloatArray]:
    """Corners of the smallest rectangle around obstacles and pairs, metres; about the origin for a room without any."""
    places = [each[:2] for start, goal in room.pairs for each in (start, goal)]
    corners = [np.array([(0.0, 0.0), *places])] if places or not room.obstacles else []
    solid = [each for each in room.obstacles if each.shape is not Shape.HULL]
    if solid:
        centres = np.array([each.position for each in solid])[:, :2]
        reaches = _find_reaches(solid)
        corners += [centres - reaches, centres + reaches]
    corners += [_hull_corners(each) for each in room.obstacles if each.shape is Shape.HULL]
    points = np.concatenate(corners)
    return points.min(axis=0), points.max(axis=0)


def _find_reaches(solid: Sequence[Obstacle]) -> FloatArray:
    """How far boxes, cylinders and spheres reach along the world's x and y from their centres, (n, 2), metres."""
    across = find_axes(np.array([each.quaternion for each in solid]))[:, :2]
    sizes = np.array([(*each.size, 0.0, 0.0)[:3] for each in solid])
    radius, half = sizes[:, :1], sizes[:, 1:2]
    of_cylinders = radius * np.sqrt(np.maximum(1.0 - across[:, :, 2] ** 2, 0.0)) + half * np.abs(across[:, :, 2])
    of_boxes = (np.abs(across) * sizes[:, None]).sum(axis=2)
    is_box, is_cylinder = (np.array([[each.shape is shape] for each in solid]) for shape in (Shape.BOX, Shape.CYLINDER))
    reaches: FloatArray = np.where(is_box, of_boxes, np.where(is_cylinder, of_cylinders, radius))
    return reaches


def _hull_corners(hull: Obstacle) -> FloatArray:
    """Two corners of the smallest rectangle around a hull: (2, 2), metres."""
    points = np.array(hull.points) @ find_axes(np.array([hull.quaternion]))[0, :2].T
    return np.asarray(hull.position[:2] + np.stack([points.min(axis=0), points.max(axis=0)]))


def find_axes(quaternions: FloatArray) -> FloatArray:
    """Rotation matrices of quaternions (w, x, y, z), (n, 4), of any length: (n, 3, 3); of 0 for no turn."""
    lengths = np.linalg.norm(quaternions, axis=1, keepdims=True)
    w, x, y, z = (quaternions / np.where(lengths > 0.0, lengths, 1.0)).T
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
