"""/tf, /scan and /odom: where everything is and what the laser sees, at many moments at once."""

import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from asddpg.recording.messages.robot_messages import kept_ranges, on_grid, states
from asddpg.recording.messages.scene_messages import Point
from asddpg.recording.samples import Moment
from tasks.scene.frames import BodyFrames

_ROBOT, _GOAL = "base", "goal"  # their frames
_POINT = struct.Struct("<2d")
_AT_ONCE = 64  # more would leave the processor's cache


class State(NamedTuple):
    """Messages of a moment, and where the robot is."""

    frames: bytes
    scan: bytes
    motion: bytes
    place: Point  # m, world frame


class States:
    """Of one scene."""

    def __init__(self, frames: BodyFrames, scan_shape: tuple[int, int]) -> None:
        """Take what can move, and how many scans and beams stand at the head of an observation."""
        num_scans, self._num_beams = scan_shape
        self._frames, self._base = frames, frames.index(_ROBOT)
        self._robot_at, self._goal_at = (3 * 8 * int(frames.bodies[frames.index(name)]) for name in (_ROBOT, _GOAL))
        self._velocity = slice(num_scans * self._num_beams, num_scans * self._num_beams + 2)
        self._template = states(frames.frames, self._num_beams)

    def goal(self, moment: Moment) -> Point:
        """Where the goal is: m, world frame."""
        return _point(moment, self._goal_at)

    def place(self, moment: Moment) -> Point:
        """Where the robot is: m, world frame; exactly."""
        return _point(moment, self._robot_at)

    def of(self, moments: Sequence[Moment], times: Sequence[int]) -> Iterator[State]:
        """How things stand, one moment after the other; times of the messages in ns."""
        for begin in range(0, len(moments), _AT_ONCE):
            part = slice(begin, begin + _AT_ONCE)
            yield from self._of(moments[part], times[part])

    def _of(self, moments: Sequence[Moment], times: Sequence[int]) -> Iterator[State]:
        observations = np.array([moment.observation for moment in moments])
        places = self._frames.relative([moment.positions + moment.quaternions for moment in moments])
        motions = places[:, self._base], observations[:, self._velocity]
        kept = on_grid(np.concatenate((*motions, places.reshape(len(moments), -1)), axis=1))
        numbers = np.concatenate((kept, kept_ranges(observations, self._num_beams)), axis=1)
        told = self._template.fill(times, numbers)
        for (frames, scan, motion), (x, y) in zip(told, kept[:, :2].tolist(), strict=True):
            yield State(frames, scan, motion, (x, y))


def _point(moment: Moment, begin: int) -> Point:
    x, y = _POINT.unpack_from(moment.positions, begin)
    return x, y
