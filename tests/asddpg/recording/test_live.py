"""The live view, over a real socket."""

import math
import threading
import time
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from asddpg import train
from asddpg.build import controller_for, make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver, controller_alone
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Agent, Decision, Driver, Observation, Step
from asddpg.episodes.steering import SteeredDriver
from asddpg.errors import UserError
from asddpg.recording.live.live_view import LiveView
from tests.conftest import TINY, free_port
from tests.support.foxglove_viewer import PATIENCE, Viewer, steps_of

EVERYTHING = ("/tf", "/scan", "/scene", "/path", "/goal", "/odom", "/cmd_vel", "/step", "/outcome", "/log")
TURNING = Decision(np.array([0.0, 0.3], dtype=np.float32), Driver.POLICY)
EPISODE = 30  # steps


@cache
def nav_complex() -> gymnasium.Env:
    config = train_config(["task=nav_complex"])
    return make_environment(config.task, config.reward)


class Show:
    """Episodes in a thread of their own, and the view of them."""

    def __init__(self, is_steered: bool = True, speed: float = 0.0) -> None:
        self.environment = nav_complex()
        self.environment.reset(seed=101)
        self.decided: list[float] = []  # when, on the clock
        controller = controller_alone(controller_for(self.environment, train_config([]).controller))
        drivers = {"turning": FixedDriver(self._turn), "controller": controller}
        steered = SteeredDriver(navigation_env(self.environment).set_goal, drivers, "turning")
        self.live = LiveView(navigation_env(self.environment), 0, speed, steered if is_steered else None)
        self.episodes = 0
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(steered,))
        self._thread.start()

    def _turn(self, _: Observation) -> Decision:
        self.decided.append(time.monotonic())
        return TURNING

    def _run(self, driver: Agent) -> None:
        while not self._is_over.is_set():
            run_episode(self.environment, driver, (self.live,), max_steps=EPISODE)
            self.episodes += 1

    def close(self) -> None:
        self._is_over.set()
        with Viewer(self.live.port) as viewer:  # it may wait for one
            viewer.watch("/log")
            viewer.set("/paused", False)
            viewer.set("/speed", 0)
            self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
        self.live.close()


@pytest.fixture
def show() -> Iterator[Show]:
    show = Show()
    yield show
    show.close()


@pytest.fixture
def viewer(show: Show) -> Iterator[Viewer]:
    with Viewer(show.live.port) as viewer:
        yield viewer


@pytest.fixture
def training() -> Iterator[Show]:
    """As in a training: without steering."""
    show = Show(is_steered=False)
    yield show
    show.close()


def pause_after(step: int, viewer: Viewer) -> None:
    """Pause in the middle of an episode: ten steps a second, so that it is not over before the request."""
    viewer.set("/speed", 2)
    viewer.next("/step", lambda message: message["step"] == step)
    viewer.set("/paused", True)
    viewer.settle()


# Watching ---------------------------------------------------------------------------------------------------------


def test_a_viewer_sees_everything_and_time_goes_on_over_episodes(viewer: Viewer) -> None:
    viewer.watch(*EVERYTHING)
    viewer.until(lambda: steps_of(viewer.messages).count(EPISODE - 1) >= 2)
    assert {message.topic for message in viewer.messages} == set(EVERYTHING)
    assert len({transform.child_frame_id for transform in viewer.of("/tf")[-1].transforms}) > 5
    assert len(viewer.of("/scan")[-1].ranges) == 40
    assert {entity.id for entity in viewer.of("/scene")[-1].entities} >= {"world", "base", "goal"}
    assert len(viewer.times) > EPISODE
    assert viewer.times == sorted(viewer.times)
    for topic in EVERYTHING:
        times = [message.time for message in viewer.messages if message.topic == topic]
        assert times == sorted(times)
        assert set(times) <= set(viewer.times)


def test_playing_waits_for_a_viewer(show: Show) -> None:
    time.sleep(0.1)
    assert show.episodes == 0
    with Viewer(show.live.port) as viewer:
        viewer.watch("/step")
        viewer.until(lambda: show.episodes > 0)


