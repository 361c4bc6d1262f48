"""Missions as a user drives them."""

import csv
import math
import re
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from asddpg import mission
from asddpg.drivers.localized_robot import LocalizedRobot
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Episode, Observer
from asddpg.errors import UserError
from asddpg.missions.setting import MissionSetting
from asddpg.recording.files.reading import Recording, open_recording
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tests.conftest import free_port
from tests.support.foxglove_viewer import Viewer
from tools import replay_episode

NEAR = ["agent=move_base", "task=nav_simple", "start=[0,0,0]", "targets=[0.8,0,0.8,0.5]", "unmapped=[north]"]
SHORT = ["agent=move_base", "task=nav_empty", "start=[0,0,0]", "targets=[0.5,0]"]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rows_of(folder: Path | str) -> list[dict[str, str]]:
    with (Path(folder) / "missions.csv").open() as file:
        return list(csv.DictReader(file))


def recording_in(folder: Path | str) -> Recording:
    (path,) = (Path(folder) / "episodes").iterdir()
    return open_recording(path)


# Results ----------------------------------------------------------------------------------------------------------


def test_a_mission_leaves_a_line_a_row_a_picture_and_a_recording(capsys: pytest.CaptureFixture[str]) -> None:
    mission.main(NEAR)
    out = capsys.readouterr().out
    assert "move_base on nav_simple, nav_simple, seed=0; not on the map: north" in out
    assert re.search(r"mission 1: all targets reached, nothing touched; 2 of 2 targets in \d+ s and [\d.]+ m;", out)
    assert "1 of 1 missions succeeded, 1.00 [" in out
    assert "1 episode recorded in missions/episodes; in Foxglove: Open local file" in out
    (row,) = rows_of("missions")
    assert (row["outcome"], row["reached"], row["targets"], row["failure"]) == ("reached", "2", "2", "")
    assert float(row["error_max_m"]) < 0.3
    assert sorted(path.name for path in Path("missions").iterdir()) == ["episodes", "mission_01.png", "missions.csv"]
    with Image.open("missions/mission_01.png") as picture:
        assert picture.width == 1200
        north = picture.convert("RGB").getpixel((600, round(54 + (4.4 - 1.25) * 1200 / 8.8)))
    assert north == (250, 205, 60), "yellow"
    recording = recording_in("missions")
    steps = recording.steps()
    assert recording.outcome()["outcome"] == "reached"
    assert len(steps) * 0.2 == pytest.approx(float(row["seconds"]))
    assert recording.start == (0.0, 0.0, 0.0)
    assert recording.goal == (0.8, 0.0)
    assert list(recording.goals().values()) == [(0.8, 0.5)]


def test_equal_seeds_give_equal_missions_in_folders_of_their_own() -> None:
    arguments = [*SHORT, "missions=2"]
    mission.main(arguments)
    first = Path("missions/missions.csv").read_bytes()
    picture = Path("missions/mission_02.png").read_bytes()
    mission.main(arguments)
    assert Path("missions/missions.csv").read_bytes() == first == Path("missions_2/missions.csv").read_bytes()
    assert Path("missions_2/mission_02.png").read_bytes() == picture
    for name in ("00000000_00001_reached.mcap", "00000000_00002_reached.mcap"):
        digests = [
            [step["digest"] for step in open_recording(f"{folder}/episodes/{name}").steps()]
            for folder in ("missions", "missions_2")
        ]
        assert digests[0] == digests[1]


