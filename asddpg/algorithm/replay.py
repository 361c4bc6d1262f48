"""The replay buffer R of Algorithm 1."""

from typing import Any, NamedTuple

import numpy as np

from asddpg.algorithm.observation_ring import ObservationRing
from asddpg.episodes.batch_steps import BoolArray, Float32Array, FloatArray, IntArray


class Transitions(NamedTuple):
    """(x, a, r, σ, x') of the paper for k steps, a row each, and the discount of what follows."""

    observation: IntArray  # (k,), numbers in the ObservationRing
    action: Float32Array  # (k, action_size)
    reward: FloatArray  # (k,), r of y^A
    switch_reward: FloatArray  # (k,), r of y^Q, which may charge for the controller's help
    discount: FloatArray  # (k,), 0 after an end, 1 otherwise, a time limit included; γ^(n − 1) over n steps
    by_policy: FloatArray  # (k,), σ: 1 where the policy drove, 0 where the controller did
    next_observation: IntArray  # (k,), numbers
    controller_action: Float32Array  # (k, action_size), the controller's; the action itself where there is none

    def of(self, rows: BoolArray) -> "Transitions":
        """Those of the chosen rows."""
        chosen: list[Any] = [values[rows] for values in self]
        return Transitions(*chosen)


class TransitionLayout(NamedTuple):
    """Columns of a packed row, in the order of Transitions."""

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


class ReplayShape(NamedTuple):
    """What a replay buffer holds.

    Attributes:
        capacity: transitions; fewer are held where episodes are shorter than 8 steps.
        observation_size: numbers in an observation.
        action_size: numbers in an action.
        scan_shape: (scans, beams) at the head of an observation, whose scans are kept once; None for other ones.
        n_steps: that a transition reaches ahead.
        robots: whose steps are added together.
    """

    capacity: int
    observation_size: int
    action_size: int
    scan_shape: tuple[int, int] | None = None
    n_steps: int = 1
    robots: int = 1

    @property
    def disorder(self) -> int:
        """Observations by which transitions may be out of order: a robot's last ones are added before their time."""
        scans = self.scan_shape[0] if self.scan_shape else 1
        return 2 * self.robots * (self.n_steps + scans)

    @property
    def observations(self) -> int:
        """Observations that are held; an episode begins with one of its own."""
        return self.capacity + self.capacity // 8 + 2 * self.disorder

    @property
    def numbers(self) -> int:
        """Numbers of four bytes in a full buffer."""
        scans, beams = self.scan_shape or (1, self.observation_size)
        observation = self.observation_size - (scans - 1) * beams + 2 * scans
        return self.observations * observation + self.capacity * (2 * self.action_size + 10)


class ReplayBuffer:
    """A ring of transitions, and a ring of the observations that they name."""

    def __init__(self, shape: ReplayShape, rng: np.random.Generator) -> None:
        """Make an empty one, whose memory grows as it fills.

        Args:
            shape: what it holds.
            rng: draws the samples.
        """
        capacity, action_size = shape.capacity, shape.action_size
        self.layout = TransitionLayout.build(shape.observation_size, action_size)
        self._disorder = shape.disorder
        self._observations = ObservationRing(shape.observations, shape.observation_size, shape.scan_shape, shape.robots)
        self._capacity, self._rng = capacity, rng
        self._numbers = np.zeros((capacity, 2), np.int64)  # of x and x'
        self._rows = np.zeros((capacity, 2 * action_size + 4), np.float32)  # the other columns, in their order
        self._oldest_scan = np.zeros(capacity, np.int64)
        self._begin = self._end = 0  # running numbers of the oldest transition and of the next one

    def __len__(self) -> int:
        return self._end - self._begin

    def observe(self, observations: Float32Array, robots: IntArray) -> IntArray:
        """Keep what robots observe, (k, observation_size); returns the numbers that transitions name, (k,)."""
        return self._observations.add(observations, robots)

    def add(self, transitions: Transitions) -> None:
        """Store transitions, over the oldest ones where the ring is full."""
        count = len(transitions.reward)
        at = np.arange(self._end, self._end + count) % self._capacity
        self._numbers[at, 0], self._numbers[at, 1] = transitions.observation, transitions.next_observation
        middle = (transitions.reward, transitions.switch_reward, transitions.discount, transitions.by_policy)
        self._rows[at] = np.column_stack((transitions.action, *middle, transitions.controller_action))
        self._oldest_scan[at] = self._observations.oldest_scans(transitions.observation)
        self._end += count
        self._begin = max(self._begin, self._end - self._capacity)
        first = self._observations.first + self._disorder
        while len(self) and self._oldest_scan[self._begin % self._capacity] < first:
            self._begin += 1

    def sample(self, batch_size: int) -> Float32Array:
        """Draw transitions uniformly, with replacement: packed rows, float32 (batch_size, layout.width)."""
        return self._packed(self._begin + self._rng.integers(len(self), size=batch_size))

    def _packed(self, numbers: IntArray) -> Float32Array:
        at, layout = numbers % self._capacity, self.layout
        packed = np.empty((len(at), layout.width), np.float32)
        self._observations.write(self._numbers[at, 0], packed[:, layout.observation])
        self._observations.write(self._numbers[at, 1], packed[:, layout.next_observation])
        action_size, rows = layout.action.stop - layout.action.start, self._rows[at]
        packed[:, layout.action.start : layout.next_observation.start] = rows[:, : action_size + 4]
        packed[:, layout.controller_action] = rows[:, action_size + 4 :]
        return packed

    def state(self) -> dict[str, Any]:
        """Views of the rings, the running numbers and the random stream."""
        size = min(self._end, self._capacity)
        return {
            "numbers": self._numbers[:size],
            "rows": self._rows[:size],
            "oldest_scan": self._oldest_scan[:size],
            "begin": self._begin,
            "end": self._end,
            "observations": self._observations.state(),
            "rng": self._rng.bit_generator.state,
        }

    def load_state(self, state: dict[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            ValueError: it is of a ring of another size.
        """
        size = min(state["end"], self._capacity)
        if len(state["rows"]) != size:
            raise ValueError(f"a replay buffer of {self._capacity} cannot take {len(state['rows'])} transitions")
        self._observations.load_state(state["observations"])
        self._begin, self._end = state["begin"], state["end"]
        self._numbers[:size], self._rows[:size] = state["numbers"], state["rows"]
        self._oldest_scan[:size] = state["oldest_scan"]
        self._rng.bit_generator.state = state["rng"]


class BalancedReplay(ReplayBuffer):
    """A replay buffer of whose batches half are the policy's steps and half the controller's."""

    def sample(self, batch_size: int) -> Float32Array:
        """Draw half of each driver's, all of one's while there is none of the other's: float32 (batch_size, width)."""
        numbers = np.arange(self._begin, self._end)
        by_policy = self._rows[numbers % self._capacity, self.layout.by_policy - self.layout.action.start] > 0.5
        groups = [group for group in (numbers[by_policy], numbers[~by_policy]) if len(group)]
        sizes = (batch_size // 2, batch_size - batch_size // 2) if len(groups) == 2 else (batch_size,)
        drawn = [self._rng.choice(group, size) for group, size in zip(groups, sizes, strict=True)]
        return self._packed(np.concatenate(drawn))
