"""Recordings of every kind, for the check in Node: `python -m tests.node.make_recordings FOLDER`."""

import itertools
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from asddpg import evaluate, train
from asddpg.build import make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver, Observation
from asddpg.recording.files.recovery import recover
from asddpg.recording.recorder import Recorder, Selection, every_nth
from asddpg.runs.provenance import environment_hash, recording_provenance, versions
from tests.conftest import TINY

CUT_AFTER = 25  # steps

EVALUATIONS = (
    ("agent=controller", "task=nav_gazebo"),
    ("agent=random", "task=nav_office"),
    ("run=pretrained:nav_complex",),
    ("run=pretrained:nav_simple", "driver=switch"),
)


def record_turning(folder: Path, steps: int, before_step: Callable[[int], None] = lambda _: None) -> Path:
    """Record so many steps of a robot that turns on the spot."""
    config = train_config(["task=nav_complex"])
    environment = make_environment(config.task, config.reward)
    provenance = versions() | {"model_hash": environment_hash(environment)}
    origin = recording_provenance(config, provenance)
    recorder = Recorder(folder, navigation_env(environment), origin, Selection(every_nth(1)), print)
    count = itertools.count()

    def decide(_: Observation) -> Decision:
        before_step(next(count))
        return Decision(np.array([0.0, 0.5], dtype=np.float32), Driver.POLICY)

    environment.reset(seed=101)
    run_episode(environment, FixedDriver(decide), (recorder,), max_steps=steps)
    assert recorder.last is not None
    return recorder.last


def make_part(folder: Path) -> Path:
    """The .mcap.part of a process that is killed in step CUT_AFTER."""

    def keep_part(count: int) -> None:
        if count == CUT_AFTER:
            (part,) = (folder / "whole").glob("*.part")
            shutil.copy(part, folder)

    record_turning(folder / "whole", CUT_AFTER + 1, keep_part)
    (part,) = folder.glob("*.part")
    return part


def main(folder: Path) -> None:
    """Make them all, each kind in a folder of its own."""
    for number, arguments in enumerate(EVALUATIONS):
        own = folder / f"evaluation_{number}"
        own.mkdir()
        os.chdir(own)
        evaluate.main([*arguments, "episodes=2", "record.every=1"])
    train.main(["task=nav_simple", *TINY, "record.every=3", "task.laser.latency=0.25", f"run_dir={folder / 'run'}"])
    recover(make_part(folder / "killed"))


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
