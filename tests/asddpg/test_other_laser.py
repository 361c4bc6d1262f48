"""Programs with other lasers than the default's: trained, evaluated, planned, played."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asddpg import evaluate, mission, play, train
from asddpg.drivers.simulated_robot import SimulatedRobot
from asddpg.errors import UserError
from asddpg.recording.files.reading import open_recording
from asddpg.recording.messages.topics import SCAN
from asddpg.runs.run_folder import RunFolder, read_training
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tests.conftest import TINY
from tools import replay_episode
from tools.recordings.overlay import read_scans

WIDE = {"field_of_view": 270.0, "num_beams": 1081, "max_range": 10.0}
ROUND = {"field_of_view": 360.0, "num_beams": 360, "min_range": 0.12, "max_range": 3.5}
SHIPPED = "run=pretrained:nav_complex"


def arguments(laser: dict[str, float], prefix: str = "laser") -> list[str]:
    return [f"{prefix}.{name}={value}" for name, value in laser.items()]


@pytest.mark.parametrize("laser", [WIDE, ROUND], ids=str)
def test_a_run_is_trained_evaluated_played_and_repeated_with_its_laser(
    laser: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    train.main(["task=nav_simple", *TINY, "total_steps=120", "run_dir=run", *arguments(laser, "task.laser")])
    assert vars(read_training(RunFolder(Path("run")).config)[0].task.laser).items() >= laser.items()
    evaluate.main(["run=run", "episodes=1", "seed=1"])
    assert "laser" not in json.loads(Path("run/evaluation.json").read_text())
    play.main(["run=run", "episodes=1", "seed=1"])
    (path,) = Path("run/played_episodes").glob("*.mcap")
    recording = open_recording(path)
    scans = [message.content for message in recording.messages(SCAN)]
    half = math.radians(laser["field_of_view"]) / 2
    last = half if laser is WIDE else half - math.radians(1.0)
    assert (scans[0].start_angle, scans[0].end_angle) == pytest.approx((-half, last))
    ranges = np.array([scan.ranges for scan in scans])
    assert ranges.shape[1] == laser["num_beams"]
    assert 3.0 < ranges[np.isfinite(ranges)].max() <= laser["max_range"]
    assert len(read_scans(recording)[0]) == np.isfinite(ranges[0]).sum()
    replay_episode.main([str(path)])


def test_a_policy_drives_by_another_laser_and_the_result_names_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main([SHIPPED, "episodes=5", *arguments(WIDE)])
    assert "another laser" in capsys.readouterr().out
    result = json.loads(Path("evaluation.json").read_text())
    assert result["success_rate"]["value"] == 1.0
    assert result["laser"].items() >= WIDE.items()


def test_a_policys_recording_by_another_laser_runs_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    play.main([SHIPPED, "driver=switch", "episodes=1", "seed=1", *arguments(ROUND)])
    (path,) = Path("played_episodes").glob("*.mcap")
    assert len(next(iter(open_recording(path).messages(SCAN))).content.ranges) == 360
    replay_episode.main([str(path)])


def test_a_policy_of_several_rays_a_beam_drives_by_another_laser_whose_beams_are_rays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    train.main(["task=nav_simple", *TINY, "total_steps=120", "run_dir=run", "task.laser.rays_per_beam=3"])
    for laser, beams in ((["laser.max_range=10"], 120), (arguments(WIDE), 1081), (["laser.num_beams=40"], 40)):
        evaluate.main(["run=run", "episodes=1", "seed=1", *laser])
        found = json.loads(Path("run/evaluation.json").read_text())["laser"]
        assert (found["num_beams"], found["rays_per_beam"]) == (beams, 1)


@pytest.mark.parametrize(
    ("laser", "sentence"),
    [
        ({"field_of_view": 180.0, "num_beams": 360}, "lacks 8 of the policy's 40 beams"),
        ({"num_beams": 3}, "needs beams over 240°, within 6.2° of its own"),
        ({"min_range": 6.0}, "min_range must be below max_range"),
        ({"height": 0.1}, "must lie above the robot"),
    ],
    ids=str,
)
def test_a_laser_that_a_policy_cannot_drive_by_is_refused(
    laser: dict[str, float], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((UserError, TaskError), match=sentence):
        evaluate.main([SHIPPED, *arguments(laser)])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("laser", [WIDE, ROUND], ids=str)
def test_a_planner_builds_its_map_by_the_robots_laser(
    laser: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main(["agent=move_base", "task=nav_simple", "planner.map=built", "episodes=2", *arguments(laser)])
    assert json.loads(Path("evaluation.json").read_text())["success_rate"]["value"] == 1.0


@pytest.mark.parametrize("laser", [WIDE, ROUND], ids=str)
def test_a_robot_localises_itself_by_its_laser(
    laser: dict[str, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    setting = ["task=nav_simple", "start=[0,0,0]", "targets=[0,2.5]", "unmapped=[]", "record.every=0"]
    mission.main(["agent=move_base", *setting, *arguments(laser)])
    found = re.search(r"all targets reached.*estimate \S+ m off, (\S+) at most", capsys.readouterr().out)
    assert found
    assert float(found[1]) < 0.15


@pytest.mark.parametrize("laser", [WIDE, ROUND], ids=str)
def test_a_robots_readings_are_those_of_its_laser(laser: dict[str, Any]) -> None:
    environment = NavigationEnv("nav_complex", config={"laser": laser})
    robot = SimulatedRobot(environment, None)
    observation, _ = environment.reset(seed=2)
    ranges, shape = environment.physics.ranges(), robot.shape
    assert (shape.max_range, len(shape.beams)) == (laser["max_range"], laser["num_beams"])
    np.testing.assert_array_equal(shape.beams, environment.task.config.laser.angles())
    expected = np.where(ranges < shape.max_range, ranges, np.inf)
    np.testing.assert_allclose(robot.read(observation).ranges, expected, atol=1e-5)
