"""Drives a case: its stored pairs, one after the other, with every decision timed."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import SupportsFloat

from asddpg.episodes.evaluation import evaluate
from asddpg.episodes.protocols import Agent, Decision, Episode, Observation, Observer, Step
from asddpg.runs.provenance import current_versions
from tasks.room_geometry.held_out import Pair
from tools.comparison.cases import Case
from tools.comparison.driven_episodes import DrivenCase, DrivenEpisode
from tools.comparison.smoothness import measure_smoothness

MS = 1000.0  # a second


class TimedDriver:
    """A driver, and what its decisions of the present episode took.

    Attributes:
        decision_ms: CPU time of each decision, of all threads of this process, milliseconds.
        turn_rates: that were chosen, rad/s.
    """

    def __init__(self, driver: Agent) -> None:
        self._driver = driver
        self.decision_ms: list[float] = []
        self.turn_rates: list[float] = []

    def begin_episode(self) -> None:
        """Forget the episode before."""
        self.decision_ms, self.turn_rates = [], []
        self._driver.begin_episode()

    def decide(self, observation: Observation) -> Decision:
        """Decide as the driver does."""
        begun = time.process_time()
        decision = self._driver.decide(observation)
        self.decision_ms.append(MS * (time.process_time() - begun))
        self.turn_rates.append(float(decision.action[1]))
        return decision

    def learn(self, step: Step) -> Mapping[str, SupportsFloat]:
        """Learn as the driver does."""
        return self._driver.learn(step)


class _Collector(Observer):
    """Keeps every episode along some pairs."""

    def __init__(self, driver: TimedDriver, pairs: Sequence[Pair], room: str) -> None:
        self._driver, self._pairs, self._room = driver, iter(pairs), room
        self.episodes: list[DrivenEpisode] = []
        self.decision_ms: list[float] = []

    def end_episode(self, episode: Episode) -> None:
        """Keep the episode of the next pair."""
        pair, driver = next(self._pairs), self._driver
        smoothness = measure_smoothness(driver.turn_rates)
        took = median(driver.decision_ms)
        self.episodes.append(
            DrivenEpisode(pair.room or self._room, pair.start, pair.goal, pair.shortest_path, episode, smoothness, took)
        )
        self.decision_ms += driver.decision_ms


def drive(case: Case, folder: Path) -> None:
    """Drive all episodes of a case and write its file.

    Raises:
        UserError: the driver cannot be made, or gives no action.
    """
    episodes: list[DrivenEpisode] = []
    decision_ms: list[float] = []
    for room in case.rooms:
        setup = case.set_up(folder, room)
        pairs = case.pairs(setup, room)
        driver = TimedDriver(setup.drivers[setup.name])
        collector = _Collector(driver, pairs, room)
        evaluate(setup.environment, driver, pairs, setup.config.task.control_timestep, (collector,))
        setup.environment.close()
        episodes += collector.episodes
        decision_ms += collector.decision_ms
    first = case.set_up(folder)
    driven = DrivenCase(case.conditions(first), current_versions(first.environment), median(decision_ms), episodes)
    driven.write(case.path(folder, first))
    first.environment.close()
