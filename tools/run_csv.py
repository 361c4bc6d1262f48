"""Figures of runs as CSV, a row a run: written beside a table, and read where such a file is published in docs/runs.

So a table is drawn, and a new row measured against the others, without training again what others have trained.
"""

import csv
import dataclasses
import hashlib
import json
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from asddpg.errors import UserError
from tools.run_figures import RunFigures
from tools.run_groups import Group, settings_of
from tools.run_store import Settings
from tools.run_tables import Results

PUBLISHED = Path(__file__).resolve().parent.parent / "docs" / "runs"
FIGURES = tuple(field.name for field in dataclasses.fields(RunFigures))
MADE_WITH = ("asddpg", "model_hash")
DIGEST = "options_digest"
COLUMNS = ("group", "seed", *FIGURES, *MADE_WITH, DIGEST, "folder", "words")


@dataclass(frozen=True)
class PublishedRun:
    """A finished run that lies elsewhere, or nowhere any more."""

    settings: Settings
    made_with: Mapping[str, str]
    figures: RunFigures
    place: str = ""


def write_csv(path: Path, groups: Mapping[str, Group], results: Results) -> None:
    """A row a run and group; empty where there was nothing to measure."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for name, found in results.items():
            for result in found:
                figures = dataclasses.astuple(result.figures)
                made = [result.run.made_with.get(key, "") for key in MADE_WITH]
                options = digest(groups[name].settings(result.seed))
                words = shlex.join((*groups[name].options, f"seed={result.seed}"))
                writer.writerow([name, result.seed, *figures, *made, options, result.run.place, words])


def digest(settings: Settings) -> str:
    """Of every option that bears on the learning: the words of a run mean another one once a default has changed."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:16]


def published_runs(path: Path, groups: Mapping[str, Group]) -> list[PublishedRun]:
    """The runs of a published file that some groups ask for.

    Raises:
        UserError: there is no such file.
    """
    asked = {digest(group.settings(seed)): group.settings(seed) for group in groups.values() for seed in group.seeds}
    rows = _rows(path)
    try:
        return [_run(row, asked[options]) for options, row in rows.items() if options in asked]
    except (ValueError, TypeError) as error:  # no number, or a row cut short
        raise UserError(f"{path} is not a table.csv as these programs write it: {error!r}") from error


def outdated(path: Path) -> int:
    """How many published runs were trained with other options than their words give today, and so serve nobody."""
    return sum(options != _digest_today(row) for options, row in _rows(path).items())


def _digest_today(row: Mapping[str, str]) -> str | None:
    try:
        return digest(settings_of(shlex.split(row["words"])))
    except UserError:  # an option of then is none of today
        return None


def _rows(path: Path) -> dict[str, dict[str, str]]:
    """By digest: a run may stand in several groups."""
    if not path.is_file():
        raise UserError(f"there is no {path} with published runs; without the word published all runs are trained")
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if rows and not set(COLUMNS) <= set(rows[0]):
        lacking = next(name for name in COLUMNS if name not in rows[0])
        raise UserError(f"{path} is not a table.csv as these programs write it: it has no column {lacking}")
    return {row[DIGEST]: row for row in rows}


def _run(row: Mapping[str, str], settings: Settings) -> PublishedRun:
    figures = {name: float(row[name]) if row[name] else None for name in FIGURES}
    return PublishedRun(settings, {name: row[name] for name in MADE_WITH}, RunFigures(**figures))
