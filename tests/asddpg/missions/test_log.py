"""Why missions fail, and how well the robot knew its place."""

import math
from typing import Any

import pytest

from tests.support.missions import Pose, log_of

WITHIN = 0.3
TARGETS = ((1.0, 0.0), (2.0, 0.0))


def along(*xs: float, error: float = 0.0) -> list[tuple[Pose, Pose]]:
    """True poses on the x axis, and estimates to their left."""
    return [((x, 0.0, 0.0), (x, error, 0.0)) for x in xs]


def steps(*reached: int) -> list[dict[str, Any]]:
    return [{"target": number} for number in reached]


def test_a_mission_that_reaches_all_targets_does_not_fail() -> None:
    log = log_of(along(0.0, 0.8, 1.8), TARGETS, steps(1, 2))
    assert log.failure(WITHIN, ()) == ""
    assert log.outcome == "reached"
    assert log.arrivals == pytest.approx([0.2, 0.2])


def test_a_target_that_is_not_reached_in_time_is_numbered() -> None:
    assert log_of(along(0.0, 0.8, 1.2), TARGETS, steps(1, 1)).failure(WITHIN, ()) == "target 2 not reached in time"
    assert log_of(along(0.0, 0.1), TARGETS).failure(WITHIN, ()) == "target 1 not reached in time"


@pytest.mark.parametrize(("off", "failure"), [(0.49, ""), (0.6, "target 2 missed by 0.60 m")])
def test_a_target_believed_but_missed_is_a_failure(off: float, failure: str) -> None:
    """The tolerance is 0.2 m beyond what counts as reached."""
    log = log_of(along(0.0, 0.8, 2.0 - off), TARGETS, steps(1, 2))
    assert log.outcome == "reached"
    assert log.failure(WITHIN, ()) == failure


@pytest.mark.parametrize(
    ("name", "unmapped", "failure"),
    [
        ("wall_east", ("sofa",), "touched wall_east, on the way to target 1"),
        ("sofa", ("sofa",), "touched sofa, not on the map, on the way to target 1"),
        ("desk_1_leg_0", ("desk_1",), "touched desk_1_leg_0, not on the map, on the way to target 1"),
        ("desk_10", ("desk_1",), "touched desk_10, on the way to target 1"),
    ],
)
def test_a_touched_thing_is_named(name: str, unmapped: tuple[str, ...], failure: str) -> None:
    log = log_of(along(0.0, 0.5), TARGETS, [{"touched": (name,)}])
    assert log.failure(WITHIN, unmapped) == failure


def test_a_touch_comes_before_any_other_reason() -> None:
    log = log_of(along(0.0, 0.5, 0.5), TARGETS, [{"touched": ("bin",)}, {}])
    assert log.outcome == "timeout"
    assert log.failure(WITHIN, ()).startswith("touched bin")


def test_a_push_on_the_way_counts_where_it_was() -> None:
    """It ends no mission: all targets are reached later, by a robot that is lost in the end."""
    places = [*along(0.0, 0.4, 0.8), ((1.8, 0.0, 0.0), (1.8, 0.9, 0.0))]
    infos: list[dict[str, Any]] = [{"touched": ("bin",)}, {"target": 1, "touched": ("bin", "keg")}, {"target": 2}]
    log = log_of(places, TARGETS, infos)
    assert log.failure(WITHIN, ()) == "touched bin, on the way to target 1"
    assert [(touch.name, touch.target, touch.step) for touch in log.touches] == [("bin", 1, 1), ("keg", 1, 2)]


def test_a_robot_that_is_lost_says_so() -> None:
    log = log_of(along(0.0, 0.5, error=0.8), TARGETS, [{"touched": ("bin",)}])
    assert log.failure(WITHIN, ()) == "touched bin, 0.80 m from where it believed to be, on the way to target 1"
    log = log_of(along(0.0, 0.5, error=0.4), TARGETS, [{"touched": ("bin",)}])
    assert log.failure(WITHIN, ()) == "touched bin, on the way to target 1"


def test_a_target_that_a_viewer_moved_counts_where_it_is() -> None:
    log = log_of(along(0.0, 0.5, 2.9), TARGETS, [{"goal": (3.0, 0.0)}, {"goal": (3.0, 0.0), "target": 1}])
    assert log.targets == [(3.0, 0.0), (2.0, 0.0)]
    assert log.arrivals == pytest.approx([0.1])
    assert log.mission.targets == TARGETS


def test_errors_and_lengths_are_those_of_the_poses() -> None:
    places: list[tuple[Pose, Pose]] = [
        ((0.0, 0.0, 0.0), (0.3, 0.4, 0.1)),
        ((3.0, 4.0, math.pi - 0.1), (3.0, 4.0, -math.pi + 0.1)),  # 0.2 rad over the seam
        ((3.0, 5.0, 0.0), (3.0, 4.0, -0.3)),
    ]
    log = log_of(places, TARGETS)
    assert log.errors == pytest.approx([0.5, 0.0, 1.0])
    assert log.heading_errors == pytest.approx([0.1, 0.2, 0.3])
    assert log.path_length == pytest.approx(6.0)
