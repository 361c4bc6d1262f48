"""The replay buffer R of Algorithm 1."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from asddpg.episodes.protocols import Action, Observation

Float32Array = npt.NDArray[np.float32]


class Transition(NamedTuple):
    """(x, a, r, σ, x') of the paper, and the discount of what follows."""

    observation: Observation
    action: Action
    reward: float  # r of y^A
    switch_reward: float  # r of y^Q, which may charge for the controller's help
    discount: float  # 0 after the end of an episode, 1 otherwise, a time limit included; γ^(n − 1) over n steps
    by_policy: float  # σ: 1 where the policy drove, 0 where the controller did
    next_observation: Observation
    controller_action: Action  # what the controller would have done; the action itself where there is none


class TransitionLayout(NamedTuple):
    """Columns of a packed row, in the order of Transition."""

    observation: slice
    action: slice
    reward: int
    switch_reward: int
    discount: int
    by_policy: int
    next_observation: slice
    controller_action: slice

    @classmethod
    def build(cls, observation_size: int, action_size: int) -> "TransitionLayout":
        """The layout for observations and actions of these lengths."""
        x, a = observation_size, observation_size + action_size
        x_next = a + 4 + observation_size
        columns = (slice(a + 4, x_next), slice(x_next, x_next + action_size))
        return cls(slice(0, x), slice(x, a), a, a + 1, a + 2, a + 3, *columns)

    @property
    def width(self) -> int:
        """Length of a row."""
        width: int = self.controller_action.stop
        return width


class ReplayBuffer:
    """A ring of transitions, each one packed row: a batch is drawn with a single gather."""

    def __init__(self, capacity: int, observation_size: int, action_size: int, rng: np.random.Generator) -> None:
        """Hold up to `capacity` transitions; memory grows as it fills."""
        self.layout = TransitionLayout.build(observation_size, action_size)
        self._rows = np.zeros((capacity, self.layout.width), dtype=np.float32)
        self._capacity = capacity
        self._rng = rng
        self._next = self._size = 0

    def __len__(self) -> int:
        return self._size

    def add(self, transition: Transition) -> None:
        """Store a transition, over the oldest one where the ring is full."""
        row = self._rows[self._next]
        for columns, value in zip(self.layout, transition, strict=True):
            row[columns] = value
        self._next = (self._next + 1) % self._capacity
        self._size = min(self._size + 1, self._capacity)

    def sample(self, batch_size: int) -> Float32Array:
        """Draw transitions uniformly, with replacement: packed rows, float32 (batch_size, layout.width)."""
        return self._rows[self._rng.integers(self._size, size=batch_size)]

    def state(self) -> dict[str, Any]:
        """A view of the rows in the ring, float32 (size, layout.width), the next row's index and the random stream."""
        return {"rows": self._rows[: self._size], "next": self._next, "rng": self._rng.bit_generator.state}

    def load_state(self, state: dict[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            ValueError: it is of a ring of another size.
        """
        size, following = len(state["rows"]), state["next"]
        if size > self._capacity or following != (size if size < self._capacity else following % size):
            raise ValueError(
                f"a replay buffer of {self._capacity} cannot take {size} rows with the next at {following}"
            )
        self._size, self._next = size, following
        self._rows[: self._size] = state["rows"]
        self._rng.bit_generator.state = state["rng"]


class BalancedReplay:
    """Two rings, the policy's steps and the controller's: a batch is half from each."""

    def __init__(self, capacity: int, observation_size: int, action_size: int, rng: np.random.Generator) -> None:
        """Hold up to `capacity` transitions in each."""
        self._policy, self._controller = (ReplayBuffer(capacity, observation_size, action_size, rng) for _ in range(2))
        self.layout = self._policy.layout

    def __len__(self) -> int:
        return len(self._policy) + len(self._controller)

    def add(self, transition: Transition) -> None:
        """Store a transition with its driver's."""
        (self._policy if transition.by_policy else self._controller).add(transition)

    def sample(self, batch_size: int) -> Float32Array:
        """Draw half from each ring, all from one while the other is empty: float32 (batch_size, layout.width)."""
        if not len(self._policy) or not len(self._controller):
            return (self._policy if len(self._policy) else self._controller).sample(batch_size)
        half = batch_size // 2
        return np.concatenate([self._policy.sample(half), self._controller.sample(batch_size - half)])

    def state(self) -> dict[str, Any]:
        """Both rings; they share one random stream, which each holds."""
        return {"policy": self._policy.state(), "controller": self._controller.state()}

    def load_state(self, state: dict[str, Any]) -> None:
        """Restore what state() returned."""
        self._policy.load_state(state["policy"])
        self._controller.load_state(state["controller"])
