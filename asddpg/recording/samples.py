"""What there is to tell of an instant: read at once, put into words when there is time for it."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

from asddpg.episodes.protocols import Observation, Step

NANOSECONDS = 1_000_000_000
_NO_PICTURES: Mapping[str, bytes] = MappingProxyType({})


class Watched(Protocol):
    """The part of NavigationEnv that is read."""

    @property
    def physics(self) -> Any:
        """The scene."""

    @property
    def scan_shape(self) -> tuple[int, int]:
        """Scans and beams at the head of the observation."""


class TakesPictures(Protocol):
    """Cameras that look at what is watched."""

    def take(self, is_first: bool) -> Mapping[str, bytes]:
        """What each sees now, encoded; `is_first` in an episode."""


class Reading(NamedTuple):
    """The end of a step, or the beginning of an episode, as it is read.

    Only bytes are taken: between two steps nothing is in the processor's caches that would make numbers of them, which
    then takes several times as long as in a row.
    """

    number: int  # of the step, from 0; −1 at the beginning
    step: Step | None
    observation: Observation
    seconds: float  # simulated, since the episode's beginning
    positions: bytes  # xpos of all bodies of the scene
    quaternions: bytes  # xquat
    qpos: bytes
    qvel: bytes
    pictures: Mapping[str, bytes]  # by camera, encoded


class Moment(NamedTuple):
    """What is told of a reading."""

    number: int
    time: int  # simulated ns
    driver: str  # who drove here; empty at an episode's beginning
    step: bytes  # the message of /step, if there was one
    command: bytes  # that of /cmd_vel
    observation: Observation
    positions: bytes
    quaternions: bytes
    pictures: Mapping[str, bytes]


class MomentReader:
    """Reads an environment and changes nothing in it."""

    def __init__(self, environment: Watched, cameras: TakesPictures | None = None) -> None:
        self._data = data = environment.physics.data.ptr
        self._arrays = data.xpos, data.xquat, data.qpos, data.qvel  # views that MuJoCo keeps up to date
        self._cameras = cameras
        self._number = -1

    def begin(self, observation: Observation) -> Reading:
        """An episode's beginning."""
        self._number = -1
        return self._read(None, observation)

    def step(self, step: Step) -> Reading:
        """How things stand after a step."""
        self._number += 1
        return self._read(step, step.next_observation)

    def _read(self, step: Step | None, observation: Observation) -> Reading:
        positions, quaternions, qpos, qvel = self._arrays
        return Reading(
            self._number,
            step,
            observation,
            self._data.time,
            positions.tobytes(),
            quaternions.tobytes(),
            qpos.tobytes(),
            qvel.tobytes(),
            self._cameras.take(is_first=step is None) if self._cameras else _NO_PICTURES,
        )
