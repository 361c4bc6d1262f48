"""Drivers by agent=: planners, and a user's own."""

from pathlib import Path

import numpy as np
import pytest

from asddpg import evaluate, play
from asddpg.command_line import driver_config
from asddpg.config import EvaluateConfig
from asddpg.drivers.driver_setup import set_up_driver
from asddpg.errors import UserError
from asddpg.runs.run_folder import RunFolder

OWN = """
import numpy as np

class Straight:
    def __init__(self, robot):
        self.robot = robot
        self.episodes = 0

    def begin_episode(self):
        self.episodes += 1

    def act(self, observation):
        reading = self.robot.read(observation)
        assert self.robot.map is not None and len(reading.ranges) == 40
        x, y, yaw = reading.pose
        bearing = np.arctan2(reading.goal[1] - y, reading.goal[0] - x) - yaw
        return 9.0, bearing

class Silent:
    def __init__(self, robot):
        pass

class Wordy:
    def __init__(self, robot):
        pass

    def act(self, observation):
        return 0.1, 0.2, 0.3
"""


def own_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str = OWN, name: str = "own_drivers") -> None:
    (tmp_path / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    "options", [["agent=move_base"], ["agent=move_base", "planner.map=built"], ["agent=waypoints"]]
)
def test_planners_reach_goals_and_write_what_they_are(
    options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main([*options, "task=nav_empty", "episodes=2"])
    assert "success rate          1.000" in capsys.readouterr().out
    text = RunFolder(tmp_path).evaluation.read_text()
    assert f'"map": "{"built" if len(options) == 2 else "known"}"' in text
    assert ('"gains"' in text) == (options[0] == "agent=waypoints")


def test_waypoints_lead_a_trained_policy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = ["run=pretrained:nav_complex", "agent=waypoints", "task=nav_simple", "episodes=1", f"out={tmp_path}"]
    evaluate.main([*run, "record.every=1"])
    assert "led by waypoints" in capsys.readouterr().out
    assert len(list((tmp_path / "evaluated_episodes").glob("*.mcap"))) == 1


def test_a_planner_plans_to_a_goal_that_is_moved() -> None:
    setup = set_up_driver(driver_config(EvaluateConfig, ["agent=move_base", "task=nav_empty"]), "evaluate", 0)
    driver, environment = setup.drivers["move_base"], setup.environment
    observation, _ = environment.reset(options={"goal": (3.0, 0.0)})
    driver.begin_episode()
    assert abs(float(driver.decide(observation).action[1])) < 0.2
    moved = environment.get_wrapper_attr("set_goal")(0.0, 3.0)
    assert driver.decide(moved).action[1] > 0.3


def test_planners_may_stop_where_a_preset_has_a_least_speed() -> None:
    for agent, least in (("move_base", 0.0), ("controller", 0.05)):
        setup = set_up_driver(driver_config(EvaluateConfig, [f"agent={agent}", "task=nav_complex"]), "evaluate", 0)
        assert setup.config.task.min_linear_velocity == least


def test_a_driver_of_ones_own_knows_more_than_the_observation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_module(tmp_path, monkeypatch)
    evaluate.main(["agent=own_drivers:Straight", "task=nav_empty", "episodes=3"])
    text = RunFolder(tmp_path).evaluation.read_text()
    assert '"what": "own_drivers:Straight on nav_empty"' in text
    setup = set_up_driver(
        driver_config(EvaluateConfig, ["agent=own_drivers:Straight", "task=nav_empty"]), "evaluate", 0
    )
    driver = setup.drivers["own_drivers:Straight"]
    observation, _ = setup.environment.reset(seed=0)
    driver.begin_episode()
    action = driver.decide(observation).action
    assert action[0] == np.float32(0.5), "cut at the bound"
    assert action.dtype == np.float32


@pytest.mark.parametrize(
    ("agent", "sentence"),
    [
        ("own_drivers:Silent", "has no method act"),
        ("own_drivers:Wordy", "two finite numbers"),
        ("own_drivers:Missing", "must name a class or a function"),
        ("nowhere:Factory", "must name a class or a function"),
        ("pilot", "there is no baseline 'pilot'; there are controller, random, move_base, waypoints"),
    ],
)
def test_a_driver_that_is_none_is_one_sentence(
    agent: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own_module(tmp_path, monkeypatch)
    with pytest.raises(UserError, match=sentence):
        play.main([f"agent={agent}", "task=nav_empty", "episodes=1", "seed=0"])


def test_a_module_that_cannot_be_imported_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own_module(tmp_path, monkeypatch, "import a_library_that_is_missing\n", "needs_a_library")
    with pytest.raises(UserError, match="cannot be imported: No module named 'a_library_that_is_missing'"):
        evaluate.main(["agent=needs_a_library:Factory", "task=nav_empty", "episodes=1"])
