"""Draws an episode's signals over time, a panel for each kind."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from asddpg.recording.messages.path_message import DRIVER_COLOURS, OTHER_COLOUR
from tasks.physics import FloatArray
from tools.drawing.plot_style import ACTOR, CONTROLLER, FOURTH, SWITCHED, THIRD, Sheet
from tools.recordings.episode_signals import Signals

PANEL = (9.5, 1.75)  # inches
_COLOURS = (ACTOR.colour, CONTROLLER.colour, SWITCHED.colour, THIRD.colour, FOURTH.colour)
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
    names = dict.fromkeys(signals.drivers)
    patches = [Patch(facecolor=_driver_colour(name), alpha=0.25, label=f"driven by the {name}") for name in names]
    sheet.figure.legend(handles=patches, loc="outside lower center", ncols=len(patches), frameon=False)
    sheet.figure.align_ylabels(sheet.axes)
    sheet.save(file)


def _panels(signals: Signals) -> dict[str, Drawing]:
    """By the labels of their axes; without those of which the recording holds nothing."""
    panels: dict[str, Drawing] = {"v (m/s)": _speed("v", 0), "ω (rad/s)": _speed("omega", 1)}
    if "distance" in signals.by_name:
        panels["distance (m)"] = _distance
    if {"q_policy", "q_controller", "value"} & set(signals.by_name):
        panels["value"] = _values
    panels["reward"] = _rewards
    if {"noise_v", "noise_omega"} & set(signals.by_name):
        panels["noise\n(m/s, rad/s)"] = _noise
    return panels


def _shade_drivers(axes: Axes, signals: Signals) -> None:
    begun = 0
    for index, driver in enumerate([*signals.drivers, ""]):
        if index and driver != signals.drivers[index - 1]:
            colour = _driver_colour(signals.drivers[index - 1])
            axes.axvspan(signals.ends[begun], signals.ends[index], color=colour, alpha=0.15, linewidth=0, zorder=0)
            begun = index


def _driver_colour(name: str) -> tuple[float, float, float]:
    return DRIVER_COLOURS.get(name, OTHER_COLOUR)


def _held(axes: Axes, signals: Signals, values: FloatArray, colour: str, label: str, width: float = 1.6) -> None:
    """What is one value for a whole step."""
    axes.stairs(values, signals.ends, baseline=None, color=colour, label=label, linewidth=width)


def _speed(name: str, column: int) -> Drawing:
    def draw(axes: Axes, signals: Signals) -> None:
        _held(axes, signals, signals.by_name[name], "0.25", "commanded", width=1.2)
        ends = signals.ends[: len(signals.driven)]
        axes.plot(ends, signals.driven[:, column], color=SWITCHED.colour, linewidth=1.8, label="driven")

    return draw


def _distance(axes: Axes, signals: Signals) -> None:
    axes.plot(signals.ends[1:], signals.by_name["distance"], color=FOURTH.colour, label="to the goal")
    axes.set_ylim(bottom=0.0)


def _values(axes: Axes, signals: Signals) -> None:
    lines = {
        "q_policy": ("Q(policy)", ACTOR.colour),
        "q_controller": ("Q(controller)", CONTROLLER.colour),
        "value": ("V", "0.4"),
    }
    for name, (label, colour) in lines.items():
        if name in signals.by_name:
            _held(axes, signals, signals.by_name[name], colour, label)


def _rewards(axes: Axes, signals: Signals) -> None:
    for (name, values), colour in zip(signals.terms.items(), np.resize(_COLOURS[1:], len(signals.terms)), strict=True):
        _held(axes, signals, values, str(colour), name.replace("_", " "))
    axes.set_yscale("symlog", linthresh=0.1)  # reaching and crashing are a hundred times a step's progress


def _noise(axes: Axes, signals: Signals) -> None:
    for name, label, colour in (
        ("noise_v", "on v", THIRD.colour),
        ("noise_omega", "on ω", FOURTH.colour),
    ):
        if name in signals.by_name:
            _held(axes, signals, signals.by_name[name], colour, label)
