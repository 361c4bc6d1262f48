"""A row for each training step, to steps.f32 and steps.npz: pose, driver, actions and Q-values."""

import io
from array import array
from collections.abc import Mapping
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np

from asddpg.atomic_write import write_whole
from asddpg.episodes.protocols import Driver, Episode, Observation, Observer, Step

COLUMNS = (
    "episode", "x", "y", "distance", "by_controller",
    "actor_v", "actor_omega", "v", "omega", "q_policy", "q_controller",
)  # fmt: skip

_NAN = float("nan")


class StepLog(Observer):
    """Writes the steps of a training, 44 bytes each, episode by episode, and all as columns when it is closed.

    `episode`, counted from 1 · `x`, `y`, `distance` to the goal (m) where the choice was made · `by_controller`, 1
    where the controller drove · `actor_v`, `actor_omega` the actor's action before noise (m/s, rad/s) · `v`,
    `omega` what was executed · `q_policy`, `q_controller`, nan without a switch. Each float32 (steps,).
    """

    def __init__(self, rows: Path, columns: Path, episodes: int = 0) -> None:
        """Open `rows`, which grows during the training; existing rows, of so many episodes, are kept.

        close() writes them as named columns to `columns`, .npz.
        """
        self._columns = columns
        self._file = rows.open("a+b")
        self._values = array("f")
        self._episode = episodes
        self._where: tuple[float, ...] = (_NAN, _NAN, _NAN)

    def state(self) -> dict[str, Any]:
        """Of the episode in progress: its rows, and the place of the next choice."""
        return {"rows": np.array(self._values, dtype=np.float32), "place": list(self._where)}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on in the middle of an episode, with what state() returned."""
        self._episode += 1
        self._values = array("f", state["rows"].tobytes())
        self._where = tuple(state["place"])

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Record the place of the first choice."""
        self._values = array("f")
        self._episode += 1
        self._where = (*info["pose"][:2], info["distance"])

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Add a row; its place is that before the step, where the choice was made."""
        decision = step.decision
        actor_action = decision.action if decision.actor_action is None else decision.actor_action
        self._values.extend(
            (
                self._episode,
                *self._where,
                decision.driver is Driver.CONTROLLER,
                *actor_action.tolist(),
                *decision.action.tolist(),
                _NAN if decision.q_policy is None else decision.q_policy,
                _NAN if decision.q_controller is None else decision.q_controller,
            )
        )
        self._where = (*step.info["pose"][:2], step.info["distance"])

    def end_episode(self, episode: Episode) -> None:
        """Write its rows."""
        self._file.write(self._values.tobytes())
        self._file.flush()
        self._values = array("f")

    def close(self) -> None:
        """Write the columns, whole or not at all."""
        with self._file as file:
            file.seek(0)
            numbers = np.frombuffer(file.read(), dtype=np.uint8)
        row = 4 * len(COLUMNS)  # bytes; a full disk may have cut the last one
        table = numbers[: len(numbers) // row * row].view(np.float32).reshape(-1, len(COLUMNS))
        columns: dict[str, Any] = dict(zip(COLUMNS, table.T, strict=True))
        content = io.BytesIO()
        np.savez_compressed(content, **columns)
        write_whole(self._columns, content.getbuffer())
