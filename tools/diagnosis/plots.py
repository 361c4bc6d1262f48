"""The plots of a diagnosis, each a file; docs/guides/diagnosis.md shows them and says how to read them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from tasks.physics import FloatArray
from tasks.room_geometry.obstacles import Obstacles
from tools.diagnosis.drive_metrics import DriveMetrics, QCalibration
from tools.diagnosis.rollouts import Rollout
from tools.diagnosis.run_diagnosis import Diagnosis
from tools.diagnosis.step_metrics import CELL
from tools.drawing.plot_style import ACTOR, CONTROLLER, FOURTH, QUARTER_COLOURS, SHARES, SWITCHED, THIRD, Sheet, Style
from tools.drawing.room_map import FAILURES, LOOKS, draw_cells, draw_ends, draw_room, legend_under

TRAINING_STEP = "training step (thousands)"
DISTANCES = (0.3, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)  # m, ticks of a logarithmic scale


def draw(diagnosis: Diagnosis, obstacles: Obstacles, by_actor: Sequence[Rollout], folder: Path) -> None:
    """Write all plots into a folder; `by_actor` are the actor's episodes with the last snapshot.

    Without a controller the plot of its share is left out.
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


def _steps(diagnosis: Diagnosis) -> FloatArray:
    """Training steps of the snapshots, thousands."""
    return np.array([snapshot.step / 1000 for snapshot in diagnosis.snapshots])


def _drivers(diagnosis: Diagnosis) -> dict[Style, list[DriveMetrics]]:
    """Metrics of the actor alone and, where there is a switch, of the switched policy, by snapshot."""
    drivers = {ACTOR: [snapshot.actor for snapshot in diagnosis.snapshots]}
    switched = [snapshot.switched for snapshot in diagnosis.snapshots if snapshot.switched is not None]
    return drivers | ({SWITCHED: switched} if switched else {})


def _outcomes(diagnosis: Diagnosis) -> Sheet:
    sheet = Sheet(_title(diagnosis, "Outcomes over training"), columns=3)
    panels = {"success_rate": "reached", "collision_rate": "crashed", "timeout_rate": "timed out"}
    for axes, (field, title) in zip(sheet.axes, panels.items(), strict=True):
        for style, metrics in _drivers(diagnosis).items():
            style.band(axes, _steps(diagnosis), [getattr(each, field) for each in metrics])
        if diagnosis.controller is not None:
            level = getattr(diagnosis.controller, field).value
            axes.axhline(level, color=CONTROLLER.colour, linestyle="--", label=CONTROLLER.name)
        axes.set(title=title, xlabel=TRAINING_STEP, ylim=(-0.02, 1.02))
    sheet.axes[0].set_ylabel("share of episodes")
    sheet.legend_below()
    return sheet


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
    Style("driven in training", "0.45", ".").line(axes, np.array(windows.steps) / 1000, windows.driven, size=3)
    if preferred.steps:
        steps = np.array(preferred.steps) / 1000
        CONTROLLER.named("preferred in training").line(axes, steps, preferred.shares, size=3)
    shares = [metrics.controller_share for metrics in _drivers(diagnosis)[SWITCHED]]
    SWITCHED.named("driven in validation").line(axes, _steps(diagnosis), shares)
    axes.set(title="over training", xlabel=TRAINING_STEP, ylabel="share of the steps")
    _leave_space_above(axes)
    axes.legend(loc="upper center", fontsize="small")


def _preferred_by_distance(axes: Axes, diagnosis: Diagnosis) -> None:
    for part, colour in zip(diagnosis.training.by_distance, QUARTER_COLOURS, strict=True):
        Style(f"quarter {part.quarter}", colour, "o").line(axes, part.distances, part.preferred, size=3)
    axes.set(title="preferred, by distance", xlabel="distance to the goal (m)")
    _leave_space_above(axes)
    axes.legend(title="of training", loc="upper center", ncols=2, fontsize="small", title_fontsize="small")


def _leave_space_above(axes: Axes) -> None:
    """Leave space for a legend above shares, which end at 1."""
    axes.set(ylim=(-0.02, 1.35), yticks=np.linspace(0.0, 1.0, 6))


