"""A mission from above, in the manner of the paper's figure: room, targets, the path driven and the estimated one."""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from asddpg.atomic_write import write_whole
from asddpg.missions.environment import Point
from asddpg.missions.log import MissionLog
from asddpg.planning.occupancy_grid import FloatArray
from tasks.room_geometry.obstacles import Obstacles

_WIDTH, _MARGIN = 1200, 0.3  # px and m
_SMOOTH = 3  # drawn so many times as large: PIL draws without smooth edges
_WALL, _UNKNOWN, _EDGE = (70, 74, 80), (250, 205, 60), (150, 118, 10)
_TARGET, _TRUE, _ESTIMATE, _START = (31, 119, 180), (214, 39, 40), (20, 20, 20), (44, 160, 44)
_DASH, _GAP = 0.12, 0.10  # m
_LEGEND = ("on the map", _WALL), ("not on the map", _UNKNOWN), ("targets", _TARGET), ("driven", _TRUE)


class MissionPicture:
    """A picture of a room; each call draws on it."""

    def __init__(self, room: Obstacles, known: Obstacles) -> None:
        """Draw a room's obstacles, those not `known` in yellow."""
        low, high = np.array(room.low) - _MARGIN, np.array(room.high) + _MARGIN
        self._scale = _WIDTH * _SMOOTH / (high[0] - low[0])  # px a metre
        self._strip = _WIDTH * _SMOOTH * 0.045  # px, of the title above and of the legend below
        self._left, self._top = low[0], high[1] + self._strip / self._scale
        height = round((high[1] - low[1]) * self._scale + 2.0 * self._strip)
        self._image = Image.new("RGB", (_WIDTH * _SMOOTH, height), "white")
        self._draw = ImageDraw.Draw(self._image)
        on_map = set(known.outlines)
        for outline in room.outlines:
            is_known = outline in on_map
            self._draw.polygon(
                self._pixels(outline), fill=_WALL if is_known else _UNKNOWN, outline=None if is_known else _EDGE
            )

    def draw_mission(self, log: MissionLog, within: float) -> None:
        """Draw targets, start, and both paths; `within` is the targets' radius, metres."""
        for number, target in enumerate(log.targets, 1):
            self._circle(target, within, _TARGET)
            self._text(target, str(number), _TARGET, 0.36)
        self._circle(log.mission.start[:2], 0.15, _START, is_filled=True)
        self._line(np.array(log.poses)[:, :2], _TRUE, 0.05)
        for dash in _dashes(np.array(log.estimates)[:, :2]):
            self._line(dash, _ESTIMATE, 0.03)
        for touch in log.touches:
            self._cross(log.poses[touch.step][:2])

    def write(self, path: Path, title: str) -> None:
        """Write a PNG with a title and a legend below."""
        self._write_legend(title)
        small = self._image.resize((_WIDTH, round(self._image.height / _SMOOTH)), Image.Resampling.LANCZOS)
        content = io.BytesIO()
        small.save(content, "PNG", optimize=True)
        write_whole(path, content.getbuffer())

    # Drawing ------------------------------------------------------------------------------------------------------

    def _pixels(self, points: Sequence[Point] | FloatArray) -> list[tuple[float, float]]:
        return [((x - self._left) * self._scale, (self._top - y) * self._scale) for x, y in points]

    def _line(self, points: FloatArray, colour: tuple[int, int, int], width: float) -> None:
        self._draw.line(self._pixels(points), fill=colour, width=max(1, round(width * self._scale)), joint="curve")

    def _circle(self, place: Point, radius: float, colour: tuple[int, int, int], is_filled: bool = False) -> None:
        ((x, y),), size = self._pixels([place]), radius * self._scale
        width = max(2, round(0.04 * self._scale))
        box = (x - size, y - size, x + size, y + size)
        self._draw.ellipse(box, outline=colour, width=width, fill=colour if is_filled else None)

    def _cross(self, place: Point) -> None:
        x, y = place
        for sign in (-1.0, 1.0):
            self._line(np.array([[x - 0.2, y - 0.2 * sign], [x + 0.2, y + 0.2 * sign]]), _TRUE, 0.08)

    def _text(self, place: Point, text: str, colour: tuple[int, int, int], size: float) -> None:
        ((x, y),) = self._pixels([place])
        self._draw.text((x, y), text, fill=colour, anchor="mm", font=ImageFont.load_default(size * self._scale))

    def _write_legend(self, title: str) -> None:
        size = self._strip * 0.45
        font = ImageFont.load_default(size)
        x, y = size, self._image.height - self._strip / 2
        self._draw.text((x, self._strip / 2), title, fill=_ESTIMATE, anchor="lm", font=font)
        for name, colour in _LEGEND:
            self._draw.rectangle((x, y - size / 3, x + size, y + size / 3), fill=colour)
            self._draw.text((x + 1.3 * size, y), name, fill=_ESTIMATE, anchor="lm", font=font)
            x += 1.3 * size + self._draw.textlength(name, font) + size
        for begin in (0.0, 0.8, 1.6):
            self._draw.line([(x + begin * size, y), (x + (begin + 0.5) * size, y)], fill=_ESTIMATE, width=3 * _SMOOTH)
        self._draw.text((x + 2.4 * size, y), "estimated", fill=_ESTIMATE, anchor="lm", font=font)


def _dashes(path: FloatArray) -> list[FloatArray]:
    """Pieces of a path, (n, 2), as long as a dash and a gap apart along it."""
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    dashes = []
    for begin in np.arange(0.0, lengths[-1], _DASH + _GAP):
        at = np.array([begin, min(begin + _DASH, lengths[-1])])
        dashes.append(np.stack([np.interp(at, lengths, path[:, axis]) for axis in (0, 1)], axis=-1))
    return dashes