def test_a_late_subscriber_gets_the_full_state(show: Show, viewer: Viewer) -> None:
    viewer.watch("/step", "/odom")
    viewer.set("/driver", "controller")
    pause_after(5, viewer)
    step, odometry = viewer.of("/step")[-1], viewer.of("/odom")[-1]
    with Viewer(show.live.port) as late:
        late.watch("/scene", "/path", "/goal", "/tf", "/outcome")
        late.until(lambda: {message.topic for message in late.messages} >= {"/scene", "/path", "/goal", "/tf"})
        assert len(late.of("/scene")[-1].entities) > 5
        assert late.of("/outcome")[-1]["outcome"] == "running"
        (path,) = late.of("/path")[-1].entities
        last = path.lines[-1].points[-1]
        assert (last.x, last.y) == pytest.approx((odometry.pose.position.x, odometry.pose.position.y), abs=3e-3)
        joints = sum(len(line.points) - 1 for line in path.lines)
        assert joints == step["step"] + 1


def test_without_viewers_a_step_costs_next_to_nothing() -> None:
    environment = nav_complex()
    observation, info = environment.reset()
    live = LiveView(navigation_env(environment), 0, 0.0)
    step = Step(observation, TURNING, 0.0, observation, False, False, info)
    live.begin_episode(observation, info)
    begun = time.thread_time()
    for _ in range(2000):
        live.step(step, {})
    assert (time.thread_time() - begun) / 2000 < 20e-6
    live.close()


# Steering ---------------------------------------------------------------------------------------------------------


def test_the_viewer_chooses_the_driver(viewer: Viewer) -> None:
    viewer.watch("/step")
    assert viewer.next("/step")["driver"] == "policy"
    viewer.set("/driver", "controller")
    assert viewer.parameters["/driver"] == "controller"
    assert viewer.next("/step", lambda step: step["driver"] == "controller")
    viewer.set("/driver", "turning")
    assert viewer.next("/step", lambda step: step["driver"] == "policy")


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("/driver", "ghost", "there is no driver 'ghost'; there are turning, controller"),
        ("/driver", 3, "there is no driver 3"),
        ("/paused", "yes", "/paused must be true or false"),
        ("/paused", 1, "/paused must be true or false"),
        ("/step_once", "x", "/step_once must be true or false"),
        ("/speed", -1, "/speed must be a number, 0 or more"),
        ("/speed", "fast", "/speed must be a number, 0 or more"),
        ("/speed", True, "/speed must be a number, 0 or more"),
        ("/goal", [1.0], "/goal must be two numbers"),
        ("/goal", "here", "/goal must be two numbers"),
        ("/goal", ["a", "b"], "a goal's x and y are numbers"),
        ("/nonsense", 1, "there is no parameter '/nonsense'; there are /paused"),
    ],
)
def test_an_invalid_parameter_is_refused_in_a_sentence(viewer: Viewer, name: str, value: Any, sentence: str) -> None:
    before = {each: value for each, value in viewer.ask().items() if each != "/goal"}
    viewer.set(name, value)
    viewer.status(sentence)
    assert {each: value for each, value in viewer.ask().items() if each != "/goal"} == before


def test_the_viewer_pauses_and_goes_step_by_step(viewer: Viewer) -> None:
    viewer.watch("/step")
    viewer.set("/speed", 2)  # so that the episode is not over before the request
    viewer.next("/step", lambda message: message["step"] == 3)
    viewer.set("/step_once", True)
    assert viewer.parameters["/paused"] is True
    viewer.settle()
    for _ in range(3):
        count = len(viewer.messages)
        viewer.set("/step_once", True)
        assert viewer.parameters["/step_once"] is False
        viewer.until(lambda count=count: len(viewer.messages) > count)  # type: ignore[misc]
        viewer.settle()
        assert len(viewer.messages) == count + 1
    first, second, third = steps_of(viewer.messages[-3:])
    assert (second, third) == (first + 1, first + 2)
    viewer.set("/paused", False)
    viewer.next("/step")


