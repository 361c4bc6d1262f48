"""/tf, /scan and /odom: poses and laser ranges of a batch of samples."""

import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from foxglove.messages import FrameTransform, FrameTransforms, LaserScan, Odometry, Pose, Quaternion, Timestamp, Vector3

from asddpg.recording.messages.goal_camera_messages import make_timestamp, round_to_grid
from asddpg.recording.messages.scene_messages import Point
from asddpg.recording.messages.template import MessageTemplate
from asddpg.recording.samples import Sample, to_nanoseconds
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.scene.frames import BodyFrames
from tasks.scene.shapes import WORLD

_ROBOT, _GOAL = "base", "goal"  # their frames
_POINT = struct.Struct("<2d")
_IDENTITY = Pose(position=Vector3(), orientation=Quaternion(w=1.0))
_RANGE_GRID = 512.0  # steps a metre, see round_to_grid
_NO_RETURN = 0.5  # in the observation, of a beam that reads the maximum range


class PoseMessages(NamedTuple):
    """Encoded messages of a sample, their times in ns, and the robot's place in them."""

    time: int  # of the sample
    begin: int  # of its step
    transforms: Sequence[tuple[int, bytes]]  # by time: at the scan within the step, if there is one, and at its end
    scan: bytes
    odometry: bytes
    place: Point  # m, world frame


class PoseEncoder:
    """Encodes samples of one environment."""

    def __init__(self, environment: NavigationEnv) -> None:
        frames = BodyFrames.from_model(environment.physics.model.ptr)
        num_scans, self._num_beams = environment.scan_shape
        self._max_range = environment.physics.max_range
        self._angles = environment.task.config.laser.angles()[[0, -1]].tolist()
        self._latency = to_nanoseconds(environment.scan_latency)
        self._frames, self._base = frames, 7 * frames.index(_ROBOT)
        self._goal_offset = 3 * 8 * int(frames.bodies[frames.index(_GOAL)])  # bytes into xpos
        self._transforms = MessageTemplate(self._make_transforms, 7 * len(frames.frames))
        self._velocity = slice(num_scans * self._num_beams, num_scans * self._num_beams + 2)

    def read_goal(self, sample: Sample) -> Point:
        """The goal's place: m, world frame."""
        x, y = _POINT.unpack_from(sample.positions, self._goal_offset)
        return x, y

    def encode(self, samples: Sequence[Sample], offset: int) -> Iterator[PoseMessages]:
        """The messages of each sample; `offset`, ns, is added to their times."""
        observations = np.array([sample.observation for sample in samples])
        poses = self._frames.relative([sample.positions + sample.quaternions + sample.rotations for sample in samples])
        velocities = observations[:, self._velocity]
        numbers = round_to_grid(np.concatenate((poses.reshape(len(samples), -1), velocities), axis=1)).tolist()
        scans = observations[:, : self._num_beams]
        ranges = np.rint((scans + 0.5) * (self._max_range * _RANGE_GRID)) / _RANGE_GRID
        ranges[scans >= _NO_RETURN] = np.inf
        for sample, row, beams in zip(samples, numbers, ranges.tolist(), strict=True):
            time = offset + sample.time
            stamp, scanned = make_timestamp(time), offset + max(0, sample.time - self._latency)
            transforms = [(time, self._transforms.fill(time, row[:-2]))]
            if sample.delayed_poses is not None:
                transforms.insert(0, self._fill_delayed(offset, *sample.delayed_poses))
            motion = row[self._base : self._base + 7] + row[-2:]
            yield PoseMessages(
                time,
                time - sample.time // max(1, sample.number + 1),
                transforms,
                _laser_scan(make_timestamp(scanned) if self._latency else stamp, self._angles, beams).encode(),
                _odometry(stamp, motion).encode(),
                (motion[0], motion[1]),
            )

    def _fill_delayed(self, offset: int, seconds: float, poses: bytes) -> tuple[int, bytes]:
        """/tf at a scan's instant: between two steps it would be interpolated, centimetres off at the end of a beam."""
        time = offset + to_nanoseconds(seconds)
        return time, self._transforms.fill(time, round_to_grid(self._frames.relative([poses])).ravel().tolist())

    def _make_transforms(self, stamp: Timestamp, numbers: Sequence[float]) -> FrameTransforms:
        """All frames in one message: after a seek a viewer gets only the last message of a topic."""
        poses = np.reshape(numbers, (-1, 7)).tolist()
        return FrameTransforms(
            transforms=[
                FrameTransform(
                    timestamp=stamp,
                    parent_frame_id=frame.parent,
                    child_frame_id=frame.name,
                    translation=Vector3(x=x, y=y, z=z),
                    rotation=Quaternion(x=i, y=j, z=k, w=w),
                )
                for frame, (x, y, z, i, j, k, w) in zip(self._frames.frames, poses, strict=True)
            ]
        )


def _laser_scan(stamp: Timestamp, angles: Sequence[float], ranges: list[float]) -> LaserScan:
    """The newest scan in the observation: metres, from right to left; infinite without a return, by REP 117.

    `angles` are those of the first and of the last beam, rad.
    """
    first, last = angles
    return LaserScan(
        timestamp=stamp, frame_id="laser", pose=_IDENTITY, start_angle=first, end_angle=last, ranges=ranges
    )


def _odometry(stamp: Timestamp, motion: Sequence[float]) -> Odometry:
    """The base's pose in the world, (x, y, z, i, j, k, w), then (v, ω) in its own frame: m/s, rad/s."""
    x, y, z, i, j, k, w, linear, angular = motion
    return Odometry(
        timestamp=stamp,
        frame_id=WORLD,
        body_frame_id="base",
        pose=Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w)),
        linear_velocity=Vector3(x=linear),
        angular_velocity=Vector3(z=angular),
    )
