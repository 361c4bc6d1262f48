"""Poses in SDF: of links, frames and models, relative to one another."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element

import numpy as np

from tasks.errors import TaskError
from tasks.rooms.solid.collector import quote
from tasks.rooms.solid.files import UnreadError
from tasks.rooms.solid.transforms import IDENTITY, Transform
from tasks.rooms.solid.xml_file import parse_numbers

_LONGEST_CHAIN = 50  # of poses relative to one another


class Frames:
    """The named frames of a model or world, in its own frame."""

    def __init__(self, children: Iterable[Element]) -> None:
        """From the elements of the model or world, includes replaced by their models."""
        named = [child for child in children if child.tag in ("link", "frame", "model", "joint")]
        self._elements = {child.get("name", ""): child for child in reversed(named)}
        self._found: dict[str, Transform] = dict.fromkeys(("__model__", "world", ""), IDENTITY)
        self._chain: list[str] = []

    def find(self, name: str) -> Transform:
        """The pose of a frame.

        Raises:
            UnreadError: there is no such frame, or it is relative to itself.
            TaskError: a number on the way to it is invalid.
        """
        if name not in self._found:
            if name not in self._elements:
                raise UnreadError(f"its pose is relative to {quote(name)}, which is not in the same model")
            if name in self._chain or len(self._chain) >= _LONGEST_CHAIN:
                raise UnreadError(f"its pose is relative to {quote(name)}, which leads back to itself or too far")
            self._chain.append(name)
            try:
                self._found[name] = self.pose_of(self._elements[name])
            finally:
                self._chain.pop()
        return self._found[name]

    def pose_of(self, element: Element, inside: Transform = IDENTITY) -> Transform:
        """The pose of an element; without `relative_to` it lies in the frame `inside`. Errors as find()."""
        own, relative_to = read_pose(element)
        if not relative_to and element.tag == "frame":
            relative_to = element.get("attached_to", "")
        elif not relative_to and element.tag == "joint":
            relative_to = element.findtext("child", "").strip()
        if element.tag == "model" and (placed := element.get("placement_frame")):
            own = own @ Frames(element).find(placed).inverse()
        return (self.find(relative_to) if relative_to else inside) @ own


def read_pose(element: Element) -> tuple[Transform, str]:
    """The pose that an element holds, and the frame it is relative to, if it names one.

    Raises:
        TaskError: its numbers are invalid.
    """
    pose = element.find("pose")
    if pose is None:
        return IDENTITY, ""
    what = f"the pose of the {element.tag[:20]} {quote(element.get('name', ''))}"
    relative_to = pose.get("relative_to") or pose.get("frame") or ""
    if not (pose.text or "").strip():
        return IDENTITY, relative_to
    if pose.get("rotation_format") == "quat_xyzw":
        numbers = parse_numbers(pose.text, 7, what)
        x, y, z, w = numbers[3:]
        if not any(abs(number) > 1e-6 for number in (x, y, z, w)):
            raise TaskError(f"{what} has the quaternion 0 0 0 0, which is no rotation")
        return Transform.from_quaternion(numbers[:3], (w, x, y, z)), relative_to
    numbers = parse_numbers(pose.text, 6, what)
    angles = np.radians(numbers[3:]).tolist() if pose.get("degrees") in ("1", "true") else numbers[3:]
    return Transform.from_rpy(numbers[:3], angles), relative_to
