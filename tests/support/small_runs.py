"""Small runs that are stopped, resumed and compared with unbroken ones."""

import json
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from asddpg import train
from asddpg.recording.files.reading import open_recording
from asddpg.runs import state_files
from asddpg.training import Training

# A second each: ten episodes, two validations, a checkpoint every 50 steps.
QUICK = ["task=nav_empty", "total_steps=240", "task.time_limit_steps=30", "checkpoint_every=50", "record.every=2"]
QUICK += [
    "agent.learning_starts=40",
    "agent.batch_size=8",
    "agent.samples_per_step=8",
    "network.widths=[16,16]",
    "network.convolutions=none",
    "network.ranges=linear",
]
QUICK += ["robots=1", "validation.every=100", "validation.episodes=1", "test_episodes=1"]

DRAWING = ["agent=astd3", "agent.balanced_batches=true", "agent.n_steps=3", "agent.withdrawal.stretch_steps=7"]
DRAWING += ["agent.withdrawal.first_share=0.3", "task.laser.noise=1", "task.laser.dropout=0.05"]
DRAWING += ["task.laser.latency=0.1"]

VARYING = ["task=nav_anywhere", "task.variation.noise=1", "task.variation.latency=0.3", "task.variation.mass=0.3"]
VARYING += ["task.variation.friction=0.3"]

KINDS = {
    "default": [],
    "everything that draws": DRAWING,
    "ddpg": ["agent=ddpg"],
    "many robots": [*DRAWING, "robots=4", "agent.samples_per_step=5", "agent.batch_size=7"],
    "a buffer that wraps": [*DRAWING, "agent.buffer_size=60"],
    "a room for each episode": [*VARYING, "robots=4", "agent.samples_per_step=5", "agent.batch_size=7"],
    "things that can be pushed": ["task=nav_gazebo", "agent.n_steps=5", "record.every=3"],
}


class Harmful:
    """Runs code where it is unpickled, which leaves the file `ran`."""

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return (exec, ("open('ran', 'w').close()",))


class Died(BaseException):
    """Stands for the end of a process; nothing catches it."""


def die() -> None:
    raise Died


def interrupt() -> None:
    """As Ctrl-C does."""
    os.kill(os.getpid(), signal.SIGINT)


def at_step(patch: pytest.MonkeyPatch, step: int, act: Callable[[], None]) -> None:
    """Act after a training step, before what comes after it."""
    real, acted = Training._save_state_if_due, False

    def save_state_if_due(self: Training) -> None:
        nonlocal acted
        real(self)
        if self.step >= step and not acted:
            acted = True
            act()

    patch.setattr(Training, "_save_state_if_due", save_state_if_due)


def stopped(arguments: list[str], step: int, act: Callable[[], None] = interrupt) -> int:
    """Train up to a step and no further; the status that the process would have ended with."""
    with pytest.MonkeyPatch.context() as patch:
        at_step(patch, step, act)
        try:
            train.main(arguments)
        except Died:
            return -9
        except SystemExit as ended:
            return int(str(ended.code))
    raise AssertionError(f"it has not come to step {step}")


def newest_state(run: Path) -> dict[str, Any]:
    return state_files.read(sorted((run / "resume").glob("step_????????"))[-1])


def assert_same_run(one: Path, other: Path, kills: int = 0) -> None:
    """All that a run holds is the same to the last bit, but what the clock writes; `other` was killed so often."""
    for name in ("metrics.csv", "validation.csv"):
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    assert json.loads((one / "test.json").read_text()) == json.loads((other / "test.json").read_text())
    with np.load(one / "steps.npz") as steps, np.load(other / "steps.npz") as others:
        assert_same_tree(dict(steps), dict(others), "steps")
    names = sorted(str(path.relative_to(one)) for path in one.glob("checkpoints/*.safetensors"))
    assert names == sorted(str(path.relative_to(other)) for path in other.glob("checkpoints/*.safetensors"))
    for name in names:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    first, second = (newest_state(run) for run in (one, other))
    for name in ("step", "best", "episodes"):
        assert_same_tree(first[name], second[name], name)
    assert_same_recordings(one / "episodes", other / "episodes", kills)
    assert scalars(one) == scalars(other)


def assert_same_recordings(one: Path, other: Path, kills: int = 0) -> None:
    """The same files with the same messages, but for an episode that `other` recorded up to where it was stopped.

    A kill within the first steps of an episode leaves none of it.
    """
    cut = {path.name.removesuffix("_cut.mcap") for path in other.glob("*_cut.mcap")}
    names, others = (
        sorted(path.name for path in folder.iterdir() if path.name[:14] not in cut) for folder in (one, other)
    )
    missing = sorted(set(names) - set(others))
    assert len(missing) <= kills, missing
    assert set(others) <= set(names), others
    for name in others:
        assert messages_in(one / name) == messages_in(other / name), name


def messages_in(recording: Path) -> list[tuple[str, int, Any]]:
    return [
        (topic, time, content if isinstance(content, dict) else content.SerializeToString(deterministic=True))
        for topic, time, content, _ in open_recording(recording).messages()
    ]


def assert_same_tree(one: Any, other: Any, place: str) -> None:
    assert type(one) is type(other), place
    if isinstance(one, dict):
        assert list(one) == list(other), place
        for key in one:
            assert_same_tree(one[key], other[key], f"{place}.{key}")
    elif isinstance(one, list):
        assert len(one) == len(other), place
        for index, (first, second) in enumerate(zip(one, other, strict=True)):
            assert_same_tree(first, second, f"{place}.{index}")
    elif isinstance(one, torch.Tensor):
        assert one.dtype == other.dtype, place
        assert torch.equal(one, other), place
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape), place
        assert one.tobytes() == other.tobytes(), place
    else:
        assert one == other or one != one, place


def scalars(run: Path) -> dict[str, list[tuple[int, float]]]:
    """What TensorBoard shows: tag → steps and figures."""
    reader = EventAccumulator(str(run / "tensorboard"), size_guidance={"scalars": 0})
    reader.Reload()
    return {tag: [(event.step, event.value) for event in reader.Scalars(tag)] for tag in reader.Tags()["scalars"]}
