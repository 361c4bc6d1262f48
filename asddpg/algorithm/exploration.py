"""Exploration noise."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from asddpg.episodes.batch_steps import Float32Array, IntArray

if TYPE_CHECKING:
    from asddpg.config import ExplorationConfig


class OrnsteinUhlenbeckNoise:
    """Noise that wanders: n ← n − θ n + σ 𝒩(0, 1), each action on its own (Lillicrap et al., 2016).

    It is in units of half an action's range, and fades linearly over training from full size to `final_scale`.
    """

    def __init__(
        self,
        half_range: npt.ArrayLike,
        config: "ExplorationConfig",
        total_steps: int,
        rng: np.random.Generator,
        robots: int = 1,
    ) -> None:
        """Make the noise, one that wanders for each robot.

        Args:
            half_range: (action_size,) half the range of each action, physical units.
            config: θ, σ, and how the noise fades.
            total_steps: of the training, of all robots together.
            rng: source of randomness.
            robots: their number.
        """
        self._half_range = np.asarray(half_range)
        self._theta, self._sigma = config.theta, config.sigma
        self._decay_steps, self._final_scale = round(config.decay * total_steps), config.final_scale
        self._rng = rng
        self._state = np.zeros((robots, len(self._half_range)))
        self._steps = 0

    def reset(self, robots: IntArray) -> None:
        """Reset the noise of these robots to zero; its scale keeps decaying."""
        self._state[robots] = 0.0

    def advance(self, steps: int) -> None:
        """So many steps of training have passed: the scale fades whether or not the policy drove."""
        self._steps += steps

    @property
    def scale(self) -> float:
        """Present size, 1 at first."""
        faded = min(1.0, self._steps / self._decay_steps) if self._decay_steps else 1.0
        return 1.0 + faded * (self._final_scale - 1.0)

    def sample(self, robots: IntArray) -> Float32Array:
        """The next noise of these robots, physical units: float32 (k, action_size)."""
        value = self._state[robots]
        value += -self._theta * value + self._sigma * self._rng.standard_normal(value.shape)
        self._state[robots] = value
        noise: Float32Array = (self.scale * value * self._half_range).astype(np.float32)
        return noise

    def state(self) -> dict[str, Any]:
        """Where it has wandered to, how far it has faded, and its randomness."""
        return {"value": self._state.copy(), "steps": self._steps, "rng": self._rng.bit_generator.state}

    def load_state(self, state: dict[str, Any]) -> None:
        """Restore what state() returned."""
        self._state[:] = state["value"]
        self._steps = state["steps"]
        self._rng.bit_generator.state = state["rng"]
