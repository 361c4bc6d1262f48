"""The progress bar."""

import os
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

from tqdm import tqdm

from asddpg.episodes.batch_steps import Steps
from asddpg.episodes.protocols import Episode
from asddpg.episodes.training_episodes import Learned, TrainingObserver
from asddpg.messages import ERR, print_line
from asddpg.observers.metrics_log import RecentOutcomes

T = TypeVar("T")
ON_TERMINAL, IN_FILE = 0.5, 10.0  # seconds between two states; a file keeps every one of them


def _options() -> dict[str, Any]:
    return {"file": ERR, "mininterval": ON_TERMINAL if os.isatty(2) else IN_FILE, "dynamic_ncols": True}


class ProgressBar(TrainingObserver):
    """Steps a second, time left, outcomes of the last 100 episodes, controller share of the last 1000 steps or so."""

    def __init__(self, total_steps: int, steps: int = 0, outcomes: Iterable[str] = ()) -> None:
        """Go on after so many steps, and after episodes that ended so."""
        self._bar = tqdm(total=total_steps, initial=steps, unit=" steps", smoothing=0.05, **_options())
        self._recent = RecentOutcomes(outcomes)
        self._share = 0.0

    def step(self, steps: Steps, learned: Learned) -> None:
        """Move on by a step of each robot."""
        by_controller = steps.decisions.by_controller
        self._share += (1.0 - 0.999 ** len(by_controller)) * (float(by_controller.mean()) - self._share)
        self._bar.update(len(by_controller))

    def end_episode(self, robot: int, number: int, episode: Episode) -> None:
        """Show the outcomes."""
        self._recent.append(episode.outcome)
        share = self._recent.share
        self._bar.set_postfix_str(
            f"success {share('reached'):.2f} collision {share('crashed'):.2f} time-out {share('timeout'):.2f} "
            f"controller {self._share:.2f}",
            refresh=False,
        )

    def print_line(self, text: str) -> None:
        """Print a line above the bar."""
        self._bar.clear()
        print_line(text)
        self._bar.refresh()

    def close(self) -> None:
        """Close the bar and leave it on the screen."""
        self._bar.close()


def count_episodes(pairs: Sequence[T]) -> Iterable[T]:
    """The pairs of an evaluation, with a bar that counts them as they are driven."""
    return tqdm(pairs, unit=" episodes", leave=False, **_options())
