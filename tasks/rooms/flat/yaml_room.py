"""Rooms in YAML: a map of ROS, or a world of IR-SIM."""

from pathlib import Path

from tasks.errors import TaskError
from tasks.rooms.flat.irsim_world import read_irsim
from tasks.rooms.flat.plain_yaml import read_mapping
from tasks.rooms.flat.ros_map import read_ros_map
from tasks.rooms.room import Room


def read_yaml(path: Path) -> Room:
    """The room of a YAML file; TaskError where it is neither kind, or broken."""
    content = read_mapping(path)
    if "image" in content:
        return read_ros_map(path)
    if content.keys() & {"world", "obstacle", "irsim"}:
        return read_irsim(path)
    raise TaskError(f"{path} holds no room: a map of ROS has `image`, a world of IR-SIM `world` and `obstacle`")
