"""What there is to tell of an instant: read at once, told when there is time for it."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

from asddpg.types import Observation, Step
from tasks.body_frames import BodyFrames
from tasks.state_digest import state_digest

NANOSECONDS = 1_000_000_000
_MICROSECOND = 1_000  # ns
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


class Moment(NamedTuple):
    """The end of a step, or the beginning of an episode."""

    time: int  # simulated ns since the episode's beginning
    number: int  # of the step, from 0; −1 at the beginning
    step: Step | None
    observation: Observation
    bodies: bytes  # BodyFrames.sample
    goal: tuple[float, float]  # m, world frame
    digest: int  # of the physical state
    pictures: Mapping[str, bytes] = _NO_PICTURES  # by camera, encoded


class MomentReader:
    """Reads an environment and changes nothing in it."""

    def __init__(self, environment: Watched, cameras: TakesPictures | None = None) -> None:
        self._physics, self._cameras = environment.physics, cameras
        self._data = self._physics.data.ptr
        self.frames = BodyFrames(self._physics.model.ptr)
        self._number = -1

    def begin(self, observation: Observation) -> Moment:
        """An episode's beginning."""
        self._number = -1
        return self._read(observation, None)

    def step(self, step: Step) -> Moment:
        """How things stand after a step."""
        self._number += 1
        return self._read(step.next_observation, step)

    def _read(self, observation: Observation, step: Step | None) -> Moment:
        data = self._data
        return Moment(
            time=round(data.time * (NANOSECONDS / _MICROSECOND)) * _MICROSECOND,
            number=self._number,
            step=step,
            observation=observation,
            bodies=self.frames.sample(data),
            goal=self._physics.goal(),
            digest=state_digest(data),
            pictures=self._cameras.take(is_first=step is None) if self._cameras else _NO_PICTURES,
        )
