"""Where a policy of changing rooms drives and where it fails: by generator, and in the rooms of the other tasks."""

import dataclasses
from collections.abc import Iterator, Sequence
from itertools import groupby

from asddpg.build import make_environment
from asddpg.config import TrainConfig
from asddpg.episodes.evaluation import evaluate
from asddpg.episodes.protocols import Agent
from asddpg.observers.progress import count_episodes
from tasks.evaluation_pairs import stored_pairs
from tasks.registry import ROOM_TASKS
from tools.experiments.tables import markdown
from tools.publishing.failures import OUTCOME_TITLES, DrivenEpisode, EndingsLog


def generator_table(drives: Sequence[DrivenEpisode]) -> str:
    """Markdown: outcomes by the generator of the room, for episodes of task=nav_anywhere."""
    ordered = sorted(drives, key=_generator)
    return _outcome_table("generator", ((name, [*each]) for name, each in groupby(ordered, _generator)))


def elsewhere_table(config: TrainConfig, driver: Agent, episodes: int) -> str:
    """Drive the first stored test pairs of each task of one room; Markdown: outcomes by task."""
    return _outcome_table("task", _drive_tasks(config, driver, episodes))


def _drive_tasks(config: TrainConfig, driver: Agent, episodes: int) -> Iterator[tuple[str, list[DrivenEpisode]]]:
    for name in ROOM_TASKS:
        task = dataclasses.replace(config.task, name=name)
        pairs = stored_pairs(name, "test", task.goal_radius, episodes, task.robot)
        environment, log = make_environment(task, config.reward), EndingsLog()
        evaluate(environment, driver, count_episodes(pairs), task.control_timestep, (log,))
        environment.close()
        yield name, log.drives(pairs)


def _generator(drive: DrivenEpisode) -> str:
    return drive.pair.room.partition(":")[0]


def _outcome_table(title: str, groups: Iterator[tuple[str, list[DrivenEpisode]]]) -> str:
    rows = []
    for name, drives in groups:
        counts = [sum(drive.outcome == outcome for drive in drives) for outcome in OUTCOME_TITLES]
        rows.append([name, f"{counts[0] / len(drives):.3f}", *map(str, [len(drives), *counts])])
    return markdown([title, "success rate", "pairs", *OUTCOME_TITLES.values()], rows)
