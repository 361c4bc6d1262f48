"""Starts and goals of rooms: drawn, and of the evaluation sets."""

import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from tasks.constants import GOAL_RADIUS
from tasks.evaluation_pairs import fresh_pairs, stored_pairs
from tasks.physics import FloatArray, Pose
from tasks.registry import task_model
from tasks.room_geometry.held_out import Pair
from tasks.room_geometry.start_goal import HELD_OUT_MARGIN
from tasks.rooms.pairs import SIZES, draw_sets
from tasks.rooms.reading import find_room
from tasks.rooms.room import Obstacle, Room, Shape, box, cylinder
from tasks.rooms.room_rule import RoomRule
from tasks.rooms.scene import compile_room
from tests.conftest import ROOT
from tests.support.room_files import write_maze
from tests.tasks.rooms.test_scene import walls

PRINT_SETS = """
from tasks.evaluation_pairs import stored_pairs
for name in ("validation", "test"):
    print(stored_pairs("clutter:1", name, 0.3, 7))
"""


def goals(pairs: tuple[Pair, ...]) -> FloatArray:
    return np.array([pair.goal for pair in pairs])


def apart(one: FloatArray, other: FloatArray) -> float:
    """Least distance between points of two sets, metres."""
    return float(np.linalg.norm(one[:, None] - other, axis=-1).min())


def sets_of(room: Room) -> dict[str, tuple[Pair, ...]]:
    return {str(name): pairs for name, pairs in draw_sets(room, RoomRule(compile_room(room))).items()}


def test_the_sets_are_equal_in_two_processes() -> None:
    found = [
        subprocess.run(
            [sys.executable, "-c", PRINT_SETS],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": seed, "PATH": "/usr/bin"},
        ).stdout
        for seed in ("1", "2")
    ]
    expected = [str(stored_pairs("clutter:1", name, 0.3, 7)) for name in SIZES]
    assert found == ["\n".join(expected) + "\n"] * 2


def test_validation_and_test_are_apart_and_training_goals_from_both() -> None:
    room = Room((*walls(4.0, 4.0), cylinder(1.0, 1.0, 0.3)))
    sets = sets_of(room)
    assert {name: len(pairs) for name, pairs in sets.items()} == SIZES
    assert apart(goals(sets["validation"]), goals(sets["test"])) > HELD_OUT_MARGIN - 0.002
    env = gymnasium.make("asddpg/Nav-v0", scene="clutter:1")
    held_out = np.concatenate([goals(stored_pairs("clutter:1", name, GOAL_RADIUS, 50)) for name in SIZES])
    drawn = np.array([env.reset(seed=seed)[1]["goal"] for seed in range(100)])
    assert apart(held_out, drawn) > HELD_OUT_MARGIN - 0.002
    env.close()


def test_pairs_are_free_and_a_path_leads_from_each_start_to_its_goal() -> None:
    for name in ("maze:2", "legs:1"):
        rule = RoomRule(task_model(name))
        for pair in stored_pairs(name, "test", GOAL_RADIUS, 20):
            ends = np.array([pair.start[:2], pair.goal])
            straight = float(np.hypot(*(ends[1] - ends[0])))
            assert (rule.obstacles.clearance(ends) > 0.28).all()
            assert straight >= 0.999
            assert 0.9 * (straight - GOAL_RADIUS) <= pair.shortest_path < 60.0


def test_places_fill_the_floor_around_the_robot_and_no_other() -> None:
    hall = (*walls(4.0, 3.0), box(0.0, 0.0, 0.05, 3.0))  # the wall in its midst cuts it into two
    rule = RoomRule(compile_room(Room((*hall, cylinder(-2.0, 0.0, 0.8)))))
    rng = np.random.default_rng(0)
    drawn = np.array([[*rule.draw(rng, np.zeros((0, 2)))[0][:2]] for _ in range(300)])
    assert drawn.min(axis=0) == pytest.approx([0.05 + 0.3, -2.7], abs=0.15)
    assert drawn.max(axis=0) == pytest.approx([3.7, 2.7], abs=0.15)


