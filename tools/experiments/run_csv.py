"""Figures of runs as CSV, a row a run: written beside a table, and read where such a file is published in docs/runs.

So a table is drawn, and a new row measured against the others, without training again what others have trained.
"""

import csv
import dataclasses
import hashlib
import json
import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from asddpg.errors import UserError
from tools.experiments.run_groups import Group, settings_of
from tools.experiments.run_metrics import RunMetrics
from tools.experiments.run_store import Settings
from tools.experiments.run_tables import Results

PUBLISHED = Path(__file__).resolve().parents[2] / "docs" / "runs"
FIGURES = tuple(field.name for field in dataclasses.fields(RunMetrics))
MADE_WITH = ("asddpg", "model_hash")
DIGEST = "options_digest"
DIGITS = 16  # of a digest
COLUMNS = ("group", "seed", *FIGURES, *MADE_WITH, "folder", "arguments", DIGEST)


@dataclass(frozen=True)
class PublishedRun:
    """A finished run that lies elsewhere, or nowhere any more; `place` is where it lay."""

    settings: Settings
    provenance: Mapping[str, str]
    metrics: RunMetrics
    place: str


@dataclass(frozen=True)
class _Row:
    metrics: RunMetrics
    provenance: Mapping[str, str]
    place: str
    arguments: tuple[str, ...]


def write_csv(path: Path, groups: Mapping[str, Group], results: Results) -> None:
    """A row a run and group; empty where there was nothing to measure."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for name, found in results.items():
            for result in found:
                metrics = dataclasses.astuple(result.metrics)
                made = [result.run.provenance.get(key, "") for key in MADE_WITH]
                arguments = shlex.join((*groups[name].options, f"seed={result.seed}"))
                options = digest(groups[name].settings(result.seed))
                writer.writerow([name, result.seed, *metrics, *made, result.run.place, arguments, options])


def digest(settings: Settings) -> str:
    """Names an experiment by the values of its options; its words alone do not, as defaults change."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:DIGITS]


def published_runs(path: Path, groups: Mapping[str, Group]) -> list[PublishedRun]:
    """The runs of a published file that some groups ask for.

    Raises:
        UserError: there is no file, or it is damaged or of another kind.
    """
    rows = _rows(path)
    all_settings = [group.settings(seed) for group in groups.values() for seed in group.seeds]
    asked = {digest(settings): settings for settings in all_settings}
    return [
        PublishedRun(asked[options], row.provenance, row.metrics, row.place)
        for options, row in rows.items()
        if options in asked
    ]


def outdated(path: Path) -> int:
    """How many published runs were trained with other options than their words give today, and so serve nobody.

    Raises:
        UserError: there is no file, or it is damaged or of another kind.
    """
    return sum(options != _digest_today(row.arguments) for options, row in _rows(path).items())


def _digest_today(arguments: tuple[str, ...]) -> str | None:
    try:
        return digest(settings_of(arguments))
    except UserError:  # an option of then is none of today
        return None


def _rows(path: Path) -> dict[str, _Row]:
    """By digest: a run may stand in several groups."""
    if not path.is_file():
        raise UserError(f"there is no {path} with published runs; without the word published all runs are trained")
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, strict=True)
            lacking = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
            if lacking:
                raise ValueError(f"it has no column {lacking[0]}")
            return {row[DIGEST]: _row(row) for row in reader}
    except (ValueError, csv.Error) as error:
        raise UserError(f"{path} is not a whole table.csv as these programs write it: {error}") from error


def _row(row: Mapping[str, str]) -> _Row:
    """ValueError where it is damaged."""
    cut = any(row[name] is None for name in COLUMNS)  # as csv reads a row that is cut short
    if cut or len(row[DIGEST]) != DIGITS:  # the last column may be what is cut
        raise ValueError(f"the row of {row['group']}, seed {row['seed']}, is cut short")
    metrics = {name: float(row[name]) if row[name] else None for name in FIGURES}
    if not all(math.isfinite(value) for value in metrics.values() if value is not None):
        raise ValueError(f"a figure of {row['group']}, seed {row['seed']}, is no finite number")
    provenance = {name: row[name] for name in MADE_WITH if row[name]}
    return _Row(RunMetrics(**metrics), provenance, row["folder"], tuple(shlex.split(row["arguments"])))
