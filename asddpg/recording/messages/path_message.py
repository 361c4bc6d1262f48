"""/path: the path driven so far, coloured by driver."""

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
    "planner": (0.55, 0.34, 0.76),
    "random": (0.5, 0.5, 0.5),
}
OTHER_COLOUR = (0.5, 0.5, 0.5)

_IDENTITY = Pose(position=Vector3(), orientation=Quaternion(w=1.0))


class PathMessage:
    """The path so far as one entity: a line for each stretch with one driver, in that driver's colour.

    A stretch begins where the last one ended, so that the line has no gaps.
    """

    def __init__(self, place: Point) -> None:
        """Begin at (x, y), metres, world frame."""
        self._finished: list[LinePrimitive] = []
        self._driver, self._points = "", [_point(place)]

    def extend(self, driver: str, place: Point) -> None:
        """Add the place that a driver reached with a step."""
        if driver != self._driver:
            if len(self._points) > 1:
                self._finished.append(self._line())
            self._driver, self._points = driver, self._points[-1:]
        self._points.append(_point(place))

    def encode(self) -> bytes:
        """The whole path, a SceneUpdate."""
        entity = SceneEntity(id="path", frame_id=WORLD, lines=[*self._finished, self._line()])
        encoded: bytes = SceneUpdate(entities=[entity]).encode()
        return encoded

    def _line(self) -> LinePrimitive:
        r, g, b = DRIVER_COLOURS.get(self._driver, OTHER_COLOUR)
        return LinePrimitive(
            type=LinePrimitiveLineType.LineStrip,
            pose=_IDENTITY,
            thickness=PATH_WIDTH,
            color=Color(r=r, g=g, b=b, a=1.0),
            points=self._points,
        )


def _point(place: Point) -> Point3:
    x, y = place
    return Point3(x=x, y=y, z=PATH_HEIGHT)
