"""Groups of training runs: what they ask for, which are finished, which are missing."""

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from tools.experiments.run_store import FinishedRun, R, Settings, find, with_effect

# Validations in every run, however long it is, so that figures over the last five of them mean the same.
VALIDATIONS = 20


@dataclass(frozen=True)
class Group:
    """Runs that differ in their seed alone."""

    title: str
    arguments: tuple[str, ...]
    steps: int
    seeds: Sequence[int]

    @property
    def options(self) -> tuple[str, ...]:
        """The words of `python -m asddpg.train` that its runs share."""
        every = max(1, self.steps // VALIDATIONS)
        return (f"total_steps={self.steps}", f"validation.every={every}", *self.arguments)

    def settings(self, seed: int) -> Settings:
        """What a run of it must have been trained with; UserError where a word is wrong."""
        return settings_of(self.options) | {"seed": seed}


@dataclass(frozen=True)
class Run:
    """A run to train."""

    name: str
    arguments: tuple[str, ...]
    settings: Settings


def settings_of(arguments: Sequence[str]) -> Settings:
    """Every option that bears on the learning, with its value; UserError where a word is wrong."""
    return with_effect(dataclasses.asdict(_composed(tuple(arguments))))


@functools.cache
def _composed(arguments: tuple[str, ...]) -> TrainConfig:
    return train_config(arguments)


def finished(groups: Mapping[str, Group], known: Sequence[R]) -> dict[str, list[R]]:
    """The finished runs of each group in the order of its seeds; one run may belong to several groups."""
    return {
        name: [run for seed in group.seeds if (run := find(group.settings(seed), known))]
        for name, group in groups.items()
    }


def missing(groups: Mapping[str, Group], known: Sequence[FinishedRun]) -> list[Run]:
    """The runs still to be trained, each experiment once, under the name of the first group that asks for it."""
    runs: list[Run] = []
    for name, group in groups.items():
        for seed in group.seeds:
            settings = group.settings(seed)
            if not find(settings, known) and all(run.settings != settings for run in runs):
                runs.append(Run(f"{name}_seed{seed}", (*group.options, f"seed={seed}"), settings))
    return runs
