"""safety_margin: a training's robots keep it, and nobody else's."""

from pathlib import Path

import numpy as np
import pytest

from asddpg import evaluate, train
from asddpg.build import make_robots, make_training_robots
from asddpg.command_line import train_config
from asddpg.recording.files.reading import open_recording
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.physics import Pose
from tests.support.room_files import QUICK_TRAINING
from tools.replay_episode import replay

MARGIN = 0.1
FORWARD = np.array([0.5, 0.0])


def drive_at_the_east_wall(margin: float) -> tuple[float, list[int]]:
    """The distance driven until the collision, metres, and the digests of the states."""
    environment = NavigationEnv("nav_empty")
    environment.set_safety_margin(margin)
    environment.reset(options={"start": Pose(2.0, 0.0, 0.0), "goal": (-3.0, 0.0)})
    digests, crashed = [], False
    while not crashed:
        *_, info = environment.step(FORWARD)
        crashed = info.get("outcome") == "crashed"
        digests.append(environment.physics.state_digest())
    return environment.physics.pose().x - 2.0, digests


def test_the_margin_is_a_collision_and_changes_no_motion() -> None:
    far, digests = drive_at_the_east_wall(0.0)
    near, with_margin = drive_at_the_east_wall(MARGIN)
    assert 0.0 < far - near <= 2 * MARGIN  # a step at full speed is 0.1 m
    assert len(with_margin) < len(digests)
    assert with_margin == digests[: len(with_margin)]


def test_drawn_starts_keep_the_margin() -> None:
    environment = NavigationEnv("nav_office")
    near = [environment.physics.is_free(environment.task.start) for _ in range(40) if environment.reset()]
    assert all(near)
    environment.set_safety_margin(MARGIN)
    starts = [environment.task.start for seed in range(40) if environment.reset(seed=seed)]
    assert all(environment.physics.is_free(start) for start in starts)
    environment.set_safety_margin(0.0)
    free = [environment.task.start for seed in range(40) if environment.reset(seed=seed)]
    assert starts != free  # some of them stood nearer


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run with a margin, each of its episodes recorded."""
    folder = tmp_path_factory.mktemp("margin") / "run"
    options = ["safety_margin=0.1", "record.every=1", f"run_dir={folder}"]
    train.main(["task=nav_complex", *QUICK_TRAINING, *options])
    return folder


def test_recordings_of_the_training_replay_to_the_same_end(run: Path) -> None:
    recordings = [open_recording(path) for path in sorted((run / "episodes").glob("*.mcap"))]
    results = [replay(recording) for recording in recordings]
    assert not [result.difference for result in results if result.difference]
    assert "crashed" in [result.outcome for result in results]


def test_a_policy_is_tested_without_the_margin(run: Path, tmp_path: Path) -> None:
    evaluate.main([f"run={run}", "episodes=2", "record.every=1", f"out={tmp_path}"])
    for path in tmp_path.rglob("*.mcap"):
        assert "safety_margin: 0.0" in open_recording(path).config
        assert not replay(open_recording(path)).difference


def test_only_the_robots_that_learn_keep_the_margin() -> None:
    config = train_config(["task=nav_empty", "safety_margin=0.05", "robots=2"])
    gaps = [env.physics.model.geom_gap.max() for env in make_training_robots(config).envs]
    assert gaps == [0.05, 0.05]
    assert make_robots(config.task, config.reward, 1).envs[0].physics.model.geom_gap.max() == 0.0
