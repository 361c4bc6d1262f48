"""Draws an episode's signals over time, a panel for each kind."""

import functools
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from asddpg.recording.messages.path_message import DRIVER_COLOURS, OTHER_COLOUR
from tools.drawing.plot_style import ACTOR, CONTROLLER, FOURTH, SWITCHED, THIRD, Sheet
from tools.recordings.driven_paths import driver_runs
from tools.recordings.episode_signals import Signals

PANEL = (9.5, 1.75)  # inches
_COLOURS = (CONTROLLER.colour, SWITCHED.colour, THIRD.colour, FOURTH.colour)
_VALUES = {
    "q_policy": ("Q(policy)", ACTOR.colour),
    "q_controller": ("Q(controller)", CONTROLLER.colour),
    "value": ("V", "0.4"),
}
_NOISE = {"noise_v": ("on v", THIRD.colour), "noise_omega": ("on ω", FOURTH.colour)}
Drawing = Callable[[Axes, Signals], None]


def draw_signals(signals: Signals, file: Path) -> None:
    """Write the plot, PNG."""
    panels = _panels(signals)
    sheet = Sheet(signals.title, columns=1, rows=len(panels), panel=PANEL)
    for axes, (label, drawing) in zip(sheet.axes, panels.items(), strict=True):
        _shade_drivers(axes, signals)
        drawing(axes, signals)
        axes.set(ylabel=label, xlim=(0.0, signals.ends[-1]))
        axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), frameon=False, fontsize=9, handlelength=1.5)
        axes.tick_params(labelbottom=axes is sheet.axes[-1])
    sheet.axes[-1].set_xlabel("simulated time (s)")
    patches = [
        Patch(facecolor=DRIVER_COLOURS.get(name, OTHER_COLOUR), alpha=0.25, label=f"driven by the {name}")
        for name in dict.fromkeys(signals.drivers)
    ]
    sheet.figure.legend(handles=patches, loc="outside lower center", ncols=len(patches), frameon=False)
    sheet.figure.align_ylabels(sheet.axes)
    sheet.save(file)


def _panels(signals: Signals) -> dict[str, Drawing]:
    """By the labels of their axes; without those of which the recording holds nothing."""
    panels: dict[str, Drawing] = {"v (m/s)": _speed("v", 0), "ω (rad/s)": _speed("omega", 1)}
    if "distance" in signals.by_name:
        panels["distance (m)"] = _distance
    if _VALUES.keys() & signals.by_name:
        panels["value"] = functools.partial(_draw_stairs, lines=_VALUES)
    panels["reward"] = _rewards
    if _NOISE.keys() & signals.by_name:
        panels["noise\n(m/s, rad/s)"] = functools.partial(_draw_stairs, lines=_NOISE)
    return panels


def _shade_drivers(axes: Axes, signals: Signals) -> None:
    for driver, begin, end in driver_runs(signals.drivers):
        colour = DRIVER_COLOURS.get(driver, OTHER_COLOUR)
        axes.axvspan(signals.ends[begin], signals.ends[end], color=colour, alpha=0.15, linewidth=0, zorder=0)


def _draw_stairs(axes: Axes, signals: Signals, lines: Mapping[str, tuple[str, str]]) -> None:
    """Draw signals that hold one value for a whole step, as far as they are there: label and colour by name."""
    for name, (label, colour) in lines.items():
        if name in signals.by_name:
            axes.stairs(signals.by_name[name], signals.ends, baseline=None, color=colour, label=label, linewidth=1.6)


def _speed(name: str, column: int) -> Drawing:
    def draw(axes: Axes, signals: Signals) -> None:
        _draw_stairs(axes, signals, {name: ("commanded", "0.25")})
        ends = signals.ends[: len(signals.driven)]
        axes.plot(ends, signals.driven[:, column], color=SWITCHED.colour, linewidth=1.8, label="driven")

    return draw


def _distance(axes: Axes, signals: Signals) -> None:
    axes.plot(signals.ends[1:], signals.by_name["distance"], color=FOURTH.colour, label="to the goal")
    axes.set_ylim(bottom=0.0)


def _rewards(axes: Axes, signals: Signals) -> None:
    for (name, values), colour in zip(signals.terms.items(), np.resize(_COLOURS, len(signals.terms)), strict=True):
        label = name.replace("_", " ")
        axes.stairs(values, signals.ends, baseline=None, color=str(colour), label=label, linewidth=1.6)
    axes.set_yscale("symlog", linthresh=0.1)  # reaching and crashing are a hundred times a step's progress
