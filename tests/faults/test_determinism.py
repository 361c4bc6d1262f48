"""The same seed in a fresh process, beside a busy second run, and with environments in worker processes: 3 minutes.

Bar: every one to the last bit as the first. 30 s with ASDDPG_FAULTS=0.1.
"""

import math
import subprocess
import sys
from pathlib import Path

import gymnasium
import pytest

import tasks
from asddpg import train
from asddpg.config import TrainConfig
from asddpg.training import Training
from tests.faults.scale import scaled
from tests.support.small_runs import DRAWING, assert_same_run

pytestmark = pytest.mark.faults

STEPS = scaled(5000, least=500)
WORDS = ["task=nav_gazebo", "network=fc2x100", f"total_steps={STEPS}", "agent.learning_starts=200", *DRAWING]
WORDS += [f"validation.every={STEPS // 3}", "validation.episodes=3", "test_episodes=3", "seed=107", "record.every=10"]


def start(*arguments: str) -> subprocess.Popen[bytes]:
    program = [sys.executable, "-m", "asddpg.train", *arguments]
    return subprocess.Popen(program, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = tmp_path_factory.mktemp("first") / "run"
    assert start(*WORDS, f"run_dir={run}").wait() == 0
    return run


def told(what: str, capsys: pytest.CaptureFixture[str]) -> None:
    with capsys.disabled():
        print(f"\n{what}: {STEPS} steps equal to the last bit")


def test_in_a_fresh_process(first: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert start(*WORDS, f"run_dir={tmp_path / 'run'}").wait() == 0
    assert_same_run(first, tmp_path / "run")
    told("in a fresh process", capsys)


def test_beside_a_busy_second_run(first: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    others = [start("total_steps=10000000", f"seed={seed}", f"run_dir={tmp_path / str(seed)}") for seed in (1, 2)]
    try:
        assert start(*WORDS, f"run_dir={tmp_path / 'run'}").wait() == 0
        assert [other.poll() for other in others] == [None, None], "they were to be running still"
    finally:
        for other in others:
            other.kill()
            other.wait()
    assert_same_run(first, tmp_path / "run")
    told("beside two busy runs", capsys)


def test_with_environments_in_worker_processes(
    first: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    environments = gymnasium.make_vec(
        tasks.gymnasium_id("nav_gazebo"), num_envs=2, vectorization_mode="async", vector_kwargs={"context": "spawn"}
    )
    environments.reset(seed=0)
    before, made = Training._save_state_if_due, 0

    def save_state_if_due(self: Training) -> None:
        nonlocal made
        before(self)
        environments.step(environments.action_space.sample())
        made += 1

    monkeypatch.setattr(Training, "_save_state_if_due", save_state_if_due)
    try:
        train.main([*WORDS, f"run_dir={tmp_path / 'run'}"])
    finally:
        environments.close()
    assert made == math.ceil(STEPS / TrainConfig.robots), "once for a step of all robots"
    assert_same_run(first, tmp_path / "run")
    capsys.readouterr()
    told("with two environments in worker processes", capsys)
