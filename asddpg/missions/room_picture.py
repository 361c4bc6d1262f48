"""A room from above, drawn to scale: obstacles, lines and circles in metres, a title and a legend."""

import io
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from asddpg.atomic_write import write_whole
from asddpg.planning.occupancy_grid import FloatArray
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.outlines import Outline

Colour = tuple[int, int, int]
Point = tuple[float, float]

WALL, BLACK = (70, 74, 80), (20, 20, 20)
_SIDE, _MARGIN = 1200, 0.3  # px of the longer side, and m around the room
_SMOOTH = 3  # drawn so many times as large: PIL draws without smooth edges


class RoomPicture:
    """A picture of a room; what is drawn later covers what was before."""

    def __init__(self, room: Obstacles) -> None:
        """Begin with the empty floor of a room."""
        low, high = np.array(room.low) - _MARGIN, np.array(room.high) + _MARGIN
        width, height = (high - low).tolist()
        self._scale = _SIDE * _SMOOTH / max(width, height)  # px a metre
        self._strip = _SIDE * _SMOOTH * 0.045  # px, of the title above and of the legend below
        self._left, self._top = low[0], high[1] + self._strip / self._scale
        size = max(round(width * self._scale), _SIDE), round(height * self._scale + 2.0 * self._strip)
        self._image = Image.new("RGB", size, "white")
        self._draw = ImageDraw.Draw(self._image)
        self._legend: list[tuple[str, Colour, bool]] = []  # text, colour, and whether its line is dashed

    def draw_outlines(self, outlines: Iterable[Outline], colour: Colour = WALL, edge: Colour | None = None) -> None:
        """Draw obstacles."""
        for outline in outlines:
            self._draw.polygon(self._pixels(outline), fill=colour, outline=edge)

    def fill_cells(self, centres: FloatArray, side: float, colour: Colour) -> None:
        """Colour squares of a side, metres, about places, (n, 2)."""
        for x, y in centres.tolist():
            (corner, opposite) = self._pixels([(x - side / 2, y + side / 2), (x + side / 2, y - side / 2)])
            self._draw.rectangle((*corner, *opposite), fill=colour)

    def draw_line(self, points: Sequence[Point] | FloatArray, colour: Colour, width: float) -> None:
        """Draw a line through points, its width in metres."""
        self._draw.line(self._pixels(points), fill=colour, width=max(1, round(width * self._scale)), joint="curve")

    def draw_circle(self, place: Point, radius: float, colour: Colour, is_filled: bool = False, text: str = "") -> None:
        """Draw a circle, its radius in metres, with a text inside."""
        ((x, y),), size = self._pixels([place]), radius * self._scale
        width = max(2, round(0.04 * self._scale))
        box = (x - size, y - size, x + size, y + size)
        self._draw.ellipse(box, outline=colour, width=width, fill=colour if is_filled else None)
        self._draw.text((x, y), text, fill=colour, anchor="mm", font=ImageFont.load_default(max(1.0, 1.2 * size)))

    def draw_cross(self, place: Point, colour: Colour) -> None:
        """Draw a cross of 0.4 m."""
        x, y = place
        for sign in (-1.0, 1.0):
            self.draw_line([(x - 0.2, y - 0.2 * sign), (x + 0.2, y + 0.2 * sign)], colour, 0.08)

    def add_legend(self, text: str, colour: Colour, is_dashed: bool = False) -> None:
        """Add an entry to the legend."""
        self._legend.append((text, colour, is_dashed))

    def write(self, path: Path, title: str) -> None:
        """Write a PNG with a title above and the legend below."""
        self._write_strips(title)
        size = [max(1, round(side / _SMOOTH)) for side in self._image.size]
        content = io.BytesIO()
        self._image.resize((size[0], size[1]), Image.Resampling.LANCZOS).save(content, "PNG", optimize=True)
        write_whole(path, content.getbuffer())

    def _pixels(self, points: Sequence[Point] | FloatArray) -> list[tuple[float, float]]:
        return [((x - self._left) * self._scale, (self._top - y) * self._scale) for x, y in points]

    def _write_strips(self, title: str) -> None:
        size = self._strip * 0.45
        font = ImageFont.load_default(size)
        x, y = size, self._image.height - self._strip / 2
        self._draw.text((x, self._strip / 2), title, fill=BLACK, anchor="lm", font=font)
        for text, colour, is_dashed in self._legend:
            pieces = ((0.0, 0.4), (0.6, 1.0)) if is_dashed else ((0.0, 1.0),)
            thickness = size / 8 if is_dashed else size / 3
            for begin, end in pieces:
                self._draw.rectangle((x + begin * size, y - thickness, x + end * size, y + thickness), fill=colour)
            self._draw.text((x + 1.3 * size, y), text, fill=BLACK, anchor="lm", font=font)
            x += 2.3 * size + self._draw.textlength(text, font)
