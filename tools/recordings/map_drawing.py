"""Draws the paths of episodes on a picture of their room."""

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
from tools.recordings.driven_paths import DrivenPath

GREEN = "#007A3D"
_GOAL_FILL = (0.15, 0.7, 0.3, 0.35)
_CASING = [withStroke(linewidth=4.5, foreground="white")]
_START: dict[str, Any] = {"s": 45, "marker": "o", "color": "white", "edgecolors": "black", "linewidths": 1.5}
_ENDS = {**LOOKS, "reached": ("reached", GREEN, "o", 30)}  # not in the blue of the policy's path
_OTHER_END = ("cut off", "#555555", "D", 45)


def draw_map(paths: Sequence[DrivenPath], view: MapView, picture: Picture, task: str, file: Path) -> None:
    """Write the map, PNG.

    Args:
        paths: of the episodes.
        view: which part of the floor the picture shows.
        picture: of the room, from above.
        task: its name.
        file: where to.
    """
    scale = max(picture.shape[:2]) / DPI / max(view.width, view.height)  # inches a metre
    sheet = Sheet(_title(paths, task), columns=1, panel=(view.width * scale + 0.8, view.height * scale + 1.3))
    (axes,) = sheet.axes
    axes.grid(visible=False)
    axes.imshow(picture, extent=view.extent, interpolation="bilinear", zorder=0)
    for path in paths:
        axes.add_patch(Circle(path.goal, path.goal_radius, fc=_GOAL_FILL, ec=GREEN, linewidth=1.5, zorder=2))
        for driver, places in path.stretches():
            colour = DRIVER_COLOURS.get(driver, OTHER_COLOUR)
            axes.plot(*places.T, color=colour, linewidth=2.4, path_effects=_CASING, zorder=3, solid_capstyle="round")
    for path in paths:
        _draw_ends(axes, path)
        if len(paths) > 1:
            _draw_number(axes, path)
    left, right, bottom, top = view.extent
    axes.set(xlim=(left, right), ylim=(bottom, top), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    _label(axes, paths)
    names = axes.get_legend_handles_labels()
    sheet.figure.legend(*names, loc="outside lower center", ncols=3, frameon=False, handletextpad=0.5)
    sheet.save(file)


def _title(paths: Sequence[DrivenPath], task: str) -> str:
    if len(paths) > 1:
        return f"{task}, {len(paths)} episodes"
    (path,) = paths
    return f"{task}, episode {path.number}: {path.outcome} after {path.seconds:.1f} s, {path.length():.1f} m driven"


def _draw_number(axes: Axes, path: DrivenPath) -> None:
    """The episode's number at its goal, and where it ended short of it: many begin at the same place."""
    halo = [withStroke(linewidth=2.5, foreground="white")]
    text: dict[str, Any] = {"fontsize": 10, "path_effects": halo, "zorder": 7}
    axes.text(*path.goal, str(path.number), ha="center", va="center", **text)
    if path.outcome != "reached":
        axes.annotate(str(path.number), path.places[-1].tolist(), (7, 5), textcoords="offset points", **text)


def _draw_ends(axes: Axes, path: DrivenPath) -> None:
    x, y = path.places[0]
    ahead = (x + 0.3 * math.cos(path.yaw), y + 0.3 * math.sin(path.yaw))
    axes.annotate("", ahead, (x, y), arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.5}, zorder=4)
    axes.scatter(x, y, zorder=5, **_START)
    _, colour, marker, size = _ENDS.get(path.outcome, _OTHER_END)
    end_x, end_y = path.places[-1]
    axes.scatter(end_x, end_y, s=size + 30, marker=marker, color=colour, edgecolors="white", linewidths=1, zorder=6)


def _label(axes: Axes, paths: Sequence[DrivenPath]) -> None:
    """Entries of the legend, for what is on the map."""
    drivers = {driver for path in paths for driver in path.drivers}
    for driver in sorted(drivers, key=[*DRIVER_COLOURS, *drivers].index):
        line: dict[str, Any] = {"color": DRIVER_COLOURS.get(driver, OTHER_COLOUR), "linewidth": 2.4}
        axes.plot([], [], label=f"driven by the {driver}", **line)
    axes.scatter([], [], label="start", **_START)
    goal = "goal (number: episode)" if len(paths) > 1 else "goal"
    axes.scatter([], [], label=goal, **{**_START, "s": 110, "color": _GOAL_FILL, "edgecolors": GREEN})
    for outcome in dict.fromkeys(path.outcome for path in paths):
        name, colour, marker, size = _ENDS.get(outcome, _OTHER_END)
        count = f": {sum(path.outcome == outcome for path in paths)}" if len(paths) > 1 else ""
        axes.scatter([], [], s=size + 30, marker=marker, color=colour, edgecolors="white", label=f"{name}{count}")
