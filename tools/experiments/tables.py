"""Tables of finished runs, in Markdown, with means and 95 % Student intervals over seeds."""

from collections.abc import Iterable, Mapping, Sequence

from asddpg.episodes.intervals import Estimate, mean
from tools.experiments.run_metrics import METRICS
from tools.experiments.run_store import FinishedRun, Results
from tools.experiments.runs import Group, current_scene

LEGEND = (
    "Success rate and collision rate: the actor alone on the stored test pairs, weights of the last or the best "
    "checkpoint. While training: the last 200 episodes, noise on, the controller as far as its schedule lets it. "
    "Controller: its share of the steps, which the schedule bounds, by quarter of training or in its last 10 %. Switch "
    "prefers the controller: the share of the steps in the last 10 % where it rates the controller above the actor, "
    "whichever drove. In brackets 95 % Student intervals over seeds, of shares cut at 0 and 1."
)


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of a header and rows of cells."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)


def value_cell(name: str, run: FinishedRun) -> str:
    """A metric of one run."""
    return METRICS[name].cell(Estimate(run.metrics[name], None, None))


def mean_cell(name: str, runs: Iterable[FinishedRun]) -> str:
    """Mean of a metric with its interval, of the runs that have it."""
    return METRICS[name].cell(mean([value for run in runs if (value := run.metrics[name]) is not None]))


def runs_table(groups: Mapping[str, Group], results: Results) -> str:
    """A row a run, and below each group its means."""
    rows = []
    for name, group in groups.items():
        runs = results[name]
        for seed, run in runs.items():
            rows.append([f"{group.title}, seed {seed}", *(value_cell(metric, run) for metric in METRICS)])
        if runs:
            title = f"**mean of {len(runs)}**{missing_note(group, len(runs))}"
            rows.append([title, *(mean_cell(metric, runs.values()) for metric in METRICS)])
    return markdown(["run", *(metric.title for metric in METRICS.values())], rows)


def missing_note(group: Group, count: int) -> str:
    """What to add to a row that does not have all its runs yet."""
    return "" if count == len(group.seeds) else f" (of {len(group.seeds)}, unfinished)"


def describe_provenance(groups: Mapping[str, Group], results: Results) -> str:
    """What the runs of a table were made with, and a warning where a scene is not today's; nothing without runs."""
    packages: set[str] = set()
    scenes: dict[tuple[str, str], set[str]] = {}  # hashes by title and the hash of today
    for name, group in groups.items():
        task, laser = group.config.task.name, group.config.task.laser
        for run in results[name].values():
            packages.add(run.provenance.get("asddpg", "unknown"))
            scene = (f"{task} with {laser.num_beams} beams", current_scene(task, laser.ring))
            scenes.setdefault(scene, set()).add(run.provenance.get("model_hash", "unknown"))
    if not scenes:
        return ""
    hashes = "; ".join(f"{title} {', '.join(sorted(found))}" for (title, _), found in scenes.items())
    text = f"Trained with asddpg {', '.join(sorted(packages))}; scene {hashes}."
    changed = "; ".join(f"{title} is {today}" for (title, today), found in scenes.items() if found != {today})
    return f"{text} Not all runs are of today's scene: {changed} now." if changed else text