def test_a_policy_is_led_along_the_path_and_drives_alone_too(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["run=pretrained:nav_complex", "task=nav_empty", "start=[0,0,0]", "targets=[1,0]", "patience=20"]
    mission.main(["agent=waypoints", *arguments, "out=led"])
    mission.main([*arguments, "out=alone"])
    out = capsys.readouterr().out
    assert out.count("mission 1: all targets reached") == 2
    assert "led by waypoints" in out
    led, alone = (recording_in(f"{folder}/missions") for folder in ("led", "alone"))
    assert list(led.messages("/plan"))
    assert not any(message.content.poses for message in alone.messages("/plan")), "no planner, no path"
    assert list(alone.messages("/map")), "on which it knows its pose"
    assert list(alone.messages("/amcl_pose"))


class AlwaysForward:
    """Drives straight ahead."""

    def __init__(self, robot: Any) -> None:
        pass

    def act(self, _: Any) -> tuple[float, float]:
        return 0.5, 0.0


FORWARD = f"agent={__name__}:AlwaysForward"


@pytest.mark.parametrize(
    ("arguments", "outcome", "failure"),
    [
        (
            ["task=nav_simple", "start=[0.9,0,0]", "targets=[3,3]", "unmapped=[east]"],
            "crashed",
            "touched east, not on the map, on the way to target 1",
        ),
        (
            ["task=nav_simple", "start=[0.9,0,0]", "targets=[3,3]", "unmapped=[]"],
            "crashed",
            "touched east, on the way to target 1",
        ),
        (
            ["task=nav_empty", "start=[0,0,0]", "targets=[0.5,0,0.5,3]", "patience=2"],
            "timeout",
            "target 2 not reached in time",
        ),
        (  # the carton stands at (0.35, -2.1)
            ["task=nav_gazebo", "start=[0.35,-1.2,-1.5708]", "targets=[0.35,-2.5]", "unmapped=[]"],
            "reached",
            "touched small_carton, on the way to target 1",
        ),
    ],
)
def test_each_failure_has_its_reason(
    capsys: pytest.CaptureFixture[str], arguments: list[str], outcome: str, failure: str
) -> None:
    mission.main([FORWARD, *arguments, "record.every=0"])
    (row,) = rows_of("missions")
    assert (row["outcome"], row["failure"]) == (outcome, failure)
    out = capsys.readouterr().out
    assert f"mission 1: {failure}; " in out
    assert "0 of 1 missions succeeded" in out


def test_a_target_that_the_robot_only_believes_to_have_reached_is_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    make_robot = MissionSetting.make_robot

    def make_wrong(setting: MissionSetting, environment: NavigationEnv) -> LocalizedRobot:
        robot = make_robot(setting, environment)
        monkeypatch.setattr(robot.amcl, "pose", lambda: np.add(environment.task.readings.pose, (1.0, 0.0, 0.0)))
        return robot

    monkeypatch.setattr(MissionSetting, "make_robot", make_wrong)
    mission.main([FORWARD, "task=nav_empty", "start=[0,0,0]", "targets=[1.5,0]", "record.every=0"])
    (row,) = rows_of("missions")
    assert (row["outcome"], row["reached"]) == ("reached", "1")
    missed = re.fullmatch(r"target 1 missed by (\d\.\d\d) m", row["failure"])
    assert missed
    assert 1.2 <= float(missed[1]) <= 1.3  # 0.3 m before it by an estimate that is 1 m ahead
    assert float(row["error_median_m"]) == pytest.approx(1.0)


# Mistakes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        (["targets=[1,2,3]"], r"targets must be pairs of numbers, x and y of each target, such as \[1,2,-3,0.5\]"),
        (["targets=[1,2,9,0]"], r"a target must lie in the room, x from -4.1 to 4.1 m .* not at \(9, 0\)"),
        (["targets=[3,3,1.75,0]"], r"a target must lie on free floor; at \(1.75, 0\) there is an obstacle"),
        (["start=[0,0]"], "start must be three numbers"),
        (["start=[9,0,0]"], "a start must lie in the room"),
        (["start=[1.75,0,0]"], "a start must lie on free floor"),
        (["start=[1.4,0,0]"], "a start must leave the robot free"),
        (["unmapped=[sofa]"], "the room has no obstacle 'sofa'; it has east, north, south, wall_east"),
        (["unmapped=[north,north]"], "unmapped must be names of obstacles, each once"),
        (["within=0"], "within must be"),
        (["drift=0.6"], "drift must be"),
        (["agent=nobody"], "there is no baseline 'nobody'"),
        (["record.cameras=[attic]"], "attic"),
    ],
)
def test_a_mistake_is_one_sentence_and_nothing_is_written(
    here: Path, capsys: pytest.CaptureFixture[str], changed: list[str], sentence: str
) -> None:
    with pytest.raises((UserError, TaskError), match=sentence) as raised:
        mission.main([*NEAR, *changed])
    assert "\n" not in str(raised.value)
    assert capsys.readouterr().out == ""
    assert not list(here.iterdir())


