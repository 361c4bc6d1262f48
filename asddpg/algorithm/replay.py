"""The replay buffer R of Algorithm 1."""

from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from asddpg.episodes.protocols import Action, Observation

Float32Array = npt.NDArray[np.float32]


class Transition(NamedTuple):
    """(x, a, r, x', σ) of the paper, and the discount of what follows."""

    observation: Observation
    action: Action
    reward: float  # r of y^A
    switch_reward: float  # r of y^Q, which may charge for the controller's help
    discount: float  # 0 after the end of an episode, 1 otherwise, a time limit included; γ^(n − 1) over n steps
    next_observation: Observation
    by_policy: float  # σ: 1 where the policy drove, 0 where the controller did
    controller_action: Action  # what the controller would have done; the action itself where there is none


class Replay(Protocol):
    """Where transitions are kept and drawn from."""

    @property
    def layout(self) -> "TransitionLayout":
        """Columns of each part of a transition in a packed row."""

    def __len__(self) -> int:
        """How many transitions are kept."""

    def add(self, transition: Transition) -> None:
        """Store a transition."""

    def sample(self, batch_size: int) -> Float32Array:
        """Draw transitions: packed rows, float32 (batch_size, layout.width)."""

    def state(self) -> dict[str, Any]:
        """Everything that is kept, and the randomness of drawing; arrays are views, to be written at once."""

    def load_state(self, state: dict[str, Any]) -> None:
        """Restore what state() returned."""


class ReplayBuffer:
    """A ring of transitions, each one packed row: a batch is drawn with a single gather."""

    def __init__(self, capacity: int, observation_size: int, action_size: int, rng: np.random.Generator) -> None:
        """Hold up to `capacity` transitions; memory grows as it fills."""
        self._layout = TransitionLayout(observation_size, action_size)
        self._rows = np.zeros((capacity, self._layout.width), dtype=np.float32)
        self._capacity = capacity
        self._rng = rng
        self._next = 0
        self._size = 0

    def __len__(self) -> int:
        return self._size

    @property
    def layout(self) -> "TransitionLayout":
        """Columns of each part of a transition in a packed row."""
        return self._layout

    def add(self, transition: Transition) -> None:
        """Store a transition, over the oldest one where the ring is full."""
        row, layout = self._rows[self._next], self._layout
        row[layout.observation] = transition.observation
        row[layout.action] = transition.action
        row[layout.reward] = transition.reward
        row[layout.switch_reward] = transition.switch_reward
        row[layout.discount] = transition.discount
        row[layout.by_policy] = transition.by_policy
        row[layout.next_observation] = transition.next_observation
        row[layout.controller_action] = transition.controller_action
        self._next = (self._next + 1) % self._capacity
        self._size = min(self._size + 1, self._capacity)

    def sample(self, batch_size: int) -> Float32Array:
        """Draw transitions uniformly, with replacement: packed rows, float32 (batch_size, layout.width)."""
        return self._rows[self._rng.integers(self._size, size=batch_size)]

    def state(self) -> dict[str, Any]:
        """The rows as they lie in the ring, float32 (size, layout.width), where the next goes, and the randomness."""
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

    def __len__(self) -> int:
        return len(self._policy) + len(self._controller)

    @property
    def layout(self) -> "TransitionLayout":
        """Columns of each part of a transition in a packed row."""
        return self._policy.layout

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


class TransitionLayout:
    """Columns of a packed transition: x, a, r twice, discount, σ, x', controller's action."""

    def __init__(self, observation_size: int, action_size: int) -> None:
        self.observation = slice(0, observation_size)
        self.action = slice(observation_size, observation_size + action_size)
        self.reward = self.action.stop
        self.switch_reward = self.reward + 1
        self.discount = self.reward + 2
        self.by_policy = self.reward + 3
        self.next_observation = slice(self.reward + 4, self.reward + 4 + observation_size)
        self.controller_action = slice(self.next_observation.stop, self.next_observation.stop + action_size)
        self.width = self.controller_action.stop
