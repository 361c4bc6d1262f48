"""/map, /plan, /particles and /amcl_pose: what a robot knows of the room and intends in it."""

import math
from collections.abc import Mapping

import numpy as np
from foxglove.messages import (
    Grid,
    PackedElementField,
    PackedElementFieldNumericType,
    Pose,
    PoseInFrame,
    PosesInFrame,
    Quaternion,
    Vector2,
    Vector3,
)

from asddpg.planning.navigation_view import NavigationView
from asddpg.planning.occupancy_grid import FloatArray, OccupancyGrid
from asddpg.recording.messages.channels import LogMessage
from asddpg.recording.messages.goal_camera_messages import make_timestamp, round_to_grid
from asddpg.recording.messages.topics import AMCL_POSE, MAP, PARTICLES, PLAN
from tasks.scene.shapes import WORLD

MAP_HEIGHT, PLAN_HEIGHT, POSE_HEIGHT = 0.01, 0.03, 0.05  # m above the floor
MOST_PARTICLES, PLAN_SPACING = 150, 2  # particles in a message, and the plan's points from one to the next in it
_OCCUPIED, _UNKNOWN, _FREE = (38, 70, 120, 210), (128, 128, 128, 90), (255, 255, 255, 0)  # red, green, blue, alpha
_INT8, _UINT8 = PackedElementFieldNumericType.Int8, PackedElementFieldNumericType.Uint8
_FIELDS = [
    PackedElementField(name="occupancy", offset=0, type=_INT8),
    *(
        PackedElementField(name=name, offset=offset, type=_UINT8)
        for offset, name in enumerate(("red", "green", "blue", "alpha"), 1)
    ),
]


class NavigationPublisher:
    """Publishes what has changed since the last time."""

    def __init__(self, log: Mapping[str, LogMessage]) -> None:
        self._log = log
        self.begin()

    def begin(self) -> None:
        """Publish everything again: an episode begins, or a viewer has come; no plan takes away the last one."""
        self._last = NavigationView(path=np.empty((0, 2)))

    def publish(self, view: NavigationView, time: int) -> None:
        """Publish at a time, ns."""
        last, self._last = self._last, view
        if view.map is not None and view.map is not last.map:
            self._log[MAP](map_message(view.map, time).encode(), time)
        if view.path is not last.path:
            self._log[PLAN](_plan(view.path, time).encode(), time)
        if view.particles is not None and view.particles is not last.particles:
            self._log[PARTICLES](_particles(view.particles, time).encode(), time)
        if view.pose is not None:
            x, y, yaw = view.pose
            message = PoseInFrame(timestamp=make_timestamp(time), frame_id=WORLD, pose=_pose(x, y, yaw, POSE_HEIGHT))
            self._log[AMCL_POSE](message.encode(), time)


def map_message(grid: OccupancyGrid, time: int) -> Grid:
    """An occupancy grid: percent or −1 as ROS has it, and a colour, in each cell."""
    colours = np.where(grid.occupied[..., None], _OCCUPIED, np.where(grid.unknown[..., None], _UNKNOWN, _FREE))
    cells = np.concatenate([grid.cells.view(np.uint8)[..., None], colours.astype(np.uint8)], axis=-1)
    x, y = grid.origin
    stride = cells.shape[-1]
    return Grid(
        timestamp=make_timestamp(time),
        frame_id=WORLD,
        pose=Pose(position=Vector3(x=x, y=y, z=MAP_HEIGHT), orientation=Quaternion(w=1.0)),
        column_count=grid.shape[1],
        cell_size=Vector2(x=grid.resolution, y=grid.resolution),
        row_stride=grid.shape[1] * stride,
        cell_stride=stride,
        fields=_FIELDS,
        data=cells.tobytes(),
    )


def _plan(path: FloatArray | None, time: int) -> PosesInFrame:
    """The path's points, each looking to the next; no points where there is no path."""
    if path is None or len(path) < 2:
        return PosesInFrame(timestamp=make_timestamp(time), frame_id=WORLD, poses=[])
    path = np.concatenate([path[:-1:PLAN_SPACING], path[-1:]])
    steps = np.diff(path, axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0])
    rows = round_to_grid(np.column_stack([path, np.append(yaws, yaws[-1])])).tolist()
    poses = [_pose(x, y, yaw, PLAN_HEIGHT) for x, y, yaw in rows]
    return PosesInFrame(timestamp=make_timestamp(time), frame_id=WORLD, poses=poses)


def _particles(particles: FloatArray, time: int) -> PosesInFrame:
    """At most MOST_PARTICLES of them: they are drawn independently, so every nth is as good as any."""
    shown = round_to_grid(particles[:: math.ceil(len(particles) / MOST_PARTICLES)]).tolist()
    poses = [_pose(x, y, yaw, PLAN_HEIGHT) for x, y, yaw in shown]
    return PosesInFrame(timestamp=make_timestamp(time), frame_id=WORLD, poses=poses)


def _pose(x: float, y: float, yaw: float, height: float) -> Pose:
    orientation = Quaternion(z=math.sin(yaw / 2.0), w=math.cos(yaw / 2.0))
    return Pose(position=Vector3(x=x, y=y, z=height), orientation=orientation)
