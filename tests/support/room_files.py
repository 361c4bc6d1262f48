"""The same small room as a file of each format: 4 × 3 m of floor with its corner at the origin, a post in its midst."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import yaml
from PIL import Image

from tests.conftest import TINY

# Centre and half the sides of its walls and of its post, metres, in the plane.
BOXES = {
    "wall_south": (2.0, -0.05, 2.1, 0.05),
    "wall_north": (2.0, 3.05, 2.1, 0.05),
    "wall_west": (-0.05, 1.5, 0.05, 1.5),
    "wall_east": (4.05, 1.5, 0.05, 1.5),
    "post": (2.0, 1.5, 0.2, 0.2),
}
QUICK_TRAINING = [*TINY, "total_steps=240", "test_episodes=2", "validation.every=120", "record.every=0"]


def picture() -> Image.Image:
    """The room at 0.05 m a pixel, walls of two pixels."""
    grey = np.zeros((64, 84), np.uint8)
    grey[2:-2, 2:-2] = 254
    grey[28:36, 38:46] = 0
    return Image.fromarray(grey)


def write_mjcf(folder: Path) -> str:
    geoms = "".join(
        f"<geom name='{name}' type='box' pos='{x} {y} 0.25' size='{half_x} {half_y} 0.25'/>"
        for name, (x, y, half_x, half_y) in BOXES.items()
    )
    return _write(folder, "room.xml", f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")


def write_world(folder: Path) -> str:
    models = "".join(
        f"<model name='{name}'><static>1</static><pose>{x} {y} 0.25 0 0 0</pose><link name='l'><collision name='c'>"
        f"<geometry><box><size>{2 * half_x} {2 * half_y} 0.5</size></box></geometry></collision></link></model>"
        for name, (x, y, half_x, half_y) in BOXES.items()
    )
    return _write(folder, "room.world", f"<sdf version='1.6'><world name='w'>{models}</world></sdf>")


def write_ros_map(folder: Path) -> str:
    picture().save(folder / "map.pgm")
    content = {"image": "map.pgm", "resolution": 0.05, "origin": [-0.1, -0.1, 0.0]}
    return _write(folder, "map.yaml", yaml.safe_dump(content))


def write_picture(folder: Path) -> str:
    picture().save(folder / "plan.png")
    return "plan.png@0.05"


def write_irsim(folder: Path) -> str:
    shape = "{shape: {name: rectangle, length: 0.4, width: 0.4}, state: [2, 1.5, 0]}"
    return _write(folder, "world.yaml", f"world: {{width: 4, height: 3}}\nobstacle:\n  - {shape}\n")


def write_maze(folder: Path) -> str:
    floor, post = "#        #\n" * 2, "#   ##   #\n" * 2
    return _write(folder, "maze.txt", f"cell 0.5\n##########\n{floor}{post}{floor}##########\n")


FORMATS: dict[str, Callable[[Path], str]] = {
    "mjcf": write_mjcf,
    "gazebo": write_world,
    "ros map": write_ros_map,
    "picture": write_picture,
    "irsim": write_irsim,
    "maze": write_maze,
    "generated": lambda _: "clutter:1",
}


def _write(folder: Path, name: str, text: str) -> str:
    (folder / name).write_text(text)
    return name
