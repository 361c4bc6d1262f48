"""What the first seed rules out, so that the others are spent on the settings in question."""

from collections.abc import Mapping
from dataclasses import replace

from tools.experiments.ablation_table import EFFECT_ON, Row
from tools.experiments.run_groups import Group
from tools.experiments.run_tables import Results


def first_round(rows: Mapping[str, Row]) -> dict[str, Group]:
    """Every row's group with its first seed alone."""
    return {name: replace(row.group, seeds=row.group.seeds[:1]) for name, row in rows.items()}


def screened(rows: Mapping[str, Row], results: Results, margin: float) -> dict[str, Row]:
    """The rows; those that the first seed rules out ask for no further runs and say so in their title.

    Ruled out is what falls short of its reference by more than `margin`, or reaches less than `margin` at all. A root
    stays, and so does what a row that stays is measured against. Runs there are already stay in the table.
    """
    out = _ruled_out(rows, results, margin)
    return {name: _cut(row, results, name) if name in out else row for name, row in rows.items()}


def _ruled_out(rows: Mapping[str, Row], results: Results, margin: float) -> set[str]:
    kept: set[str] = set()
    for name, row in rows.items():
        if row.reference is None or not _falls_short(name, row.reference, rows, results, margin):
            kept |= {name, *_references(name, rows)}
    return set(rows) - kept


def _falls_short(name: str, reference: str, rows: Mapping[str, Row], results: Results, margin: float) -> bool:
    reach = _first_reach(name, rows, results)
    base = _first_reach(reference, rows, results)
    return reach is not None and (reach < margin or (base is not None and reach < base - margin))


def _first_reach(name: str, rows: Mapping[str, Row], results: Results) -> float | None:
    first = rows[name].group.seeds[0]
    return next((getattr(result.metrics, EFFECT_ON) for result in results[name] if result.seed == first), None)


def _references(name: str, rows: Mapping[str, Row]) -> set[str]:
    reference = rows[name].reference
    return {reference, *_references(reference, rows)} if reference else set()


def _cut(row: Row, results: Results, name: str) -> Row:
    there = {result.seed for result in results[name]}
    group = row.group
    if there >= set(group.seeds):
        return row
    seeds = tuple(seed for seed in group.seeds if seed in there)
    return replace(row, group=replace(group, title=f"{group.title} (ruled out)", seeds=seeds))
