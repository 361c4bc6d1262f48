"""Draws the scan and the path of a recording into its scene."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from asddpg.recording.files.reading import Recording
from asddpg.recording.messages.path_message import DRIVER_COLOURS, OTHER_COLOUR, PATH_HEIGHT, PATH_WIDTH
from asddpg.recording.messages.topics import SCAN, TF
from tasks.graphics.headless import mujoco
from tasks.physics import FloatArray
from tasks.scene.shapes import WORLD

SCAN_COLOUR = (0.9, 0.1, 0.1)
SCAN_RADIUS = 0.03  # m

Place = tuple[float, float]
Stretch = tuple[str, Sequence[Place]]  # driver, and places, m


def read_scans(recording: Recording) -> list[FloatArray]:
    """Ends of the beams that met an obstacle, where they were when it was measured: (n, 3) metres, world frame.

    One array for the beginning, and for each step that of the scan which had arrived by its end.
    """
    transforms = {str(each.content.transforms[0].timestamp): each.content.transforms for each in recording.messages(TF)}
    scans = (message.content for message in recording.messages(SCAN))
    return [_scan_points(scan, *place_in_world(transforms[str(scan.timestamp)], scan.frame_id)) for scan in scans]


def place_in_world(transforms: Sequence[Any], frame: str) -> tuple[FloatArray, FloatArray]:
    """Position (3,), metres, and rotation (3, 3) of a frame to the world, from the transforms of a message of /tf."""
    if frame == WORLD:
        return np.zeros(3), np.eye(3)
    (each,) = (each for each in transforms if each.child_frame_id == frame)
    position, rotation = place_in_world(transforms, each.parent_frame_id)
    own_position, own_rotation = read_pose(each.translation, each.rotation)
    return position + rotation @ own_position, rotation @ own_rotation


def read_pose(place: Any, turn: Any) -> tuple[FloatArray, FloatArray]:
    """Position (3,), metres, and rotation (3, 3) of a Vector3 and a Quaternion."""
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, np.array([turn.w, turn.x, turn.y, turn.z]))
    return np.array([place.x, place.y, place.z]), rotation.reshape(3, 3)


def _scan_points(scan: Any, position: FloatArray, rotation: FloatArray) -> FloatArray:
    ranges = np.array(scan.ranges)
    angles = np.linspace(scan.start_angle, scan.end_angle, len(ranges))
    beams = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(ranges))], axis=1)
    hits = np.isfinite(ranges)
    points: FloatArray = position + (beams[hits] * ranges[hits, None]) @ rotation.T
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
