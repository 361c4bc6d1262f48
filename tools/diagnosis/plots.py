"""The plots of a diagnosis, each a file; docs/guides/diagnosis.md shows them and says how to read them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from tasks.room_geometry.obstacles import Obstacles
from tools.diagnosis.drive_metrics import DriveMetrics, QCalibration
from tools.diagnosis.rollouts import Rollout
from tools.diagnosis.run_diagnosis import Diagnosis, Snapshot
from tools.diagnosis.step_metrics import CELL
from tools.drawing.plot_style import ACTOR, CONTROLLER, FOURTH, QUARTER_COLOURS, SHARES, SWITCHED, THIRD, Sheet, Style
from tools.drawing.room_map import FAILURES, LOOKS, draw_cells, draw_ends, draw_room, legend_under

OptionalValues = Sequence[float | None]

DISTANCES = (0.3, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)  # m, ticks of a logarithmic scale


def draw(diagnosis: Diagnosis, obstacles: Obstacles, by_actor: Sequence[Rollout], folder: Path) -> None:
    """Write all plots into a folder; without a controller those of the controller are left out.

    Args:
        diagnosis: metrics to draw.
        obstacles: obstacles of the room.
        by_actor: the actor's episodes with the last snapshot.
        folder: output folder.
    """
    _outcomes(diagnosis).save(folder / "outcomes.png")
    if diagnosis.controller is not None:
        _controller_share(diagnosis, obstacles).save(folder / "controller_share.png")
    _q_values(diagnosis).save(folder / "q_values.png")
    _actions(diagnosis).save(folder / "actions.png")
    _ends(diagnosis, obstacles, by_actor).save(folder / "ends.png")
    _td_errors(diagnosis).save(folder / "td_errors.png")


def _title(diagnosis: Diagnosis, what: str) -> str:
    return f"{what} · {diagnosis.agent} on {diagnosis.task}, {diagnosis.episodes} validation pairs"


def _steps(diagnosis: Diagnosis) -> list[float]:
    """Training steps of the snapshots, thousands."""
    return [snapshot.step / 1000 for snapshot in diagnosis.snapshots]


def _outcomes(diagnosis: Diagnosis) -> Sheet:
    sheet = Sheet(_title(diagnosis, "Outcomes over training"), columns=3)
    panels = {"success_rate": "reached", "collision_rate": "crashed", "timeout_rate": "timed out"}
    for axes, (field, title) in zip(sheet.axes, panels.items(), strict=True):
        _rates(axes, diagnosis, field)
        axes.set(title=title, xlabel="training step (thousands)", ylim=(-0.02, 1.02))
    sheet.axes[0].set_ylabel("share of episodes")
    sheet.legend_below()
    return sheet


def _rates(axes: Axes, diagnosis: Diagnosis, field: str) -> None:
    steps = _steps(diagnosis)
    actors = [snapshot.actor for snapshot in diagnosis.snapshots]
    switched = [snapshot.switched for snapshot in diagnosis.snapshots if snapshot.switched is not None]
    for style, drivers in ((ACTOR, actors), (SWITCHED, switched)):
        if drivers:
            value, low, high = np.array([getattr(metrics, field) for metrics in drivers], dtype=float).T
            axes.fill_between(steps, low, high, color=style.colour, alpha=0.15, linewidth=0)
            style.line(axes, steps, value)
    if diagnosis.controller is not None:
        CONTROLLER.level(axes, getattr(diagnosis.controller, field).value)


def _controller_share(diagnosis: Diagnosis, obstacles: Obstacles) -> Sheet:
    has_log = bool(diagnosis.training.by_place)
    title = _title(diagnosis, "Controller: steps driven, steps preferred by the switch")
    sheet = Sheet(title, columns=3 if has_log else 1)
    _share_over_training(sheet.axes[0], diagnosis)
    if has_log:
        _preferred_by_distance(sheet.axes[1], diagnosis)
        _preferred_by_place(sheet, sheet.axes[2], diagnosis, obstacles)
    return sheet


def _share_over_training(axes: Axes, diagnosis: Diagnosis) -> None:
    windows, preferred = diagnosis.training.windows, diagnosis.training.preferred
    steps, driven = _thousands(windows.steps), _floats(windows.driven)
    axes.plot(steps, driven, color="0.45", marker=".", ms=3, label="driven in training")
    if preferred.steps:
        steps = _thousands(preferred.steps)
        axes.plot(steps, preferred.shares, color=CONTROLLER.colour, marker="^", ms=3, label="preferred in training")
    shares = [snapshot.switched.controller_share for snapshot in diagnosis.snapshots if snapshot.switched is not None]
    SWITCHED.line(axes, _steps(diagnosis), shares, "driven in validation")
    axes.set(title="over training", xlabel="training step (thousands)", ylabel="share of the steps")
    _leave_room_above(axes)
    axes.legend(loc="upper center", fontsize="small")


def _preferred_by_distance(axes: Axes, diagnosis: Diagnosis) -> None:
    for part, colour in zip(diagnosis.training.by_distance, QUARTER_COLOURS, strict=True):
        axes.plot(part.distances, part.preferred, color=colour, marker="o", ms=3, label=f"quarter {part.quarter}")
    axes.set(title="preferred, by distance", xlabel="distance to the goal (m)")
    _leave_room_above(axes)
    axes.legend(title="of training", loc="upper center", ncols=2, fontsize="small", title_fontsize="small")


def _leave_room_above(axes: Axes) -> None:
    """Leave space for a legend above shares, which end at 1."""
    axes.set(ylim=(-0.02, 1.35), yticks=np.linspace(0.0, 1.0, 6))


def _preferred_by_place(sheet: Sheet, axes: Axes, diagnosis: Diagnosis, obstacles: Obstacles) -> None:
    draw_cells(axes, diagnosis.training.by_place, CELL)
    draw_room(axes, obstacles)
    axes.set_title("preferred, by place, last quarter")
    scale = ScalarMappable(Normalize(0.0, 1.0), SHARES)
    sheet.figure.colorbar(scale, ax=axes, shrink=0.8, label="share of the steps")


def _q_values(diagnosis: Diagnosis) -> Sheet:
    columns = _q_columns(diagnosis)
    sheet = Sheet(_title(diagnosis, "Q against the discounted return that followed"), columns=len(columns), rows=2)
    last = diagnosis.snapshots[-1]
    for column, (title, curves) in enumerate(columns.items()):
        above, below = sheet.axes[column], sheet.axes[len(columns) + column]
        for field, style in curves.items():
            _calibration(above, getattr(last, field), style)
            _bias(below, diagnosis.snapshots, field, style)
        above.set(title=f"{title}, step {last.step}", xlabel="Q (mean of a tenth of the states)")
        below.axhline(0.0, color="0.6", linewidth=0.8, zorder=0)
        below.set(xlabel="training step (thousands)")
    _share_limits(sheet.axes[: len(columns)], is_square=True)
    _share_limits(sheet.axes[len(columns) :])
    for above in sheet.axes[: len(columns)]:
        above.axline((0.0, 0.0), slope=1.0, color="0.6", linewidth=0.8, zorder=0, label="Q = return")
        above.legend()
    sheet.axes[0].set_ylabel("return: mean, 10–90 % of states")
    sheet.axes[len(columns)].set_ylabel("mean of Q − return")
    return sheet


def _q_columns(diagnosis: Diagnosis) -> dict[str, dict[str, Style]]:
    """Panels by title, and in each the QCalibration fields of a snapshot with their styles."""
    actor = {"q_actor": THIRD.named(r"$Q^A(x, \pi(x))$")}
    if diagnosis.controller is None:
        return {"actor alone": actor}
    return {
        "actor alone": {"q_policy": ACTOR.named(r"$Q(x,$ policy$)$"), **actor},
        "switched policy": {"q_switched": SWITCHED.named(r"$Q(x, \sigma$ chosen$)$")},
        "controller alone": {"q_controller": CONTROLLER.named(r"$Q(x,$ controller$)$")},
    }


def _calibration(axes: Axes, calibration: QCalibration, style: Style) -> None:
    q, mean, low, high = np.array([(b.q, b.mean, b.low, b.high) for b in calibration.bins]).reshape(-1, 4).T
    axes.fill_between(q, low, high, color=style.colour, alpha=0.15, linewidth=0)
    style.line(axes, q, mean)


def _share_limits(panels: Sequence[Axes], is_square: bool = False) -> None:
    """Give all panels the same limits, if square on both axes."""
    limits = [axes.get_ylim() for axes in panels] + ([axes.get_xlim() for axes in panels] if is_square else [])
    lows, highs = zip(*limits, strict=True)
    for axes in panels:
        axes.set_ylim(min(lows), max(highs))
        if is_square:
            axes.set_xlim(min(lows), max(highs))


def _bias(axes: Axes, snapshots: Sequence[Snapshot], field: str, style: Style) -> None:
    steps = [snapshot.step / 1000 for snapshot in snapshots]
    found: list[QCalibration] = [getattr(snapshot, field) for snapshot in snapshots]
    low, high = _floats([each.bias_low for each in found]), _floats([each.bias_high for each in found])
    axes.fill_between(steps, low, high, color=style.colour, alpha=0.15, linewidth=0)
    style.line(axes, steps, _floats([each.bias for each in found]))


def _actions(diagnosis: Diagnosis) -> Sheet:
    drivers: dict[str, list[DriveMetrics]] = {"actor alone": [snapshot.actor for snapshot in diagnosis.snapshots]}
    switched = [snapshot.switched for snapshot in diagnosis.snapshots if snapshot.switched is not None]
    if switched:
        drivers["switched policy"] = switched
    sheet = Sheet(_title(diagnosis, "Actions"), columns=len(drivers))
    fields = {
        "saturated_v": ACTOR.named("v at a bound"),
        "saturated_omega": CONTROLLER.named("ω at a bound"),
        "standing": SWITCHED.named("standing still"),
        "circling": THIRD.named("turning on the spot"),
        "stuck": FOURTH.named("stuck"),
    }
    for axes, (title, metrics) in zip(sheet.axes, drivers.items(), strict=True):
        for field, style in fields.items():
            style.line(axes, _steps(diagnosis), _floats([getattr(each, field) for each in metrics]))
        axes.set(title=title, xlabel="training step (thousands)", ylim=(-0.02, 1.02))
    sheet.axes[0].set_ylabel("share of steps")
    sheet.legend_below()
    return sheet


def _ends(diagnosis: Diagnosis, obstacles: Obstacles, by_actor: Sequence[Rollout]) -> Sheet:
    sheet = Sheet(_title(diagnosis, "Where episodes of the actor alone end"), columns=2, panel=(4.8, 4.8))
    room, failures = sheet.axes
    draw_room(room, obstacles)
    draw_ends(room, by_actor)
    room.set_title(f"step {diagnosis.snapshots[-1].step}")
    for outcome in FAILURES:
        _failures(failures, diagnosis, outcome)
    failures.axhline(diagnosis.goal_radius, color="0.6", linewidth=0.8, zorder=0, label="goal radius")
    failures.set(title="failures over training", xlabel="training step (thousands)", ylabel="distance to the goal (m)")
    failures.set_xlim(0.0, 1.03 * diagnosis.snapshots[-1].step / 1000)  # also without failures
    _near_and_far(failures, diagnosis.goal_radius)
    legend_under(failures)
    return sheet


def _near_and_far(axes: Axes, least: float) -> None:
    """A logarithmic scale of distances from `least` on, metres."""
    axes.set_yscale("log")
    limits = (0.8 * least, axes.get_ylim()[1])
    axes.set_yticks(DISTANCES, labels=[f"{distance:g}" for distance in DISTANCES])
    axes.minorticks_off()
    axes.set_ylim(limits)


def _failures(axes: Axes, diagnosis: Diagnosis, outcome: str) -> None:
    """Distance to the goal at the end of the actor's episodes of an outcome, by snapshot."""
    found = [
        (each.step / 1000, end.distance)
        for each in diagnosis.snapshots
        for end in each.actor.ends
        if end.outcome == outcome
    ]
    name, colour, marker, size = LOOKS[outcome]
    steps, distances = np.array(found).reshape(-1, 2).T
    axes.scatter(steps, distances, s=size / 2, marker=marker, color=colour, alpha=0.6, linewidths=0.0, label=name)


def _td_errors(diagnosis: Diagnosis) -> Sheet:
    training = diagnosis.training.windows
    sheet = Sheet(f"TD errors · {diagnosis.agent} on {diagnosis.task}", columns=1, panel=(6.8, 3.6))
    (axes,) = sheet.axes
    steps = _thousands(training.steps)
    ACTOR.named("samples of the policy").line(axes, steps, _floats(training.td_policy))
    if diagnosis.controller is not None:
        CONTROLLER.named("samples of the controller").line(axes, steps, _floats(training.td_controller))
    axes.set(xlabel="training step (thousands)", ylabel=r"mean $|y^A - Q^A|$ in a batch")
    axes.set_ylim(bottom=0.0)
    axes.legend()
    return sheet


def _thousands(steps: Sequence[float]) -> list[float]:
    return [step / 1000 for step in steps]


def _floats(values: OptionalValues) -> list[float]:
    """None becomes NaN, which is not drawn."""
    return [float("nan") if value is None else value for value in values]