def test_step_by_step_an_episode_ends_with_its_outcome_and_the_next_one_begins(viewer: Viewer) -> None:
    viewer.watch("/step", "/outcome", "/goal")
    pause_after(EPISODE - 3, viewer)
    at = steps_of(viewer.messages)[-1]
    seen: list[list[str]] = []
    for _ in range(EPISODE - 1 - at + 3):
        count = len(viewer.messages)
        viewer.set("/step_once", True)
        viewer.until(lambda count=count: len(viewer.messages) > count)  # type: ignore[misc]
        viewer.settle()
        seen.append([message.topic for message in viewer.messages[count:]])
    *steps, outcome, beginning, step = seen
    assert steps == [["/step"]] * len(steps)
    assert (outcome, beginning, step) == (["/outcome"], ["/outcome", "/goal"], ["/step"])  # none is known yet
    assert steps_of(viewer.messages)[-1] == 0


def test_the_viewer_sets_the_pace(show: Show, viewer: Viewer) -> None:
    viewer.watch("/step")
    viewer.next("/step")
    viewer.set("/speed", 4)
    first = len(show.decided) + 1
    viewer.until(lambda: len(show.decided) > first + 12)
    assert show.decided[first + 12] - show.decided[first] > 12 * 0.2 / 4 - 0.15
    assert viewer.ask()["/speed"] == 4.0


CLICK = {"header": {"stamp": {"sec": 1, "nsec": 0}, "frame_id": "world"}, "point": {"x": 3.25, "y": -2.5, "z": 0}}
POSE = {"header": {"frame_id": ""}, "pose": {"position": {"x": 3.25, "y": -2.5, "z": 0}, "orientation": {"w": 1}}}


def place_of_the_goal(transforms: Any) -> tuple[float, float]:
    (goal,) = (each.translation for each in transforms.transforms if each.child_frame_id == "goal")
    return goal.x, goal.y


@pytest.mark.parametrize(
    ("topic", "content"),
    [
        ("/clicked_point", CLICK),
        ("/move_base_simple/goal", POSE),
        ("/goal_pose", POSE),
        ("/goal_pose", {"frame_id": "world", "pose": POSE["pose"]}),
    ],
)
def test_a_click_moves_the_goal_at_once(viewer: Viewer, topic: str, content: Any) -> None:
    viewer.watch("/goal", "/step", "/odom", "/tf")
    viewer.follow_parameters("/goal")
    pause_after(2, viewer)
    before = viewer.of("/step")[-1]["step"]
    viewer.publish(topic, content)
    goal = viewer.next("/goal")
    assert (goal.pose.position.x, goal.pose.position.y) == (3.25, -2.5)
    viewer.until(lambda: viewer.parameters.get("/goal") == [3.25, -2.5])
    viewer.until(lambda: place_of_the_goal(viewer.of("/tf")[-1]) == (3.25, -2.5))
    viewer.set("/step_once", True)
    step = viewer.next("/step", lambda step: step["step"] == before + 1)
    place = viewer.of("/odom")[-1].pose.position
    assert step["distance"] == pytest.approx(math.dist((place.x, place.y), (3.25, -2.5)), abs=1e-2)
    # It turns on the spot: no progress was made, wherever the goal was before.
    assert abs(step["terms"]["progress"]) < 0.05


def test_a_click_in_a_view_that_follows_the_robot(viewer: Viewer) -> None:
    viewer.watch("/goal", "/step", "/odom")
    pause_after(3, viewer)
    pose = viewer.of("/odom")[-1].pose
    yaw = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
    viewer.publish("/clicked_point", {"header": {"frame_id": "base"}, "point": {"x": 0.4, "y": 0.1, "z": 0}})
    goal = viewer.next("/goal").pose.position
    ahead = 0.4 * math.cos(yaw) - 0.1 * math.sin(yaw), 0.4 * math.sin(yaw) + 0.1 * math.cos(yaw)
    assert (goal.x - pose.position.x, goal.y - pose.position.y) == pytest.approx(ahead, abs=5e-3)