def test_a_hall_has_no_goals_that_an_episode_is_too_short_for() -> None:
    rule, rng = RoomRule(compile_room(Room(walls(40.0, 40.0)))), np.random.default_rng(0)
    drawn = [rule.draw(rng, np.zeros((0, 2))) for _ in range(50)]
    distances = [np.hypot(goal[0] - start[0], goal[1] - start[1]) for start, goal in drawn]
    assert 9.0 < max(distances) <= 10.0


def test_a_way_longer_than_an_episode_is_no_test(tmp_path: Path) -> None:
    aisle, ends = f"#{' ' * 20}#", (f"{'#' * 20} #", f"# {'#' * 20}")  # walls that are open at either end in turn
    inside = [row for turn in range(6) for row in (ends[turn % 2], aisle)]
    path = tmp_path / "maze.txt"
    path.write_text("\n".join(["#" * 22, aisle, *inside, "#" * 22]) + "\n")
    drawn = draw_sets(find_room(str(path)), RoomRule(task_model(str(path))))["validation"]
    lengths = [pair.shortest_path for pair in stored_pairs(str(path), "validation", GOAL_RADIUS)]
    assert 5 < len(lengths) < len(drawn)
    assert 10.0 < max(lengths) <= 16.0


def test_a_small_room_has_fewer_pairs_and_leaves_floor_for_training() -> None:
    room = Room(walls(1.2, 1.2))
    sets = sets_of(room)
    held_out = np.concatenate([goals(pairs) for pairs in sets.values()])
    assert 3 < len(sets["validation"]) < len(sets["test"]) < 60
    rule, rng = RoomRule(compile_room(room)), np.random.default_rng(0)
    for _ in range(200):
        rule.draw(rng, held_out)


def test_a_rooms_own_pairs_are_both_sets(tmp_path: Path) -> None:
    path = tmp_path / "maze.txt"
    path.write_text("#######\n#S   G#\n#     #\n#S    #\n#######\n")
    own = ((Pose(1.5, 1.5, 0.0), (5.5, 3.5)), (Pose(1.5, 3.5, 0.0), (5.5, 3.5)))
    for name in SIZES:
        pairs = stored_pairs(str(path), name, GOAL_RADIUS)
        assert [(pair.start, pair.goal) for pair in pairs] == list(own)
        assert [pair.shortest_path for pair in pairs] == pytest.approx([np.hypot(4, 2) - 0.3, 3.7], rel=0.03)
    assert len(stored_pairs(str(path), "test", GOAL_RADIUS, 1)) == 1
    path.write_text(path.read_text().replace("#S    #", "#     #"))  # a change is seen
    assert len(stored_pairs(str(path), "test", GOAL_RADIUS)) == 1


def test_where_no_path_leads_the_straight_line_counts(tmp_path: Path) -> None:
    path = tmp_path / "maze.txt"
    path.write_text("#######\n#S # G#\n#  #  #\n#######\n")
    assert [pair.shortest_path for pair in stored_pairs(str(path), "test", GOAL_RADIUS)] == [3.7]


def test_fresh_pairs_follow_their_seed(tmp_path: Path) -> None:
    scene = str(tmp_path / write_maze(tmp_path))
    one, again, other = (fresh_pairs(scene, np.random.default_rng(seed), 3, GOAL_RADIUS) for seed in (1, 1, 2))
    assert one == again != other


def test_things_that_can_be_pushed_are_obstacles_of_the_floor() -> None:
    thing = Obstacle(Shape.BOX, (0.0, 0.0, 0.2), (0.5, 0.5, 0.2), mass=1.0)
    rule = RoomRule(compile_room(Room((*walls(3.0, 3.0), thing))))
    assert np.abs(rule.places).max(axis=1).min() > 0.7


@pytest.mark.slow
def test_a_hall_of_100_metres_and_2000_things_opens_in_seconds() -> None:
    rng = np.random.default_rng(0)
    things = [box(x, y, 0.5, 0.05) for x, y in rng.uniform(-49.0, 49.0, (2000, 2)).tolist()]
    room = Room((*walls(50.0, 50.0), *things))
    assert {name: len(pairs) for name, pairs in sets_of(room).items()} == SIZES
