"""Tables of finished runs, in Markdown, with means and 95 % Student intervals over seeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asddpg.episodes.evaluation import cell
from asddpg.episodes.intervals import Estimate, mean
from tools.experiments.markdown import markdown
from tools.experiments.run_groups import Group
from tools.experiments.run_metrics import RunMetrics
from tools.experiments.run_store import FinishedRun

LEGEND = (
    "While training: the last 200 episodes, noise on, the controller as far as its schedule lets it. Controller: its "
    "share of the steps, which the schedule bounds, by quarter of training or in its last 10 %. Switch prefers the "
    "controller: the share of the steps in the last 10 % where it rates the controller above the actor, whoever drove. "
    "In brackets 95 % Student intervals over seeds, of shares cut at 0 and 1."
)


@dataclass(frozen=True)
class Column:
    """How a figure is shown; the interval of a rate or share is cut at 0 and 1, where it ends."""

    title: str
    form: str = "{:.3f}"
    is_share: bool = True

    def cell(self, estimate: Estimate) -> str:
        """A figure with its interval, where it has one."""
        value, low, high = estimate
        if self.is_share and low is not None and high is not None:
            estimate = Estimate(value, max(low, 0.0), min(high, 1.0))
        return cell(estimate, self.form)


COLUMNS = {
    "success_training": Column("reach while training"),
    "success_last": Column("reach alone, last"),
    "collision_last": Column("crash alone, last"),
    "success_best": Column("reach alone, best"),
    "share_1": Column("controller 1/4"),
    "share_2": Column("2/4"),
    "share_3": Column("3/4"),
    "share_4": Column("4/4"),
    "share_end": Column("controller, last 10 %"),
    "switch_prefers": Column("switch prefers the controller"),
    "last_five": Column("last five validations"),
    "best_five": Column("best five validations"),
    "swing": Column("best less last five", is_share=False),
    "steps_per_second": Column("steps/s", "{:.0f}", is_share=False),
    "memory_mb": Column("memory (MB)", "{:.0f}", is_share=False),
}


@dataclass(frozen=True)
class Result:
    """A finished run with its figures."""

    run: FinishedRun
    metrics: RunMetrics

    @property
    def seed(self) -> int:
        """Seed of the run."""
        return int(self.run.settings["seed"])


Results = Mapping[str, Sequence[Result]]


def over_seeds(results: Sequence[Result], figure: str) -> Estimate:
    """Mean of a figure with its interval; of the runs that have it."""
    values = [getattr(result.metrics, figure) for result in results]
    return mean([value for value in values if value is not None])


def runs_table(groups: Mapping[str, Group], results: Results) -> str:
    """A row a run, and below each group its means."""
    rows = []
    for name, group in groups.items():
        found = results[name]
        for result in found:
            cells = [column.cell(Estimate(getattr(result.metrics, key), None, None)) for key, column in COLUMNS.items()]
            rows.append([f"{group.title}, seed {result.seed}", *cells])
        if found:
            title = f"**mean of {len(found)}**{missing_note(group, found)}"
            rows.append([title, *(column.cell(over_seeds(found, key)) for key, column in COLUMNS.items())])
    return markdown(["run", *(column.title for column in COLUMNS.values())], rows)


def missing_note(group: Group, found: Sequence[Result]) -> str:
    """What to add to a row that does not have all its runs yet."""
    return "" if len(found) == len(group.seeds) else f" (of {len(group.seeds)}, unfinished)"
