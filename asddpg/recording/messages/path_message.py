"""/path: the way that was driven, coloured by who drove.

It is told whole every few steps, since a viewer that is moved in time gets the last message only. So what does not
change any more is kept encoded: a message is put together from its bytes, in less than half the time.
"""

import functools

from foxglove.messages import (
    Color,
    LinePrimitive,
    LinePrimitiveLineType,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    Vector3,
)

from asddpg.recording.messages.scene_messages import Point
from tasks.scene.shapes import WORLD

PATH_WIDTH = 0.03  # m
PATH_HEIGHT = 0.02  # m above the floor
DRIVER_COLOURS = {
    "policy": (0.12, 0.47, 0.71),
    "controller": (1.0, 0.50, 0.05),
    "random": (0.5, 0.5, 0.5),
}
OTHER_COLOUR = (0.5, 0.5, 0.5)

_NOWHERE_ELSE = Pose(position=Vector3(), orientation=Quaternion(w=1.0))
# In protobuf's wire format a field that holds a message is a tag, a length and the message: here the tags, as foxglove
# writes them before a message of length 0. Several such fields are a list, in whatever order with the others.
_ENTITY = SceneUpdate(entities=[SceneEntity()]).encode()[:-1]
_LINE = SceneEntity(lines=[LinePrimitive()]).encode()[:-1]
_POINT = LinePrimitive(points=[Point3()]).encode()[:-1]
_PATH = SceneEntity(id="path", frame_id=WORLD).encode()  # without lines


class PathMessage:
    """The path driven so far as one entity, a line for each stretch with one driver, in that driver's colour.

    A stretch begins where the last one ended, so that the line has no gaps.
    """

    def __init__(self) -> None:
        self._finished = b""  # lines
        self._driver, self._points = "", [b""]

    def begin(self, place: Point) -> None:
        """A new path from a place, (x, y) in metres."""
        self._finished = b""
        self._driver, self._points = "", [_point(place)]

    def extend(self, driver: str, place: Point) -> None:
        """Somebody drove on to a place."""
        if driver != self._driver:
            if len(self._points) > 1:
                self._finished += self._line()
            self._driver, self._points = driver, self._points[-1:]
        self._points.append(_point(place))

    def encode(self) -> bytes:
        """The whole of it, a SceneUpdate."""
        return _field(_ENTITY, _PATH + self._finished + self._line())

    def _line(self) -> bytes:
        return _field(_LINE, _pointless_line(self._driver) + b"".join(self._points))


@functools.cache
def _pointless_line(driver: str) -> bytes:
    r, g, b = DRIVER_COLOURS.get(driver, OTHER_COLOUR)
    kind, colour = LinePrimitiveLineType.LineStrip, Color(r=r, g=g, b=b, a=1.0)
    encoded: bytes = LinePrimitive(type=kind, pose=_NOWHERE_ELSE, thickness=PATH_WIDTH, color=colour).encode()
    return encoded


def _point(place: Point) -> bytes:
    x, y = place
    return _field(_POINT, Point3(x=x, y=y, z=PATH_HEIGHT).encode())


def _field(tag: bytes, message: bytes) -> bytes:
    """A message as a field of another: its length is a varint, seven bits a byte, the lowest first."""
    length, digits = len(message), b""
    while length > 127:
        digits += bytes((length & 127 | 128,))
        length >>= 7
    return b"".join((tag, digits, bytes((length,)), message))
