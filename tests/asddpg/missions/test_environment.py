"""Missions as an environment: what counts as reached, what the robot is given, and how a mission ends."""

import math
from typing import Any

import numpy as np
import pytest

from asddpg.episodes.protocols import Observation
from asddpg.missions.environment import Mission
from asddpg.missions.setting import draw_mission
from tasks.errors import TaskError
from tests.support.missions import Belief, Pose, Stage, make_stage

START: Pose = (0.0, 0.0, 0.0)
STOP, FORWARD = np.zeros(2), np.array([0.5, 0.0])


@pytest.fixture(scope="module")
def stage_of_the_module() -> Stage:
    return make_stage("patience=1")  # 5 steps for each target


@pytest.fixture
def stage(stage_of_the_module: Stage, monkeypatch: pytest.MonkeyPatch) -> Stage:
    """With an estimate that a test may replace."""
    robot = stage_of_the_module.robot
    monkeypatch.setattr(robot.amcl, "pose", robot.amcl.pose)
    return stage_of_the_module


def begin(stage: Stage, *targets: tuple[float, float], start: Pose = START) -> tuple[Observation, dict[str, Any]]:
    return stage.missions.reset(options={"mission": Mission(start, targets, seed=1)})


def test_a_far_target_is_observed_at_the_tasks_goal_range(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    target = (2.4, -1.8)
    Belief(stage, START)
    whole, _ = begin(stage, target)
    monkeypatch.setattr(stage.environment.task.config, "goal_range", 1.0)
    near, _ = begin(stage, target)
    assert whole[-2:] == pytest.approx(target, abs=0.01)
    assert near[-2:] == pytest.approx((0.8, -0.6), abs=0.01)
    np.testing.assert_array_equal(near[:-2], whole[:-2])


# Targets ----------------------------------------------------------------------------------------------------------


def test_targets_are_reached_in_turn_and_the_last_ends_the_mission() -> None:
    stage = make_stage("start=[0,0,0]", "targets=[0.8,0,0.8,0.7]")
    log = stage.drive(1)
    assert log.outcome == "reached"
    assert len(log.arrivals) == 2
    places = np.array(log.poses)[:, :2]
    near = [np.flatnonzero(np.hypot(*(places - target).T) < 0.35) for target in log.mission.targets]
    assert 0 < near[0][0] < near[1][0]
    assert near[1][-1] == len(places) - 1


def test_each_arrival_hands_out_the_next_target(stage: Stage) -> None:
    belief = Belief(stage, START)
    begin(stage, (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0))
    found = []
    for place in ((0.5, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)):
        belief.pose = (*place, 0.0)
        _, _, terminated, truncated, info = stage.missions.step(STOP)
        found.append((info["target"], stage.environment.task.readings.goal, info["outcome"], terminated, truncated))
    assert found == [
        (0, (1.0, 0.0), "running", False, False),
        (1, (0.0, 1.0), "running", False, False),
        (1, (0.0, 1.0), "running", False, False),
        (2, (-1.0, 0.0), "running", False, False),
        (3, (-1.0, 0.0), "reached", True, False),
    ]
    assert info["is_success"]


@pytest.mark.parametrize(("believed", "target"), [((0.0, 1.0), (0.0, 1.2)), ((2.0, 0.0), (1.75, 0.0))])
def test_a_target_is_reached_where_the_robot_believes_to_be_there(
    stage: Stage, believed: tuple[float, float], target: tuple[float, float]
) -> None:
    Belief(stage, (*believed, 0.0))
    begin(stage, target)
    _, _, terminated, _, info = stage.missions.step(STOP)
    assert (terminated, info["outcome"]) == (True, "reached")
    assert info["distance"] > 1.0, "in truth it is far away"
    assert info["estimate"] == (*believed, 0.0)


def test_a_target_that_the_robot_stands_on_without_knowing_is_not_reached(stage: Stage) -> None:
    Belief(stage, (0.0, 1.0, 0.0))
    begin(stage, (0.05, 0.0))
    _, _, terminated, _, info = stage.missions.step(STOP)
    assert (terminated, info["outcome"], info["target"], info["is_success"]) == (False, "running", 0, False)
    assert info["distance"] < 0.1


@pytest.mark.parametrize(("off", "is_reached"), [(0.29, True), (0.31, False)])
def test_within_is_the_distance_that_counts(stage: Stage, off: float, is_reached: bool) -> None:
    Belief(stage, START)
    begin(stage, (0.0, off))
    assert stage.missions.step(STOP)[2] is is_reached


# Observation ------------------------------------------------------------------------------------------------------


def test_the_goal_is_seen_from_the_estimate_and_never_from_the_true_pose(stage: Stage) -> None:
    belief = Belief(stage, (0.5, 0.0, math.pi / 2))
    observation, info = begin(stage, (0.5, 1.0), (2.0, 2.0))
    assert observation[-2:] == pytest.approx((1.0, 0.0), abs=1e-6)  # ahead; in truth 0.5 ahead and 1 to the left
    assert info["pose"] == START
    belief.pose = (-0.5, 0.0, 0.0)
    observation, *_ = stage.missions.step(STOP)
    assert observation[-2:] == pytest.approx((1.0, 1.0), abs=1e-6)
    belief.pose = (0.5, 1.0, 0.0)  # reached: the observation has the next target already
    observation, *_ = stage.missions.step(STOP)
    assert observation[-2:] == pytest.approx((1.5, 1.0), abs=1e-6)
    assert stage.missions.set_goal(0.5, -1.0)[-2:] == pytest.approx((0.0, -2.0), abs=1e-6)


def test_scan_and_speed_are_those_of_the_environment(stage: Stage) -> None:
    Belief(stage, (0.5, 0.0, 1.0))
    observation, _ = begin(stage, (0.5, 2.0))
    below = stage.environment.set_goal(0.5, 2.0)
    assert np.array_equal(observation[:-2], below[:-2])
    assert below[-2:] == pytest.approx((0.5, 2.0), abs=1e-6)


# Ends -------------------------------------------------------------------------------------------------------------


def test_each_target_has_its_own_time(stage: Stage) -> None:
    belief = Belief(stage, START)
    begin(stage, (2.0, 0.0), (0.0, 2.0))
    ends = []
    for step in range(1, 10):
        belief.pose = (2.0, 0.0, 0.0) if step == 4 else START
        _, _, terminated, truncated, info = stage.missions.step(STOP)
        ends.append((terminated, truncated, info["outcome"]))
    assert ends[:-1] == [(False, False, "running")] * 8, "4 steps to the first target, 5 to the next"
    assert ends[-1] == (False, True, "timeout")


def test_a_target_reached_in_the_last_step_is_reached(stage: Stage) -> None:
    belief = Belief(stage, START)
    begin(stage, (2.0, 0.0))
    for _ in range(4):
        stage.missions.step(STOP)
    belief.pose = (2.0, 0.0, 0.0)
    _, _, terminated, truncated, info = stage.missions.step(STOP)
    assert (terminated, truncated, info["outcome"]) == (True, False, "reached")


def test_a_moved_target_has_its_time_anew(stage: Stage) -> None:
    Belief(stage, START)
    begin(stage, (2.0, 0.0))
    for _ in range(4):
        stage.missions.step(STOP)
    stage.missions.set_goal(0.0, 2.0)
    assert [stage.missions.step(STOP)[3] for _ in range(5)] == [False] * 4 + [True]


def test_a_crash_ends_the_mission_whatever_the_robot_believes(stage: Stage) -> None:
    """The robot's front is some 0.2 m ahead of its axis, and the wall begins at x = 4 m."""
    belief, steps = Belief(stage, START), 0
    for believed in (START, (1.0, 0.0, 0.0)):  # the second time it believes to reach its target in the crash's step
        belief.pose = START
        begin(stage, (1.0, 0.0), start=(3.5, 0.0, 0.0))
        for step in range(1, 6):
            belief.pose = believed if step == steps else START
            _, _, terminated, truncated, info = stage.missions.step(FORWARD)
            if terminated:
                steps = step
                break
        assert (terminated, truncated, info["outcome"]) == (True, False, "crashed")
        assert (info["touched"], info["target"], info["is_success"]) == (("wall_east",), 0, False)


def test_after_its_end_no_target_can_be_moved_and_an_invalid_place_changes_nothing(stage: Stage) -> None:
    belief = Belief(stage, START)
    begin(stage, (2.0, 0.0))
    with pytest.raises(TaskError, match="a goal must lie in the room"):
        stage.missions.set_goal(20.0, 0.0)
    assert stage.environment.task.readings.goal == (2.0, 0.0)
    belief.pose = (2.0, 0.0, 0.0)
    stage.missions.step(STOP)
    with pytest.raises(TaskError, match="no mission is in progress"):
        stage.missions.set_goal(0.0, 2.0)


def test_a_pushed_thing_is_named_and_the_mission_goes_on() -> None:
    stage = make_stage("task=nav_gazebo")
    begin(stage, (2.0, 2.0), start=(0.35, -1.2, -math.pi / 2))  # the small carton stands at (0.35, -2.1)
    touched = []
    for _ in range(12):
        _, _, terminated, _, info = stage.missions.step(FORWARD)
        assert not terminated
        touched.append(info["touched"])
    assert touched[0] == ()
    assert ("small_carton",) in touched


# Seeds ------------------------------------------------------------------------------------------------------------

SHORT = ("task=nav_simple", "targets=[0.3,2.5]", "patience=3")


def test_a_mission_depends_on_its_number_and_not_on_those_before() -> None:
    both, only = make_stage(*SHORT), make_stage(*SHORT)
    first = both.drive(1)
    second, again = both.drive(2), only.drive(2)
    assert second.poses == again.poses
    assert second.estimates == again.estimates
    assert second.estimates != first.estimates


def test_a_seed_decides_on_noise_and_particles() -> None:
    arguments = (*SHORT, "start=[0,0,0]", "unmapped=[]")
    logs = [make_stage(*arguments, f"seed={seed}").drive(1) for seed in (3, 3, 4)]
    assert logs[0].estimates == logs[1].estimates
    assert logs[0].poses == logs[1].poses
    assert logs[0].estimates != logs[2].estimates


def test_missions_of_a_seed_are_told_apart_by_their_number() -> None:
    stage = make_stage("start=[0,0,0]", "targets=[1,0]")
    seeds = {draw_mission(stage.config, stage.environment, number).seed for number in range(1, 6)}
    assert len(seeds) == 5
