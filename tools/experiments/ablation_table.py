"""The ablation's table: what each factor changes against its reference, sorted by it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from asddpg.episodes.intervals import Estimate, mean
from tools.experiments.chance import chance
from tools.experiments.markdown import markdown
from tools.experiments.run_groups import Group
from tools.experiments.run_tables import COLUMNS, LEGEND, Column, Result, Results, missing_note, over_seeds

EFFECT_ON = "success_last"
SHOWN = (
    "success_last",
    "collision_last",
    "success_best",
    "success_training",
    "share_end",
    "switch_prefers",
    "last_five",
    "swing",
)
EFFECT = Column("effect on reach", "{:+.3f}", is_share=False)


@dataclass(frozen=True)
class Row:
    """A row of the grid and the name of the row it is measured against; a root of the grid has none."""

    group: Group
    reference: str | None


def report(title: str, rows: Mapping[str, Row], results: Results) -> str:
    """A table for each reference; rows without a finished run are left out."""
    header = ["setting", "seeds", f"{COLUMNS[EFFECT_ON].title}, by seed", EFFECT.title]
    header += [COLUMNS[key].title for key in SHOWN]
    against = "from the first row, or from the one that is named"
    parts = [title, f"Effect: difference of {COLUMNS[EFFECT_ON].title} {against}, paired by seed."]
    for root in (name for name, row in rows.items() if row.reference is None):
        lines = _lines(root, rows, results)
        parts += [markdown(header, lines), *_chance_note(root, rows, results)] if lines else []
    return "\n\n".join([*parts, LEGEND])


def _chance_note(root: str, rows: Mapping[str, Row], results: Results) -> list[str]:
    """What a difference has to exceed; nothing where it cannot be told."""
    seeds = rows[root].group.seeds
    values = [_by_seed(results[name]) for name in rows if _root(name, rows) == root]
    complete = [[of_setting[seed] for seed in seeds] for of_setting in values if set(seeds) <= set(of_setting)]
    apart, others = chance(complete), len(complete) - 1
    if apart is None:
        return []
    return [
        f"Chance alone sets two settings of {len(seeds)} seeds up to {apart:.3f} apart (95 %, from the spread of the "
        f"{len(complete)} settings with all seeds). Who looks at all of them looks for the largest: among {others} "
        f"differences chance gives one of up to {chance(complete, others):.3f}."
    ]


def _by_seed(results: Sequence[Result]) -> dict[int, float]:
    values = {result.seed: getattr(result.metrics, EFFECT_ON) for result in results}
    return {seed: value for seed, value in values.items() if value is not None}


def _lines(root: str, rows: Mapping[str, Row], results: Results) -> list[list[str]]:
    below = {name: row.reference for name, row in rows.items() if row.reference and _root(name, rows) == root}
    effects = {name: effect(results[name], results[reference]) for name, reference in below.items()}
    order = sorted(effects, key=lambda name: _sort_key(effects[name]))
    lines = []
    for name in (name for name in (root, *order) if results[name]):
        group, reference = rows[name].group, below.get(name, root)
        against = "" if reference == root else f", against {rows[reference].group.title}"
        lines.append(_line(group, against, results[name], effects.get(name)))
    return lines


def _root(name: str, rows: Mapping[str, Row]) -> str:
    reference = rows[name].reference
    return name if reference is None else _root(reference, rows)


def _sort_key(estimate: Estimate) -> tuple[bool, float]:
    """Largest first, those not known yet at the end."""
    return (estimate.value is None, -(estimate.value or 0.0))


def effect(results: Sequence[Result], reference: Sequence[Result]) -> Estimate:
    """Mean difference between runs of the same seed."""
    base = _by_seed(reference)
    return mean([value - base[seed] for seed, value in _by_seed(results).items() if seed in base])


def _line(group: Group, against: str, results: Sequence[Result], difference: Estimate | None) -> list[str]:
    column = COLUMNS[EFFECT_ON]
    by_seed = [column.cell(Estimate(getattr(result.metrics, EFFECT_ON), None, None)) for result in results]
    return [
        group.title + against + missing_note(group, results),
        ", ".join(str(result.seed) for result in results),
        ", ".join(by_seed),
        EFFECT.cell(difference or Estimate(None, None, None)),
        *(COLUMNS[key].cell(over_seeds(results, key)) for key in SHOWN),
    ]