def test_a_port_in_use_is_one_sentence_and_nothing_is_written(here: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(UserError, match="cannot be served at"):
            mission.main([*SHORT, "live=true", f"port={taken.getsockname()[1]}"])
    assert not list(here.iterdir())


# Ctrl-C -----------------------------------------------------------------------------------------------------------


def interrupt_mission(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C comes in the first step of a mission."""

    class Interrupting(Observer):
        def step(self, step: Any, learned: Any) -> None:
            raise KeyboardInterrupt

    counted = iter(range(1, 100))

    def interrupted(environment: Any, driver: Any, observers: Any, options: Any) -> Episode:
        more = [Interrupting()] if next(counted) == number else []
        return run_episode(environment, driver, [*observers, *more], options)

    monkeypatch.setattr(mission, "run_episode", interrupted)


def test_ctrl_c_writes_the_missions_that_were_completed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    interrupt_mission(3, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        mission.main([*SHORT, "missions=5"])
    assert [row["mission"] for row in rows_of("missions")] == ["1", "2"]
    assert "2 of 2 missions succeeded" in capsys.readouterr().out
    names = sorted(path.name for path in Path("missions/episodes").iterdir())
    assert [name.partition("_")[2] for name in names] == [
        "00001_reached.mcap", "00002_reached.mcap", "00003_cut.mcap"
    ]  # fmt: skip


def test_ctrl_c_in_the_first_mission_completes_its_recording(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    interrupt_mission(1, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        mission.main(SHORT)
    assert len(recording_in("missions").steps()) == 1
    assert not Path("missions/missions.csv").exists()
    assert "1 episode recorded in missions/episodes" in capsys.readouterr().out


def test_ctrl_c_before_anything_was_completed_leaves_no_empty_folder(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupt_mission(1, monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        mission.main([*SHORT, "record.every=0"])
    assert not list(here.iterdir())


# Recording --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "arguments",
    [
        [*NEAR, "task=nav_complex", "start=[0,0,0]", "unmapped=[l_shaft]", "targets=[0.5,0,0.5,-0.5]"],
        [FORWARD, "task=nav_empty", "start=[0,0,0]", "targets=[0.5,0,0.5,3]", "patience=2"],
        [FORWARD, "task=nav_empty", "start=[3.5,0,0]", "targets=[0.5,0]"],
    ],
    ids=["reached", "timeout", "crashed"],
)
def test_a_recording_replays_to_the_last_bit(
    arguments: list[str], request: pytest.FixtureRequest, capsys: pytest.CaptureFixture[str]
) -> None:
    mission.main(arguments)
    capsys.readouterr()
    replay_episode.main(["missions/episodes"])
    outcome = request.node.callspec.id
    steps = len(recording_in("missions").steps())
    assert f"_{outcome}.mcap: the same to the last bit over {steps} steps, " in capsys.readouterr().out


# Live -------------------------------------------------------------------------------------------------------------

CLICK = (-1.0, 2.0)


@contextmanager
def live_mission() -> Iterator[Viewer]:
    """Its target is 1.5 m off; in the end it is over."""
    port = free_port()
    arguments = ["agent=move_base", "task=nav_empty", "start=[0,0,0]", "targets=[1.5,0]", "missions=1"]
    arguments += ["live=true", f"port={port}", "speed=2"]
    thread = threading.Thread(target=mission.main, args=(arguments,))
    thread.start()
    with Viewer.when_served(port) as viewer:
        viewer.watch("/step", "/outcome")
        yield viewer
        viewer.set("/paused", False)
        viewer.set("/speed", 0)
        viewer.until(lambda: viewer.of("/outcome") and viewer.of("/outcome")[-1]["outcome"] != "running")
        thread.join(60)
    assert not thread.is_alive()


def end_of(plan: Any) -> tuple[float, float]:
    place = plan.poses[-1].position
    return place.x, place.y


def test_a_click_on_the_floor_is_the_present_target_and_is_planned_to() -> None:
    with live_mission() as live:
        live.watch("/plan", "/goal")
        live.until(lambda: live.of("/plan") and live.of("/plan")[-1].poses)
        assert end_of(live.of("/plan")[-1]) == pytest.approx((1.5, 0.0), abs=1e-3)
        live.publish("/clicked_point", {"header": {"frame_id": "world"}, "point": {"x": CLICK[0], "y": CLICK[1]}})
        goal = live.next("/goal", lambda goal: goal.pose.position.x == CLICK[0])
        assert (goal.pose.position.x, goal.pose.position.y) == CLICK
        live.next("/plan", lambda plan: math.dist(end_of(plan), CLICK) < 1e-3)
    assert live.of("/outcome")[-1]["outcome"] == "reached"
    (row,) = rows_of("missions")
    assert (row["reached"], row["failure"]) == ("1", ""), "the clicked place was reached, not the first one"
    recording = recording_in("missions")
    assert list(recording.goals().values()) == [CLICK]
    assert recording.steps()[-1]["distance"] < 0.5


def test_a_place_out_of_the_room_is_refused_in_a_sentence() -> None:
    with live_mission() as live:
        live.next("/step")
        live.publish("/clicked_point", {"point": {"x": 20, "y": 0}})
        live.status("a goal must lie in the room")
        live.next("/step")


def test_a_late_subscriber_gets_map_plan_and_estimate() -> None:
    with live_mission() as live:
        live.next("/step", lambda step: step["step"] >= 3)
        live.set("/paused", True)
        live.settle()
        live.watch("/map", "/plan", "/particles", "/amcl_pose")
        live.until(lambda: all(live.of(topic) for topic in ("/map", "/plan", "/particles", "/amcl_pose")))
        assert end_of(live.of("/plan")[-1]) == pytest.approx((1.5, 0.0), abs=1e-3)
        assert len(live.of("/map")[-1].data) > 1000


def test_the_parameter_goal_follows_the_targets() -> None:
    port = free_port()
    arguments = ["agent=move_base", "task=nav_empty", "start=[0,0,0]", "targets=[0.5,0,0.5,0.5]", "missions=1"]
    thread = threading.Thread(target=mission.main, args=([*arguments, "live=true", f"port={port}", "speed=4"],))
    thread.start()
    with Viewer.when_served(port) as viewer:
        viewer.follow_parameters("/goal")
        viewer.watch("/outcome")
        viewer.until(lambda: viewer.parameters.get("/goal") == [0.5, 0.5])
        viewer.until(lambda: viewer.of("/outcome") and viewer.of("/outcome")[-1]["outcome"] == "reached")
        thread.join(60)
