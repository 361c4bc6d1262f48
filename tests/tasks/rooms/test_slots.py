"""Rooms in slots of one scene equal those that are compiled."""

import copy

import numpy as np
import pytest

from tasks.errors import TaskError
from tasks.physics import FloatArray, Physics, Pose
from tasks.registry import ROOM_TASKS, task_model
from tasks.rooms.changing_room import GENERATED, ChangingRoom
from tasks.rooms.reading import find_room
from tasks.rooms.room import Obstacle, Room, Shape, box
from tasks.rooms.scene import SLOTS, compile_room, compile_slots
from tasks.rooms.slots import Slots
from tasks.scene.loading import robot_physics

POSES = 400


def no_task(name: str) -> tuple[object, FloatArray, Room]:
    raise TaskError(f"there is no room {name}")


def open_slots() -> Physics:
    return robot_physics(compile_slots(), "slots")


def touch(physics: Physics, pose: Pose) -> tuple[list[tuple[float, ...]], FloatArray]:
    """Contacts, in order of their places, and the scan."""
    with physics.reset_context():
        physics.set_pose(pose)
    contacts = [(contact.dist, *contact.pos, *contact.frame[:3]) for contact in physics.data.ptr.contact]
    return sorted(tuple(np.round(each, 9).tolist()) for each in contacts), physics.ranges()


def draw_pose(rng: np.random.Generator, room: Room, number: int) -> Pose:
    """Anywhere among the obstacles, every second one beside one."""
    places = np.array([obstacle.position[:2] for obstacle in room.obstacles] or [(0.0, 0.0)])
    x, y = rng.uniform(places.min(axis=0) - 0.5, places.max(axis=0) + 0.5)
    if number % 2:
        x, y = places[rng.integers(len(places))] + rng.uniform(-0.5, 0.5, 2)
    return Pose(float(x), float(y), rng.uniform(-np.pi, np.pi))


def test_contacts_and_scans_are_those_of_the_compiled_room() -> None:
    rng, slots, touching = np.random.default_rng(0), open_slots(), 0
    changing = ChangingRoom(GENERATED, no_task)  # type: ignore[arg-type]
    for number in range(POSES // 10):
        name = f"{GENERATED[number % len(GENERATED)]}:{5000 + number}"
        room = find_room(name)
        changing.enter(slots, name)
        compiled = robot_physics(compile_room(room), name)
        for each in range(10):
            pose = draw_pose(rng, room, each)
            (contacts, ranges), (expected, expected_ranges) = touch(slots, pose), touch(compiled, pose)
            assert contacts == expected, (name, pose)
            np.testing.assert_array_equal(ranges, expected_ranges)
            touching += len(contacts) > 3  # wheels and caster stand on the floor
    assert touching > POSES / 4


def test_a_smaller_room_leaves_nothing_of_a_larger_one() -> None:
    slots, filled = open_slots(), Slots(open_slots().model.ptr)
    filled = Slots(slots.model.ptr)
    filled.fill([box(1.0, y / 10, 0.05, 0.05) for y in range(-20, 20)])
    assert touch(slots, Pose(0.0, 0.0, 0.0))[1].min() < 1.0
    filled.fill([])
    contacts, ranges = touch(slots, Pose(1.0, 0.0, 0.0))
    assert len(contacts) == 3
    assert ranges.min() == slots.ranges().max()


def test_every_room_of_the_tasks_has_its_slots() -> None:
    slots = Slots(compile_slots())
    for task in ROOM_TASKS:
        assert task_model(task).ngeom < SLOTS + 100
    with pytest.raises(TaskError, match="up to 256 obstacles, not 257"):
        slots.fill([box(0.0, 0.0, 0.1, 0.1)] * 257)
    hull = Obstacle(Shape.HULL, (0.0, 0.0, 0.0), points=((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
    with pytest.raises(TaskError, match="not of hulls"):
        slots.fill([hull])


def test_a_room_without_a_start_is_followed_by_another_and_nothing_but_such_rooms_end_in_a_sentence() -> None:
    physics, rng = open_slots(), np.random.default_rng(0)
    changing = ChangingRoom(["full", "full", "full", "bare"], no_task)  # type: ignore[arg-type]
    for _ in range(5):
        start, _ = changing.enter_drawn(physics, rng)
        assert changing.name.startswith("bare:")
        assert start[:2] == (0.0, 0.0)
    with pytest.raises(TaskError, match="20 rooms leave the robot no start and goal; the last was full"):
        ChangingRoom(["full"], no_task).enter_drawn(physics, rng)  # type: ignore[arg-type]


def test_a_copy_of_a_room_has_slots_of_its_own() -> None:
    physics, changing = open_slots(), ChangingRoom(GENERATED, no_task)  # type: ignore[arg-type]
    changing.enter(physics, "clutter:7")
    other_physics, other = copy.deepcopy((physics, changing))
    other.enter(other_physics, "bare:1")
    pose = find_room("clutter:7").obstacles[8].position
    here, there = (touch(each, Pose(pose[0], pose[1], 0.0)) for each in (physics, other_physics))
    assert len(here[0]) > len(there[0])
