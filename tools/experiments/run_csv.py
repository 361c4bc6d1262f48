"""Runs as CSV, a row a run: written beside a table, and read where such a file is published in docs/runs.

So a table is drawn, and a new group measured against the others, without training again what others have trained.
"""

import csv
import io
import math
import shlex
from collections.abc import Mapping
from pathlib import Path

from asddpg.atomic_write import write_whole
from asddpg.errors import UserError
from tools.experiments.run_metrics import METRICS
from tools.experiments.run_store import FinishedRun, Results
from tools.experiments.runs import DIGITS, Group

PUBLISHED = Path(__file__).resolve().parents[2] / "docs" / "runs"
PROVENANCE = ("asddpg", "model_hash")
COLUMNS = ("group", "seed", *METRICS, *PROVENANCE, "folder", "arguments", "digest")


def write_csv(path: Path, groups: Mapping[str, Group], results: Results) -> None:
    """A row a run and group; a cell is empty where there was nothing to measure."""
    file = io.StringIO(newline="")
    writer = csv.writer(file)
    writer.writerow(COLUMNS)
    for name, group in groups.items():
        for seed, found in results[name].items():
            run = group.run(seed)
            provenance = [found.provenance.get(key, "") for key in PROVENANCE]
            metrics = [found.metrics[key] for key in METRICS]
            arguments = shlex.join(run.arguments)
            writer.writerow([name, seed, *metrics, *provenance, found.folder, arguments, run.digest])
    write_whole(path, file.getvalue().encode())


def read_csv(path: Path) -> dict[str, FinishedRun]:
    """Published runs by digest.

    Raises:
        UserError: there is no such file, or it is damaged.
    """
    if not path.is_file():
        raise UserError(f"there is no {path} with published runs; without `published` all runs are trained")
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, strict=True)
            if tuple(reader.fieldnames or ()) != COLUMNS:
                raise ValueError(f"its columns are not {', '.join(COLUMNS)}")
            return {row["digest"]: _read_row(row) for row in reader}
    except (ValueError, csv.Error) as error:
        raise UserError(f"{path} is not a whole table.csv as these programs write it: {error}") from error


def _read_row(row: Mapping[str, str]) -> FinishedRun:
    """ValueError where it is damaged."""
    if len(row["digest"] or "") != DIGITS:  # the last column: a row that is cut short lacks it
        raise ValueError(f"the row of {row['group']}, seed {row['seed']}, is cut short")
    metrics = {name: float(row[name]) if row[name] else None for name in METRICS}
    if not all(math.isfinite(value) for value in metrics.values() if value is not None):
        raise ValueError(f"a metric of {row['group']}, seed {row['seed']}, is not finite")
    return FinishedRun(metrics, {name: row[name] for name in PROVENANCE if row[name]}, row["folder"])
