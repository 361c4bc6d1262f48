"""Samples: the state of an environment after each step, to be published later."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from asddpg.episodes.protocols import Observation, Step
from asddpg.planning.navigation_view import NavigationView
from asddpg.recording.pictures.cameras import Cameras, Stills
from tasks.gymnasium_api.navigation_env import NavigationEnv

NANOSECONDS = 1_000_000_000
_MICROSECOND = 1_000  # ns; smaller parts of a simulated time are rounding errors
_NO_PICTURES: Mapping[str, bytes] = MappingProxyType({})

ReadNavigation = Callable[[], NavigationView]


class Sample(NamedTuple):
    """The state at the end of a step, or at the beginning of an episode.

    The physical state is kept as bytes: between two steps the caches hold the simulator and the networks, and any
    further work takes several times as long as in a batch.
    """

    number: int  # of the step, from 0; −1 at the beginning
    step: Step | None
    observation: Observation
    seconds: float  # simulated, since the episode's beginning
    positions: bytes  # xpos of all bodies of the scene
    quaternions: bytes  # xquat
    rotations: bytes  # xmat
    delayed_poses: tuple[float, bytes] | None  # seconds and the same three at the instant of a scan within the step
    qpos: bytes
    qvel: bytes
    pictures: Mapping[str, bytes]  # by camera, encoded
    navigation: NavigationView | None  # of a driver that plans

    @property
    def time(self) -> int:
        """Simulated nanoseconds since the episode's beginning."""
        return to_nanoseconds(self.seconds)


def to_nanoseconds(seconds: float) -> int:
    """Simulated nanoseconds, in whole microseconds."""
    return round(seconds * (NANOSECONDS / _MICROSECOND)) * _MICROSECOND


class Sampler:
    """Takes samples of an environment and changes nothing in it."""

    def __init__(
        self,
        environment: NavigationEnv,
        cameras: Cameras | Stills | None = None,
        read_navigation: ReadNavigation | None = None,
    ) -> None:
        self._physics = environment.physics
        self._data = data = self._physics.data.ptr
        self._arrays = data.xpos, data.xquat, data.xmat, data.qpos, data.qvel  # views that MuJoCo keeps up to date
        self._cameras, self._read_navigation = cameras, read_navigation

    def sample(self, number: int, step: Step | None, observation: Observation) -> Sample:
        """The present state, after a step of a number, or of number −1 and no step at an episode's beginning."""
        positions, quaternions, rotations, qpos, qvel = self._arrays
        return Sample(
            number,
            step,
            observation,
            self._data.time,
            positions.tobytes(),
            quaternions.tobytes(),
            rotations.tobytes(),
            self._physics.delayed_poses,
            qpos.tobytes(),
            qvel.tobytes(),
            self._cameras.take(is_first=step is None) if self._cameras else _NO_PICTURES,
            self._read_navigation() if self._read_navigation else None,
        )
