"""Start-goal pairs for an evaluation, drawn or stored, with the shortest paths that SPL needs."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import groupby, islice
from math import hypot, isfinite, sqrt

import mujoco
import numpy as np

from tasks.constants import GOAL_RADIUS
from tasks.errors import TaskError
from tasks.physics import FloatArray, Pose
from tasks.registry import ANYWHERE, OWN_ROOM, find_task, make_rule, task_model
from tasks.robots.names import PIONEER
from tasks.room_geometry.footprints import Footprint
from tasks.room_geometry.grid import Grid
from tasks.room_geometry.held_out import Pair, SetName, held_out_goals, held_out_pairs
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.changing_room import FIRST_NUMBER, GENERATED, LAST_NUMBER, GeneratedRoomRule, is_open, turning_radius
from tasks.rooms.pairs import SIZES, draw_sets, room_digest
from tasks.rooms.reading import find_room
from tasks.rooms.room_rule import RoomRule

CELL, ROOM_CELL = 0.05, 0.1  # m; of a room that is a file or is generated: its paths are not stored
MOST_CELLS = 500_000  # of a large room cells grow with it: a search takes a second and half a gigabyte
SEED = 2018  # of the pairs in generated rooms
EVALUATED_GOALS = (1.5, 10.0)  # m from start to goal as the crow flies, in generated rooms
LONGEST = 10.0  # m, of the shortest path there: an episode lasts 20 m at full speed
LONGEST_OF_ROOM = 16.0  # m, likewise in a room of the user's own, unless its pairs are its own
ROBOT_RADIUS = 0.19  # m: half the Pioneer's width, to the centimetre: the space for driving straight through a gap


def fresh_pairs(
    task_name: str, rng: np.random.Generator, count: int, goal_radius: float, robot: str = PIONEER
) -> tuple[Pair, ...]:
    """Draw pairs of a task as training does, away from the goals of the stored sets."""
    if task_name == ANYWHERE:
        numbers = [int(number) for number in rng.integers(FIRST_NUMBER, LAST_NUMBER + 1, count)]
        rooms = [f"{GENERATED[index % len(GENERATED)]}:{number}" for index, number in enumerate(numbers)]
        return tuple(pair for room in rooms for pair in draw_room_pairs(room, 1, goal_radius, robot))
    if find_task(task_name) is OWN_ROOM:
        return draw_pairs(task_name, rng, count, goal_radius, np.zeros((0, 2)), ROOM_CELL, robot)
    return draw_pairs(task_name, rng, count, goal_radius, held_out_goals(task_name), robot=robot)


def draw_room_pairs(room_name: str, count: int, goal_radius: float, robot: str = PIONEER) -> tuple[Pair, ...]:
    """Pairs of task=nav_anywhere in a generated room, which follow from its name; their paths are bounded too."""
    rng = np.random.default_rng([SEED, *room_name.encode()])
    room = find_room(room_name)
    model = task_model(room_name, robot=robot)
    rule = GeneratedRoomRule(room, EVALUATED_GOALS, is_open(room_name), turning_radius(robot, model))
    pairs: list[Pair] = []
    while len(pairs) < count:
        drawn = replace(_round_pair(*rule.draw(rng, np.zeros((0, 2)))), room=room_name)
        pairs += [each for each in find_paths([drawn], model, goal_radius, ROOM_CELL) if each.shortest_path <= LONGEST]
    return tuple(pairs)


def _round_pair(start: Pose, goal: tuple[float, float]) -> Pair:
    """Millimetres, and thousandths of a radian, are enough to write down."""
    return Pair(Pose(*(round(value, 3) for value in start)), (round(goal[0], 3), round(goal[1], 3)), np.inf)


def draw_pairs(
    task_name: str,
    rng: np.random.Generator,
    count: int,
    goal_radius: float,
    held_out: FloatArray,
    cell: float = CELL,
    robot: str = PIONEER,
) -> tuple[Pair, ...]:
    """Draw pairs whose goals keep HELD_OUT_MARGIN from the held-out goals, (n, 2) metres; `cell` as in find_paths."""
    model = task_model(task_name, robot=robot)
    rule = make_rule(task_name, model)
    drawn = [rule.draw(rng, held_out) for _ in range(count)]
    return find_paths([_round_pair(*each) for each in drawn], model, goal_radius, cell)


def stored_pairs(
    task_name: str, set_name: SetName, goal_radius: float, count: int | None = None, robot: str = PIONEER
) -> tuple[Pair, ...]:
    """The stored pairs of a task, or those of a room: the first `count`, or all, in which the robot can start.

    Shortest paths are computed anew for a goal radius other than GOAL_RADIUS, for a robot other than the Pioneer, and
    in rooms that are files or generated.
    """
    searched = None if count is None or count >= SIZES[set_name] else count
    digest = room_digest(find_room(task_name)) if find_task(task_name) is OWN_ROOM else ""
    return _search_pairs(task_name, digest, set_name, goal_radius, searched, robot)[:count]


@cache
def _search_pairs(
    task_name: str, digest: str, set_name: SetName, goal_radius: float, count: int | None, robot: str
) -> tuple[Pair, ...]:
    """The pairs of a task, or of a room, which has a digest: its file may change."""
    if digest:
        model, room = task_model(task_name, robot=robot), find_room(task_name)
        drawn = find_paths(draw_sets(room, RoomRule(model))[set_name][:count], model, goal_radius, ROOM_CELL)
        short = tuple(pair for pair in drawn if pair.shortest_path <= LONGEST_OF_ROOM)
        return drawn if room.pairs or not short else short
    pairs = held_out_pairs(task_name, set_name)
    if robot == PIONEER and goal_radius == GOAL_RADIUS:
        return pairs[:count]
    if task_name == ANYWHERE:
        found = tuple(islice(_search_rooms(pairs, goal_radius, robot), count))
    else:
        model = task_model(task_name, robot=robot)
        found = find_paths(_keep_fitting(pairs, model, robot)[:count], model, goal_radius)
    if not found:
        raise TaskError(f"the robot {robot} is too large for {task_name}: it fits at none of the stored starts")
    return found


def _search_rooms(pairs: Sequence[Pair], goal_radius: float, robot: str) -> Iterator[Pair]:
    """Pairs of task=nav_anywhere, each in its own room, with their paths; none in a room too narrow for the robot."""
    for room, there in groupby(pairs, lambda pair: pair.room):
        try:
            model = task_model(room, robot=robot)
        except TaskError:
            continue
        yield from find_paths(_keep_fitting([*there], model, robot), model, goal_radius, ROOM_CELL)


def _keep_fitting(pairs: Sequence[Pair], model: mujoco.MjModel, robot: str) -> Sequence[Pair]:
    """Those at whose start the robot fits; the Pioneer fits at every stored one."""
    if robot == PIONEER:
        return pairs
    radius, obstacles = Footprint.from_model(model).radius, Obstacles.from_model(model)
    return [pair for pair in pairs if obstacles.clearance(pair.start[:2]) > radius]


def find_paths(
    pairs: Sequence[Pair], model: mujoco.MjModel, goal_radius: float, cell: float = CELL
) -> tuple[Pair, ...]:
    """The pairs with the lengths of the shortest free paths to within `goal_radius` (m) of their goals.

    The robot passes every gap of its width. They are found on a grid of `cell` metres, or more in a large room. Where
    no path leads, as behind a box that can be pushed, the straight line counts.
    """
    obstacles = Obstacles.from_model(model)
    area = float(np.prod(np.subtract(obstacles.high, obstacles.low)))
    half_width = round(Footprint.from_model(model).half_width, 2)  # of the Pioneer ROBOT_RADIUS
    grid = Grid(obstacles, half_width, max(cell, sqrt(area / MOST_CELLS)))
    result = list(pairs)
    for start in {pair.start[:2] for pair in pairs}:
        from_start = grid.distances(grid.nearest(start))
        for index, pair in enumerate(pairs):
            if pair.start[:2] == start:
                is_goal = np.sum((grid.points - pair.goal) ** 2, axis=1) <= goal_radius**2
                length = float(from_start[is_goal].min(initial=np.inf))
                if not isfinite(length):
                    length = max(0.0, hypot(pair.goal[0] - start[0], pair.goal[1] - start[1]) - goal_radius)
                result[index] = replace(pair, shortest_path=round(length, 3))
    return tuple(result)
