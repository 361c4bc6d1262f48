"""Robots of one's own, by the documented commands in an empty folder."""

import json
import re
from pathlib import Path

import pytest
import yaml

from asddpg import evaluate, play, train
from asddpg.command_line import resumed_config, train_config
from asddpg.errors import UserError
from tests.support.robots import write_robot
from tests.support.room_files import QUICK_TRAINING

BURGER = "turtlebot3_burger"


@pytest.mark.parametrize("name", [BURGER, "robot.xml"])
def test_a_robot_is_trained_evaluated_and_played(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    path = write_robot(tmp_path)
    train.main(["task=nav_simple", f"robot={name}", *QUICK_TRAINING, "run_dir=run"])
    stored = yaml.safe_load((tmp_path / "run" / "config.yaml").read_text())["task"]
    assert (stored["robot"], stored["max_linear_velocity"]) == ((BURGER, 0.22) if name == BURGER else (path, 0.5))
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")  # a run keeps its robot
    evaluate.main(["run=../run", "episodes=2"])
    assert json.loads((tmp_path / "run" / "evaluation.json").read_text())["set"] == "2 stored test pairs"
    play.main(["run=../run", "episodes=1", "seed=1"])
    printed = capsys.readouterr().out
    assert "episode 1: " in printed
    assert "the scene's model is not the one" not in printed


def test_a_policy_drives_a_slower_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main(["run=pretrained:nav_simple", f"robot={BURGER}", "episodes=2"])
    assert re.search(r"success rate +1\.000", capsys.readouterr().out)


def test_the_short_form_and_the_full_name_are_one_option() -> None:
    short, full = (train_config([f"{name}={BURGER}"]) for name in ("robot", "task.robot"))
    assert short == full
    assert short.task.max_angular_velocity == 2.84
    given = train_config([f"robot={BURGER}", "task.max_angular_velocity=1"])
    assert (given.task.max_linear_velocity, given.task.max_angular_velocity) == (0.22, 1.0)


def test_a_resumed_run_keeps_its_robot() -> None:
    with pytest.raises(UserError, match="robot= would change the past of the run"):
        resumed_config([f"robot={BURGER}"], train_config([]))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["robot=nosuch"], "there is no robot 'nosuch'; there are pioneer, turtlebot3_burger, or an MJCF file"),
        (["robot=nosuch.xml"], "there is no robot file nosuch.xml"),
        ([f"robot={BURGER}", "task.max_linear_velocity=0.3"], "up to the robot's 0.22 m/s, not 0.3"),
    ],
)
def test_mistakes_are_one_sentence(arguments: list[str], sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        train_config(arguments)
