"""Recordings of every kind, for the check in Node: `python -m tests.node.make_recordings FOLDER`."""

import dataclasses
import os
import shutil
import sys
from pathlib import Path

import numpy as np

from asddpg import evaluate, train
from asddpg.build import make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver, Observation
from asddpg.recording.recorder import Recorder, Selection, every_nth
from asddpg.runs.provenance import environment_hash, recording_provenance, versions
from asddpg.runs.run_folder import config_text
from tests.conftest import TINY
from tools.recover import recover

CUT_AFTER = 25  # steps

EVALUATIONS = (
    ("agent=controller", "task=nav_gazebo"),
    ("agent=random", "task=nav_office"),
    ("run=pretrained:nav_complex",),
    ("run=pretrained:nav_simple", "driver=switch"),
)


def left_behind(folder: Path) -> Path:
    """The .mcap.part that a process leaves which is killed in step CUT_AFTER; the robot turns on the spot."""
    config = train_config(["task=nav_complex"])
    environment = make_environment(config.task, config.reward)
    made_with = versions() | {"model_hash": environment_hash(environment)}
    provenance = recording_provenance(config, config_text(dataclasses.asdict(config), made_with), made_with)
    recorder = Recorder(folder / "whole", navigation_env(environment), provenance, Selection(every_nth(1)), print)
    count = iter(range(CUT_AFTER + 1))

    def decide(_: Observation) -> Decision:
        if next(count) == CUT_AFTER:
            (part,) = (folder / "whole").glob("*.part")
            shutil.copy(part, folder)
        return Decision(np.array([0.0, 0.5], dtype=np.float32), Driver.POLICY)

    environment.reset(seed=101)
    run_episode(environment, FixedDriver(decide), (recorder,), max_steps=CUT_AFTER + 1)
    recorder.close()
    (left,) = folder.glob("*.part")
    return left


def main(folder: Path) -> None:
    """Make them all, each kind in a folder of its own."""
    for number, arguments in enumerate(EVALUATIONS):
        own = folder / f"evaluation_{number}"
        own.mkdir()
        os.chdir(own)
        evaluate.main([*arguments, "episodes=2", "record.every=1"])
    train.main(["task=nav_simple", *TINY, "record.every=3", f"run_dir={folder / 'run'}"])
    recover(left_behind(folder / "killed"))


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
