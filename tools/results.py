"""The runs behind the README's figures: `python -m tools.results`, or some of them by name.

Trains what is missing, two runs at a time, and prints the table. Finished runs are kept in runs/results and not trained
again; one that was broken off begins anew.
"""

import csv
import json
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asddpg.errors import UserError
from asddpg.intervals import mean
from asddpg.program import run

FOLDER = Path("runs") / "results"
AT_ONCE = 2
LAST_EPISODES = 200


@dataclass(frozen=True)
class Group:
    """Runs that differ in their seed alone."""

    words: str
    steps: int
    seeds: Sequence[int] = (0, 1, 2)


GROUPS = {
    "empty": Group("task=nav_empty agent=asddpg", 30_000),
    "complex": Group("task=nav_complex agent=asddpg", 100_000),
    "complex_ddpg": Group("task=nav_complex agent=ddpg", 100_000),
    "complex_paper": Group("task=nav_complex agent=asddpg_paper", 100_000),
}
BASELINES = {"controller on nav_empty": "nav_empty", "controller on nav_complex": "nav_complex"}


def folder_of(name: str, seed: int) -> Path:
    """Where a run of a group is kept."""
    return FOLDER / f"{name}_seed{seed}"


def train(name: str, seed: int) -> None:
    """Train one run, unless it is finished."""
    folder, group = folder_of(name, seed), GROUPS[name]
    if (folder / "resources.json").exists():
        return
    if folder.exists():
        shutil.rmtree(folder)
    words = [*group.words.split(), f"total_steps={group.steps}", f"seed={seed}", f"run_dir={folder}"]
    with (FOLDER / f"{folder.name}.log").open("w") as log:
        subprocess.run([sys.executable, "-m", "asddpg.train", *words], check=True, stdout=log, stderr=log)
    print(f"trained {folder}", flush=True)


def figures(name: str, seed: int) -> dict[str, float]:
    """What a finished run gave."""
    folder = folder_of(name, seed)
    with (folder / "metrics.csv").open() as file:
        rows = list(csv.DictReader(file))
    tested = json.loads((folder / "test.json").read_text())
    resources = json.loads((folder / "resources.json").read_text())
    outcomes = [row["outcome"] for row in rows if row["outcome"] != "cut"][-LAST_EPISODES:]
    found = {
        "while training": outcomes.count("reached") / len(outcomes),
        "alone, last": tested["last"]["reach_rate"]["value"],
        "crash, last": tested["last"]["crash_rate"]["value"],
        "alone, best": tested["best"]["reach_rate"]["value"],
        "memory (MB)": resources["peak_memory_mb"],
    }
    return found | _controller_shares(rows, GROUPS[name].steps)


def _controller_shares(rows: list[dict[str, str]], total: int) -> dict[str, float]:
    """Controller's share of the steps in each quarter of training."""
    ends = np.array([int(row["step"]) for row in rows])
    steps = np.array([int(row["steps"]) for row in rows])
    driven = steps * np.array([float(row["controller_share"]) for row in rows])
    quarter = np.minimum((ends - 1) * 4 // total, 3)
    return {f"share {q + 1}/4": float(driven[quarter == q].sum() / steps[quarter == q].sum()) for q in range(4)}


def report(names: Sequence[str]) -> str:
    """Markdown: a row a seed, and a row of means with 95 % intervals over seeds."""
    lines: list[str] = []
    for name in names:
        seeds = [seed for seed in GROUPS[name].seeds if (folder_of(name, seed) / "resources.json").exists()]
        if not seeds:
            continue
        found = [figures(name, seed) for seed in seeds]
        if not lines:
            lines += ["| run | " + " | ".join(found[0]) + " |", "|---" * (len(found[0]) + 1) + "|"]
        lines += [_row(f"{name}, seed {seed}", list(row.values())) for seed, row in zip(seeds, found, strict=True)]
        estimates = [mean([row[column] for row in found]) for column in found[0]]
        cells = [
            f"**{e.value:.3g}** [{e.low:.3g}, {e.high:.3g}]"
            for e in estimates
            if e.value is not None and e.low is not None and e.high is not None
        ]
        lines.append(f"| **{name}, mean** | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _row(title: str, values: Sequence[float]) -> str:
    return f"| {title} | " + " | ".join(f"{value:.3g}" for value in values) + " |"


def evaluate_baselines() -> None:
    """Print what the controller alone does on the stored test sets."""
    for title, task in BASELINES.items():
        words = ["agent=controller", f"task={task}"]
        done = subprocess.run(
            [sys.executable, "-m", "asddpg.evaluate", *words], check=True, capture_output=True, text=True
        )
        print(f"{title}\n{done.stdout}")


def main(words: Sequence[str]) -> None:
    """Train and report."""
    unknown = [word for word in words if word not in GROUPS]
    if unknown:
        raise UserError(f"there is no group {unknown[0]!r}; there are {', '.join(GROUPS)}")
    names = list(words) or list(GROUPS)
    FOLDER.mkdir(parents=True, exist_ok=True)
    jobs = [(name, seed) for name in names for seed in GROUPS[name].seeds]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        list(pool.map(lambda job: train(*job), jobs))
    print(report(names))
    evaluate_baselines()


if __name__ == "__main__":
    run(main, str(__doc__))
