"""A row for each training step, to steps.f32 and steps.npz: pose, driver, actions and Q-values."""

import io
from pathlib import Path
from typing import Any

import numpy as np

from asddpg.atomic_write import write_whole
from asddpg.episodes.batch_steps import Float32Array, FloatArray, Infos, IntArray, Steps
from asddpg.episodes.protocols import Episode
from asddpg.episodes.training_episodes import Learned, TrainingObserver

COLUMNS = (
    "episode", "x", "y", "distance", "by_controller",
    "actor_v", "actor_omega", "v", "omega", "q_policy", "q_controller",
)  # fmt: skip


class StepLog(TrainingObserver):
    """Writes the steps of a training, 44 bytes each, in their order, and all as columns when it is closed.

    `episode`, its number · `x`, `y`, `distance` to the goal (m) where the choice was made · `by_controller`, 1 where
    the controller drove · `actor_v`, `actor_omega` the actor's action before noise (m/s, rad/s) · `v`, `omega` what
    was executed · `q_policy`, `q_controller`, nan without a switch. Each float32 (steps,); robots follow one another
    in each step.
    """

    def __init__(self, rows: Path, columns: Path) -> None:
        """Open `rows`, which grows during the training; existing rows are kept.

        close() writes them as named columns to `columns`, .npz.
        """
        self._columns = columns
        self._file = rows.open("a+b")
        self._where: FloatArray = np.zeros((0, 4))

    def go_on(self, numbers: IntArray, infos: Infos) -> None:
        """Go on at a present instant, in episodes of these numbers."""
        self._where = np.column_stack((numbers, infos["pose"][:, :2], infos["distance"]))

    def begin_episodes(self, robots: IntArray, numbers: IntArray, observations: Float32Array, infos: Infos) -> None:
        """Record the place of the first choice."""
        if not len(self._where):
            self._where = np.zeros((len(observations), 4))
        self._where[robots, 0] = numbers
        self._where[:, 1:] = np.column_stack((infos["pose"][:, :2], infos["distance"]))

    def step(self, steps: Steps, learned: Learned) -> None:
        """Add a row for each robot; its place is that before the step, where the choice was made."""
        decisions = steps.decisions
        q = np.full((len(self._where), 2), np.nan) if decisions.q is None else decisions.q
        parts = (self._where, decisions.by_controller, decisions.actor_actions, decisions.actions, q)
        self._file.write(np.column_stack(parts).astype(np.float32).tobytes())
        self._where[:, 1:] = np.column_stack((steps.infos["pose"][:, :2], steps.infos["distance"]))

    def end_episode(self, robot: int, number: int, episode: Episode) -> None:
        """Show the rows to readers."""
        self._file.flush()

    def flush(self) -> None:
        """Write all rows to the file."""
        self._file.flush()

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
