"""What becomes of a room: `python -m tools.room plan.png@0.05`, or of a map of ROS, a Gazebo world, MJCF, cylinders:17.

Draws it from above, with the floor that the robot can turn on, lists what was taken of its file and what was not, and
writes it as MJCF, with the robot, for any viewer.
"""

import shlex
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco

from asddpg.atomic_write import write_whole
from asddpg.messages import print_line
from asddpg.missions.room_picture import WALL, RoomPicture
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import python, run
from tasks.options import Range, argument, option
from tasks.room_geometry.free_space import CELL
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.reading import ROOMS, find_room, is_room, short_name
from tasks.rooms.room import Room
from tasks.rooms.room_rule import RoomRule
from tasks.rooms.scene import build_scene

_FREE, _START, _GOAL = (226, 240, 217), (44, 160, 44), (31, 119, 180)


@dataclass(frozen=True)
class RoomArguments:
    """The room, and where its picture and its scene go."""

    room: str = argument(f"{ROOMS[0].upper()}{ROOMS[1:]}.", values=Range(is_room, ROOMS))
    picture: Path | None = option(None, "File of the picture; null takes <room>_room.png in the present folder.")
    mjcf: Path | None = option(None, "File of the scene; null takes <room>_scene.xml in the present folder.")


def main(arguments: Sequence[str]) -> None:
    """Read, list, draw and write."""
    parsed = parse_arguments(RoomArguments, arguments)
    name = short_name(parsed.room)
    room = find_room(parsed.room)
    spec = build_scene(room)
    model = spec.compile()
    picture, scene = parsed.picture or Path(f"{name}_room.png"), parsed.mjcf or Path(f"{name}_scene.xml")
    print_line(_describe(room, model))
    _draw(room, model).write(picture, f"{name}: {len(room.obstacles)} obstacles")
    write_whole(scene, spec.to_xml().encode())
    drives = f"{python()} -m asddpg.play agent=move_base task={shlex.quote(parsed.room)}"
    print_line(f"written to {picture} and {scene}; {drives} drives in it")


def _describe(room: Room, model: mujoco.MjModel) -> str:
    """What was taken, what was not, and where the robot begins."""
    kinds = Counter(f"movable {each.shape}" if each.mass else str(each.shape) for each in room.obstacles)
    taken = ", ".join(f"{count} {kind}" for kind, count in kinds.most_common()) or "nothing"
    x, y, _ = model.body("base").pos
    (left, bottom), (right, top) = Obstacles.from_model(model).low, Obstacles.from_model(model).high
    lines = [f"taken: {taken}", *(f"not taken: {sentence}" for sentence in room.omitted)]
    size = f"{right - left:.1f} × {top - bottom:.1f} m, the robot begins at ({x:.2f}, {y:.2f})"
    return "\n".join([*lines, size])


def _draw(room: Room, model: mujoco.MjModel) -> RoomPicture:
    rule = RoomRule(model)
    picture = RoomPicture(rule.obstacles)
    picture.fill_cells(rule.places, CELL, _FREE)
    picture.draw_outlines(rule.obstacles.outlines)
    picture.add_legend("obstacles", WALL)
    picture.add_legend("where the robot can turn and drive", _FREE)
    if room.pairs:
        picture.add_legend("starts", _START)
        picture.add_legend("goals", _GOAL)
    for start, goal in room.pairs:
        picture.draw_circle(start[:2], 0.15, _START, is_filled=True)
        picture.draw_circle(goal, 0.3, _GOAL)
    return picture


if __name__ == "__main__":
    run(main, help_text(__doc__, RoomArguments))