def _preferred_by_place(sheet: Sheet, axes: Axes, diagnosis: Diagnosis, obstacles: Obstacles) -> None:
    draw_cells(axes, diagnosis.training.by_place, CELL)
    draw_room(axes, obstacles)
    axes.set_title("preferred, by place, last quarter")
    scale = ScalarMappable(Normalize(0.0, 1.0), SHARES)
    sheet.figure.colorbar(scale, ax=axes, shrink=0.8, label="share of the steps")


def _q_values(diagnosis: Diagnosis) -> Sheet:
    columns, last = _q_columns(diagnosis), diagnosis.snapshots[-1]
    sheet = Sheet(_title(diagnosis, "Q against the discounted return that followed"), columns=len(columns), rows=2)
    upper, lower = sheet.axes[: len(columns)], sheet.axes[len(columns) :]
    for above, below, (title, curves) in zip(upper, lower, columns.items(), strict=True):
        for field, style in curves.items():
            bins = getattr(last, field).bins
            style.band(above, [each.q for each in bins], [(each.mean, each.low, each.high) for each in bins])
            found: list[QCalibration] = [getattr(snapshot, field) for snapshot in diagnosis.snapshots]
            style.band(below, _steps(diagnosis), [(each.bias, each.bias_low, each.bias_high) for each in found])
        above.set(title=f"{title}, step {last.step}", xlabel="Q (mean of a tenth of the states)")
        below.axhline(0.0, color="0.6", linewidth=0.8, zorder=0)
        below.set(xlabel=TRAINING_STEP)
    _share_limits(upper, is_square=True)
    _share_limits(lower)
    for above in upper:
        above.axline((0.0, 0.0), slope=1.0, color="0.6", linewidth=0.8, zorder=0, label="Q = return")
        above.legend()
    upper[0].set_ylabel("return: mean, 10–90 % of states")
    lower[0].set_ylabel("mean of Q − return")
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


def _share_limits(panels: Sequence[Axes], is_square: bool = False) -> None:
    """Give all panels the same limits, if square on both axes."""
    limits = [axes.get_ylim() for axes in panels] + ([axes.get_xlim() for axes in panels] if is_square else [])
    lows, highs = zip(*limits, strict=True)
    for axes in panels:
        axes.set_ylim(min(lows), max(highs))
        if is_square:
            axes.set_xlim(min(lows), max(highs))


def _actions(diagnosis: Diagnosis) -> Sheet:
    drivers = _drivers(diagnosis)
    sheet = Sheet(_title(diagnosis, "Actions"), columns=len(drivers))
    fields = {
        "saturated_v": ACTOR.named("v at a bound"),
        "saturated_omega": CONTROLLER.named("ω at a bound"),
        "standing": SWITCHED.named("standing still"),
        "circling": THIRD.named("turning on the spot"),
        "stuck": FOURTH.named("stuck"),
    }
    for axes, (driver, metrics) in zip(sheet.axes, drivers.items(), strict=True):
        for field, style in fields.items():
            style.line(axes, _steps(diagnosis), [getattr(each, field) for each in metrics])
        axes.set(title=driver.name, xlabel=TRAINING_STEP, ylim=(-0.02, 1.02))
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
    failures.set(title="failures over training", xlabel=TRAINING_STEP, ylabel="distance to the goal (m)")
    failures.set_xlim(0.0, 1.03 * diagnosis.snapshots[-1].step / 1000)  # also without failures
    failures.set_yscale("log")
    limits = (0.8 * diagnosis.goal_radius, failures.get_ylim()[1])
    failures.set_yticks(DISTANCES, labels=[f"{distance:g}" for distance in DISTANCES])
    failures.minorticks_off()
    failures.set_ylim(limits)
    legend_under(failures)
    return sheet


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
    errors = {ACTOR.named("samples of the policy"): training.td_policy}
    if diagnosis.controller is not None:
        errors[CONTROLLER.named("samples of the controller")] = training.td_controller
    for style, values in errors.items():
        style.line(axes, np.array(training.steps) / 1000, values)
    axes.set(xlabel=TRAINING_STEP, ylabel=r"mean $|y^A - Q^A|$ in a batch")
    axes.set_ylim(bottom=0.0)
    axes.legend()
    return sheet
