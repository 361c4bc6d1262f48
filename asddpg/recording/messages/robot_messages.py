"""Foxglove's messages of where things are, and what laser and cameras see."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from foxglove.messages import (
    CompressedImage,
    CompressedVideo,
    FrameTransform,
    FrameTransforms,
    LaserScan,
    Odometry,
    Pose,
    PoseInFrame,
    Quaternion,
    Timestamp,
    Vector3,
)

from asddpg.recording.messages.template import Template
from asddpg.recording.samples import NANOSECONDS
from tasks.constants import FIELD_OF_VIEW, MAX_RANGE
from tasks.physics import FloatArray
from tasks.scene.frames import Frame
from tasks.scene.shapes import WORLD

_IDENTITY = Pose(position=Vector3(), orientation=Quaternion(w=1.0))
# Ranges are kept in steps of 1/512 m, places and quaternions of 1/4096: the lower bytes of a double are zeros then,
# which take no room once compressed.
_RANGE_GRID = 512.0
_GRID = 4096.0


def on_grid(values: npt.NDArray[np.floating]) -> FloatArray:
    """Numbers as they are kept, at most 1/8192 off: 0.12 mm."""
    kept: FloatArray = np.rint(values * _GRID) / _GRID + 0.0  # without the sign of −0
    return kept


def kept_ranges(observations: npt.NDArray[np.floating], num_beams: int) -> FloatArray:
    """The newest scan of each observation, (m, size), as it is kept: (m, num_beams) metres, at most 1 mm off."""
    kept: FloatArray = np.rint((observations[:, :num_beams] + 0.5) * (MAX_RANGE * _RANGE_GRID)) / _RANGE_GRID
    return kept


def timestamp(time: int) -> Timestamp:
    """Simulated nanoseconds as Foxglove has them."""
    return Timestamp(sec=time // NANOSECONDS, nsec=time % NANOSECONDS)


def states(frames: Sequence[Frame], num_beams: int) -> Template:
    """/tf, /scan and /odom of an instant.

    Its numbers: of the base in the world x, y, z in metres and the quaternion w, x, y, z, its forward speed in m/s and
    its turn rate in rad/s; the place of each frame in its parent's; ranges in metres from right to left.
    """

    def make(stamp: Timestamp, numbers: Sequence[float]) -> tuple[FrameTransforms, LaserScan, Odometry]:
        motion, places, ranges = numbers[:9], numbers[9:-num_beams], numbers[-num_beams:]
        return _transforms(stamp, frames, places), _laser_scan(stamp, ranges), _odometry(stamp, motion)

    return Template(make, 9 + 7 * len(frames) + num_beams)


def _transforms(stamp: Timestamp, frames: Sequence[Frame], numbers: Sequence[float]) -> FrameTransforms:
    """All frames in one message: after a jump in time a viewer gets the last message alone."""
    places = np.reshape(numbers, (len(frames), 7)).tolist()
    return FrameTransforms(
        transforms=[
            FrameTransform(
                timestamp=stamp,
                parent_frame_id=frame.parent,
                child_frame_id=frame.name,
                translation=Vector3(x=x, y=y, z=z),
                rotation=Quaternion(x=i, y=j, z=k, w=w),
            )
            for frame, (x, y, z, w, i, j, k) in zip(frames, places, strict=True)
        ]
    )


def _laser_scan(stamp: Timestamp, ranges: Sequence[float]) -> LaserScan:
    """What the policy saw."""
    half = FIELD_OF_VIEW / 2
    return LaserScan(
        timestamp=stamp, frame_id="laser", pose=_IDENTITY, start_angle=-half, end_angle=half, ranges=list(ranges)
    )


def _odometry(stamp: Timestamp, numbers: Sequence[float]) -> Odometry:
    """Pose of the base in the world, its velocity in its own frame."""
    x, y, z, w, i, j, k, linear, angular = numbers
    return Odometry(
        timestamp=stamp,
        frame_id=WORLD,
        body_frame_id="base",
        pose=Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w)),
        linear_velocity=Vector3(x=linear),
        angular_velocity=Vector3(z=angular),
    )


def goal_pose(goal: tuple[float, float], time: int) -> PoseInFrame:
    """The goal on the floor, metres, world frame."""
    x, y = goal
    pose = Pose(position=Vector3(x=x, y=y), orientation=Quaternion(w=1.0))
    return PoseInFrame(timestamp=timestamp(time), frame_id=WORLD, pose=pose)


def picture_message(camera: str, picture: bytes, time: int, is_video: bool) -> CompressedImage | CompressedVideo:
    """What a camera saw, as JPEG or as a frame of H.264."""
    if is_video:
        return CompressedVideo(timestamp=timestamp(time), frame_id=camera, data=picture, format="h264")
    return CompressedImage(timestamp=timestamp(time), frame_id=camera, data=picture, format="jpeg")
