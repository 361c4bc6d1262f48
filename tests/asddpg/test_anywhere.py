"""task=nav_anywhere by the documented commands."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from asddpg import evaluate, mission, play, train
from asddpg.errors import UserError
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.rooms.changing_room import FIRST_NUMBER, GENERATED
from tests.support.room_files import QUICK_TRAINING
from tools import compare, episode_map


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run, not to be written to."""
    folder = tmp_path_factory.mktemp("anywhere") / "run"
    train.main(["task=nav_anywhere", *QUICK_TRAINING, f"run_dir={folder}"])
    return folder


def test_a_run_is_evaluated_and_played_in_rooms_never_trained_on_and_in_the_tasks_own(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for arguments in ([], ["task=nav_simple"], ["seed=3"]):
        evaluate.main([f"run={run}", "episodes=3", f"out={tmp_path}", *arguments])
        assert json.loads((tmp_path / "evaluation.json").read_text())["episodes"] == 3
    play.main(["agent=move_base", "task=nav_anywhere", "episodes=1", "seed=1", f"out={tmp_path}"])
    assert re.search(r"episode 1 in \w+(:\d+)?: reached", capsys.readouterr().out)


def test_figures_are_of_all_rooms_and_of_each_generator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    compare.main(["drivers=[controller]", "tasks=[nav_anywhere]", "episodes=14", "processes=1", "folder=driven"])
    rows = (tmp_path / "driven/table.csv").read_text().splitlines()[1:]
    assert [row.split(",")[1].strip('"') for row in rows] == ["nav_anywhere"] * (1 + len(GENERATED))
    counts = [int(row.rpartition('"')[2].split(",")[1]) if '"' in row else int(row.split(",")[2]) for row in rows]
    assert counts == [14] + [2] * len(GENERATED)


def test_rooms_of_trainings_are_none_of_the_tests() -> None:
    environment = NavigationEnv("nav_anywhere")
    names = [environment.reset(seed=seed)[1]["room"] for seed in range(40)]
    numbers = [int(name.partition(":")[2]) for name in names if ":" in name]
    assert len(set(numbers)) == len(numbers) > 20
    assert min(numbers) >= FIRST_NUMBER


def test_goals_far_away_are_observed_at_the_range_and_in_their_direction() -> None:
    environment = NavigationEnv("nav_anywhere", config={"goal_range": 3.0})
    for seed in range(10):
        observation, info = environment.reset(seed=seed)
        x, y = environment.task.readings.goal_in_robot_frame
        assert np.hypot(*observation[-2:]) == pytest.approx(min(info["distance"], 3.0), rel=1e-6)
        assert np.arctan2(observation[-1], observation[-2]) == pytest.approx(np.arctan2(y, x), abs=1e-5)


def test_a_wrong_room_leaves_the_episode_in_progress_where_it_is() -> None:
    environment = NavigationEnv("nav_anywhere")
    _, info = environment.reset(seed=2)
    for room, start in (("nowhere", (0.0, 0.0, 0.0)), ("clutter:3", (50.0, 0.0, 0.0))):
        with pytest.raises(TaskError):
            environment.reset(options={"room": room, "start": start, "goal": (1.0, 0.0)})
        assert environment.step(np.zeros(2))[4]["room"] == info["room"] == environment.task.room


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["task.rooms=[cluter]"], "rooms of nav_anywhere are cylinders, .*, not 'cluter'"),
        (["task.rooms=[]"], "rooms of nav_anywhere are cylinders, "),
        (["task.variation.mass=2"], "variation.mass must be from 0 to 0.9"),
    ],
)
def test_wrong_mixtures_are_named(arguments: list[str], sentence: str, tmp_path: Path) -> None:
    with pytest.raises((UserError, TaskError), match=sentence):
        train.main(["task=nav_anywhere", *QUICK_TRAINING, f"run_dir={tmp_path / 'run'}", *arguments])
    assert not (tmp_path / "run").exists()


def test_a_map_shows_one_room(tmp_path: Path) -> None:
    play.main(["agent=controller", "task=nav_anywhere", "episodes=2", "seed=1", f"out={tmp_path}"])
    with pytest.raises(UserError, match="a map is of one room, and the recordings are of .+ and "):
        episode_map.main([str(tmp_path / "played_episodes"), f"file={tmp_path / 'map.png'}"])
    one = sorted((tmp_path / "played_episodes").iterdir())[0]
    episode_map.main([str(one), f"file={tmp_path / 'map.png'}"])
    assert (tmp_path / "map.png").exists()


def test_a_mission_needs_one_room(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="a mission needs one room, not nav_anywhere"):
        mission.main(["agent=move_base", "task=nav_anywhere", f"out={tmp_path}"])