@pytest.mark.parametrize(
    ("topic", "content", "sentence"),
    [
        ("/clicked_point", {"point": {"x": 40, "y": 0}}, "a goal must lie in the room, x from"),
        ("/clicked_point", {"point": {"x": 0, "y": 2}}, "a goal must lie on free floor"),
        ("/clicked_point", {"header": {"frame_id": "map"}, "point": {"x": 0, "y": 0}}, "the frame world or base"),
        ("/clicked_point", {"place": 1}, "a goal is a message such as"),
        ("/clicked_point", [1, 2], "a goal is a message such as"),
        ("/clicked_point", {"point": {"x": "a", "y": 0}}, "a goal's x and y are numbers"),
        ("/clicked_point", b"{", "is not JSON"),
        ("/initialpose", CLICK, "there is no subscriber to /initialpose; goals are taken from /clicked_point"),
    ],
)
def test_an_invalid_goal_is_refused_in_a_sentence(viewer: Viewer, topic: str, content: Any, sentence: str) -> None:
    viewer.watch("/step")
    viewer.next("/step")
    viewer.publish(topic, content)
    viewer.status(sentence)
    viewer.next("/step")


def test_the_goal_is_a_parameter_too(viewer: Viewer) -> None:
    viewer.watch("/goal")
    viewer.next("/goal")
    viewer.set("/paused", True)
    viewer.set("/goal", [3, -2.5])
    goal = viewer.next("/goal", lambda goal: goal.pose.position.x == 3)
    assert goal.pose.position.y == -2.5


# Training ---------------------------------------------------------------------------------------------------------


def test_a_training_waits_for_no_viewer(training: Show) -> None:
    deadline = time.monotonic() + 60
    while training.episodes < 2:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    with Viewer(training.live.port) as viewer:
        viewer.watch("/step")
        viewer.next("/step")
        viewer.set("/paused", True)
        viewer.settle()
        paused_at = training.episodes
        viewer.settle()
        assert training.episodes == paused_at
    while training.episodes < paused_at + 2:  # without viewers it goes on
        assert time.monotonic() < deadline + 60
        time.sleep(0.01)


def test_a_training_is_not_steered(training: Show) -> None:
    with Viewer(training.live.port) as viewer:
        viewer.watch("/step")
        assert set(viewer.ask()) == {"/paused", "/step_once", "/speed"}
        viewer.set("/driver", "controller")
        viewer.status("/driver belongs to python -m asddpg.play")
        viewer.publish("/clicked_point", CLICK)
        viewer.status("a goal belongs to python -m asddpg.play")
        assert viewer.next("/step")["driver"] == "policy"


def test_a_live_view_changes_no_training(tmp_path: Path, tiny_run: Path) -> None:
    port, seen = free_port(), []

    def watch() -> None:
        with Viewer.when_served(port) as viewer:
            viewer.watch(*EVERYTHING)
            for _ in range(20):
                seen.append(viewer.next("/step"))

    thread = threading.Thread(target=watch)
    thread.start()
    train.main(["task=nav_complex", *TINY, f"run_dir={tmp_path / 'run'}", "live=true", f"port={port}", "speed=20"])
    thread.join()
    assert seen
    for name in ("metrics.csv", "validation.csv"):
        assert (tmp_path / "run" / name).read_bytes() == (tiny_run / name).read_bytes()


def test_a_port_in_use_is_one_sentence_and_no_run_folder_is_made(tmp_path: Path, training: Show) -> None:
    with pytest.raises(UserError, match=r"port \d+ cannot be served at: Address already in use; choose another port="):
        train.main([f"run_dir={tmp_path / 'run'}", "live=true", f"port={training.live.port}"])
    assert not list(tmp_path.iterdir())
