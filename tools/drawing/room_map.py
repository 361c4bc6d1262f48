"""Map of a room: obstacles, the switch's choices by cell, and the ends of episodes."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle

from tasks.room_geometry.obstacles import Obstacles
from tools.diagnosis.rollouts import Rollout
from tools.diagnosis.step_metrics import Cell
from tools.drawing.plot_style import ACTOR, CONTROLLER, SHARES

MARGIN = 0.15  # m of wall to see around the room

# Outcome → label, colour, marker and size.
LOOKS = {
    "reached": ("reached", ACTOR.colour, "o", 18),
    "crashed": ("crashed", CONTROLLER.colour, "X", 70),
    "timeout": ("timed out", "#000000", "s", 40),
}
FAILURES = ("crashed", "timeout")


def draw_room(axes: Axes, obstacles: Obstacles) -> None:
    """Draw the obstacles, metres, world frame."""
    for outline in obstacles.outlines:
        axes.add_patch(Polygon(outline, closed=True, facecolor="0.35", edgecolor="0.35", linewidth=0.8, zorder=2))
    (left, bottom), (right, top) = obstacles.low, obstacles.high
    axes.set(xlim=(left - MARGIN, right + MARGIN), ylim=(bottom - MARGIN, top + MARGIN), xlabel="x (m)", ylabel="y (m)")
    axes.set_aspect("equal")


def draw_cells(axes: Axes, cells: Sequence[Cell], width: float) -> None:
    """Colour squares of the floor by the share of steps in which the switch preferred the controller."""
    for cell in cells:
        corner = (cell.x - width / 2, cell.y - width / 2)
        axes.add_patch(Rectangle(corner, width, width, facecolor=SHARES(cell.preferred), edgecolor="none", zorder=1))


def draw_ends(axes: Axes, rollouts: Sequence[Rollout]) -> None:
    """Mark the ends of episodes; of failed ones also path and goal."""
    for outcome, (name, colour, marker, size) in LOOKS.items():
        chosen = [rollout for rollout in rollouts if rollout.outcome == outcome]
        if outcome in FAILURES:
            _draw_paths(axes, chosen, colour)
        x, y = np.array([rollout.places[-1] for rollout in chosen]).reshape(-1, 2).T
        label = f"{name}: {len(chosen)}"
        axes.scatter(
            x, y, s=size, marker=marker, color=colour, edgecolors="white", linewidths=0.6, zorder=5, label=label
        )
    axes.scatter([], [], s=60, marker="*", facecolors="none", edgecolors="0.3", label="goal missed")
    legend_under(axes)


def legend_under(axes: Axes) -> None:
    """Put the legend below the axes."""
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2, frameon=False, handletextpad=0.3)


def _draw_paths(axes: Axes, rollouts: Sequence[Rollout], colour: str) -> None:
    for rollout in rollouts:
        axes.plot(*rollout.places.T, color=colour, linewidth=0.8, alpha=0.6, zorder=3)
        # Dotted from the end to the goal.
        axes.plot(*zip(rollout.places[-1], rollout.goal, strict=True), color=colour, linewidth=0.8, ls=":", zorder=3)
        axes.scatter(*rollout.goal, s=60, marker="*", facecolors="none", edgecolors=colour, zorder=4)
