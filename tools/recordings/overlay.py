"""Draws the scan and the path of a recording into its scene."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from asddpg.recording.messages.path_message import DRIVER_COLOURS, OTHER_COLOUR, PATH_HEIGHT, PATH_WIDTH
from tasks.constants import FIELD_OF_VIEW, MAX_RANGE
from tasks.graphics.headless import mujoco
from tasks.physics import FloatArray

SCAN_COLOUR = (0.9, 0.1, 0.1)
SCAN_RADIUS = 0.03  # m

Place = tuple[float, float]
Stretch = tuple[str, Sequence[Place]]  # driver, and places, m


def scan_points(position: FloatArray, rotation: FloatArray, ranges: FloatArray) -> FloatArray:
    """Ends of the beams that met an obstacle: (n, 3) metres, world frame.

    Args:
        position: (3,) of the laser, world frame.
        rotation: (3, 3) of the laser, to the world frame.
        ranges: (num_beams,) metres, from right to left.
    """
    angles = np.linspace(-FIELD_OF_VIEW / 2, FIELD_OF_VIEW / 2, len(ranges))
    hits = ranges < MAX_RANGE
    beams = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(ranges))], axis=1) * ranges[:, None]
    points: FloatArray = position + beams[hits] @ rotation.T
    return points


def draw_scan(scene: mujoco.MjvScene, points: FloatArray) -> None:
    """Put a small sphere at each point, (n, 3) metres."""
    for point in points:
        geom = _next(scene)
        size = np.full(3, SCAN_RADIUS)
        mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_SPHERE, size, point, np.eye(3).ravel(), _rgba(SCAN_COLOUR))


def draw_path(scene: mujoco.MjvScene, stretches: Sequence[Stretch]) -> None:
    """Put a line along each stretch, in its driver's colour."""
    for driver, places in stretches:
        colour = _rgba(DRIVER_COLOURS.get(driver, OTHER_COLOUR))
        for (x, y), (next_x, next_y) in pairwise(places):
            geom = _next(scene)
            capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
            mujoco.mjv_initGeom(geom, capsule, np.zeros(3), np.zeros(3), np.eye(3).ravel(), colour)
            begin, end = np.array([x, y, PATH_HEIGHT]), np.array([next_x, next_y, PATH_HEIGHT])
            mujoco.mjv_connector(geom, capsule, PATH_WIDTH / 2, begin, end)


def _next(scene: mujoco.MjvScene) -> mujoco.MjvGeom:
    """The next free geom; the last one again where none is left."""
    scene.ngeom = min(scene.ngeom + 1, scene.maxgeom)
    return scene.geoms[scene.ngeom - 1]


def _rgba(colour: tuple[float, float, float]) -> npt.NDArray[np.float32]:
    return np.array([*colour, 1.0], dtype=np.float32)
