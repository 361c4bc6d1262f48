"""What differs from one episode to the next beside the room: the laser's faults, friction and mass."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import mujoco
import numpy as np

from tasks.errors import TaskError
from tasks.options import NOT_NEGATIVE, SHARE, between, check_options, option
from tasks.physics import Physics

_FACTOR = between(0, 0.9)


class Variation(NamedTuple):
    """Of one episode.

    Attributes:
        noise: scale of the laser's noise, on top of laser.noise.
        dropout: probability that a beam returns nothing, on top of laser.dropout.
        latency: seconds, on top of laser.latency.
        friction: of the robot's wheels and body on the floor, times what its file has.
        mass: of the heaviest part of the robot, its base, times what its file has.
    """

    noise: float = 0.0
    dropout: float = 0.0
    latency: float = 0.0
    friction: float = 1.0
    mass: float = 1.0

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Self:
        """Of the values that _asdict() gives; TaskError for others."""
        try:
            variation = cls(**{name: float(value) for name, value in values.items()})
        except (TypeError, ValueError, AttributeError) as error:
            raise TaskError(f"a variation has the numbers {', '.join(cls._fields)}, not {values}") from error
        if not all(np.isfinite(variation)) or min(variation) < 0.0 or min(variation.friction, variation.mass) < 0.1:
            raise TaskError(f"a variation's numbers must be 0 or more, friction and mass 0.1 or more, not {variation}")
        return variation


NO_VARIATION = Variation()


@dataclass
class VariationConfig:
    """Bounds of what is drawn for each episode, evenly; 0 for what does not vary."""

    noise: float = option(0.0, "Greatest scale of the laser's noise, drawn from 0, added to laser.noise.", NOT_NEGATIVE)
    dropout: float = option(0.0, "Greatest dropout, drawn from 0, added to laser.dropout.", SHARE)
    latency: float = option(
        0.0, "Greatest latency of the laser, drawn from 0, added to laser.latency.", between(0, 2, " s")
    )
    friction: float = option(0.0, "Greatest share by which the wheels' friction is more or less.", _FACTOR)
    mass: float = option(0.0, "Greatest share by which the mass of the robot's base is more or less.", _FACTOR)

    def __post_init__(self) -> None:
        """TaskError where a value is out of range."""
        check_options(self)

    @property
    def is_off(self) -> bool:
        """Whether no episode differs."""
        return not any(vars(self).values())

    @property
    def disturbs_laser(self) -> bool:
        """Whether any episode's laser differs."""
        return bool(self.noise or self.dropout or self.latency)

    def draw(self, rng: np.random.Generator) -> Variation:
        """Draw one episode's; an rng that nothing varies by stays as it is."""
        if self.is_off:
            return NO_VARIATION
        noise, dropout, latency = rng.uniform(0.0, [self.noise, self.dropout, self.latency]).tolist()
        friction, mass = (1.0 + rng.uniform(-1.0, 1.0, 2) * [self.friction, self.mass]).tolist()
        return Variation(noise, dropout, latency, friction, mass)


class VariedBody:
    """Friction and mass of the robot, and what its file has."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Read a scene in which neither has been changed."""
        is_robot = np.asarray(model.body_rootid) == model.body("base").id
        self._base = int(np.where(is_robot, model.body_mass, 0.0).argmax())
        self._geoms = np.flatnonzero(is_robot[model.geom_bodyid])
        self._friction = model.geom_friction[self._geoms, 0].copy()
        self._mass, self._inertia = model.body_mass[self._base], model.body_inertia[self._base].copy()
        self._applied = (1.0, 1.0)

    def apply(self, physics: Physics, friction: float, mass: float) -> None:
        """Change them; the physical state is lost: call it at the beginning of an episode."""
        if (friction, mass) == self._applied:
            return
        model = physics.model.ptr
        model.geom_friction[self._geoms, 0] = friction * self._friction
        model.body_mass[self._base], model.body_inertia[self._base] = mass * self._mass, mass * self._inertia
        mujoco.mj_setConst(model, physics.data.ptr)
        physics.reset()
        self._applied = friction, mass
