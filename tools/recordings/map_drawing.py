"""Draws the ways of episodes on a picture of their room."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke

from asddpg.recording.messages.path_message import DRIVER_COLOURS, OTHER_COLOUR
from tasks.graphics.rendering import Picture
from tools.drawing.map_view import MapView
from tools.drawing.plot_style import DPI, Sheet
from tools.drawing.room_map import LOOKS
from tools.recordings.episode_paths import Way

GREEN = "#007A3D"
_CASING = [withStroke(linewidth=4.5, foreground="white")]
_ENDS = {**LOOKS, "reached": ("reached", GREEN, "o", 30)}  # not in the blue of the policy's way
_OTHER_END = ("cut off", "#555555", "D", 45)


def draw_map(ways: Sequence[Way], view: MapView, picture: Picture, task: str, file: Path) -> None:
    """Write the map, PNG.

    Args:
        ways: what was driven.
        view: which part of the floor the picture shows.
        picture: of the room, from above.
        task: its name.
        file: where to.
    """
    longer = max(picture.shape[:2]) / DPI
    size = (longer * view.width / max(view.width, view.height), longer * view.height / max(view.width, view.height))
    sheet = Sheet(_title(ways, task), columns=1, panel=(size[0] + 0.8, size[1] + 1.3))
    (axes,) = sheet.axes
    axes.grid(visible=False)
    axes.imshow(picture, extent=view.extent, interpolation="bilinear", zorder=0)
    for way in ways:
        _draw_goal(axes, way)
        for driver, places in way.stretches():
            colour = DRIVER_COLOURS.get(driver, OTHER_COLOUR)
            axes.plot(*places.T, color=colour, linewidth=2.4, path_effects=_CASING, zorder=3, solid_capstyle="round")
    for way in ways:
        _draw_ends(axes, way)
        if len(ways) > 1:
            _numbered(axes, way)
    left, right, bottom, top = view.extent
    axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    _explain(axes, ways)
    names = axes.get_legend_handles_labels()
    sheet.figure.legend(*names, loc="outside lower center", ncols=3, frameon=False, handletextpad=0.5)
    sheet.save(file)


def _title(ways: Sequence[Way], task: str) -> str:
    if len(ways) == 1:
        (way,) = ways
        return f"{task}, episode {way.number}: {way.outcome} after {way.seconds:.1f} s, {way.length():.1f} m driven"
    return f"{task}, {len(ways)} episodes"


def _draw_goal(axes: Axes, way: Way) -> None:
    circle = Circle(
        way.goal, way.goal_radius, facecolor=(0.15, 0.7, 0.3, 0.35), edgecolor=GREEN, linewidth=1.5, zorder=2
    )
    axes.add_patch(circle)


def _numbered(axes: Axes, way: Way) -> None:
    """The episode's number at its goal, and where it ended short of it: many begin at the same place."""
    text: dict[str, Any] = {
        "fontsize": 10,
        "path_effects": [withStroke(linewidth=2.5, foreground="white")],
        "zorder": 7,
    }
    axes.text(*way.goal, str(way.number), ha="center", va="center", **text)
    if way.outcome != "reached":
        axes.annotate(str(way.number), way.places[-1].tolist(), (7, 5), textcoords="offset points", **text)


def _draw_ends(axes: Axes, way: Way) -> None:
    x, y = way.places[0]
    ahead = (x + 0.3 * math.cos(way.yaw), y + 0.3 * math.sin(way.yaw))
    axes.annotate("", ahead, (x, y), arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.5}, zorder=4)
    axes.scatter(x, y, s=45, marker="o", color="white", edgecolors="black", linewidths=1.5, zorder=5)
    _, colour, marker, size = _ENDS.get(way.outcome, _OTHER_END)
    end_x, end_y = way.places[-1]
    axes.scatter(end_x, end_y, s=size + 30, marker=marker, color=colour, edgecolors="white", linewidths=1, zorder=6)


def _explain(axes: Axes, ways: Sequence[Way]) -> None:
    """What is what, under the map: only what is on it."""
    drivers = {driver for way in ways for driver in way.drivers}
    for driver in sorted(drivers, key=[*DRIVER_COLOURS, *drivers].index):
        axes.plot(
            [], [], color=DRIVER_COLOURS.get(driver, OTHER_COLOUR), linewidth=2.4, label=f"driven by the {driver}"
        )
    numbers = " (number: episode)" if len(ways) > 1 else ""
    axes.scatter([], [], s=45, marker="o", color="white", edgecolors="black", linewidths=1.5, label="start")
    axes.scatter(
        [],
        [],
        s=110,
        marker="o",
        color=(0.15, 0.7, 0.3, 0.35),
        edgecolors=GREEN,
        linewidths=1.5,
        label=f"goal{numbers}",
    )
    for outcome in dict.fromkeys(way.outcome for way in ways):
        name, colour, marker, size = _ENDS.get(outcome, _OTHER_END)
        count = f": {sum(way.outcome == outcome for way in ways)}" if len(ways) > 1 else ""
        axes.scatter([], [], s=size + 30, marker=marker, color=colour, edgecolors="white", label=f"{name}{count}")
