"""Failures of a driver, by length of the path and by region of the goal."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, SupportsFloat

from asddpg.episodes.protocols import Episode, Observation, Step
from tasks.room_geometry.held_out import Pair
from tools.experiments.markdown import markdown

OUTCOME_TITLES = {"reached": "reached", "crashed": "crashed", "timeout": "timed out"}
NEAR = 1.0  # m from the goal
REGION = 2.0  # m, side of the squares that group goals
WORST, SHOWN = 5, 3  # regions listed, and pairs listed of each


@dataclass(frozen=True)
class DrivenEpisode:
    """One start-goal pair, the outcome, and where the robot ended, (x, y) in metres."""

    pair: Pair
    outcome: str
    end: tuple[float, float]

    @property
    def failed(self) -> bool:
        """Whether the goal was not reached."""
        return self.outcome != "reached"

    def as_dict(self) -> dict[str, object]:
        """For test.json."""
        end = [round(value, 3) for value in self.end]
        place = {"start": list(self.pair.start), "goal": list(self.pair.goal)}
        return place | {"shortest_path": self.pair.shortest_path, "outcome": self.outcome, "end": end}


class EndingsLog:
    """Observer that records outcome and last place of each episode."""

    def __init__(self) -> None:
        self._endings: list[tuple[str, tuple[float, float]]] = []
        self._place = (math.nan, math.nan)

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Do nothing."""

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Record the place."""
        x, y, _ = step.info["pose"]
        self._place = (float(x), float(y))

    def end_episode(self, episode: Episode) -> None:
        """Record the outcome."""
        self._endings.append((episode.outcome, self._place))

    def drives(self, pairs: Sequence[Pair]) -> list[DrivenEpisode]:
        """The episodes with their pairs, in the same order."""
        return [DrivenEpisode(pair, outcome, end) for pair, (outcome, end) in zip(pairs, self._endings, strict=True)]


def report(drives: Sequence[DrivenEpisode]) -> str:
    """Markdown: failures by kind, by length of the shortest path, and by region of the goal."""
    failed = [drive for drive in drives if drive.failed]
    if not failed:
        return f"On none of the {len(drives)} pairs."
    near = sum(math.dist(drive.end, drive.pair.goal) < NEAR for drive in failed)
    ending = f"{near} {'ends' if near == 1 else 'end'} within {NEAR:g} m of the goal"
    kinds = f"It fails on {len(failed)} of {len(drives)} pairs: {_kinds(failed)}; {ending}."
    return "\n\n".join(
        [kinds, "By length of the shortest path:", _length_table(drives), *_region_table(drives, len(failed))]
    )


def _kinds(drives: Iterable[DrivenEpisode]) -> str:
    counts = Counter(drive.outcome for drive in drives)
    return ", ".join(f"{counts[name]} {argument}" for name, argument in OUTCOME_TITLES.items() if counts[name])


def _length_table(drives: Sequence[DrivenEpisode]) -> str:
    bins: dict[int, Counter[str]] = {}
    for drive in drives:
        bins.setdefault(int(drive.pair.shortest_path), Counter())[drive.outcome] += 1
    rows = [
        [f"{metres} to {metres + 1} m", str(counts.total()), *(str(counts[name]) for name in OUTCOME_TITLES)]
        for metres, counts in sorted(bins.items())
    ]
    return markdown(["path", "pairs", *OUTCOME_TITLES.values()], rows)


def _region_table(drives: Sequence[DrivenEpisode], all_failures: int) -> list[str]:
    regions: dict[tuple[int, int], list[DrivenEpisode]] = {}
    for drive in drives:
        x, y = drive.pair.goal
        regions.setdefault((math.floor(x / REGION), math.floor(y / REGION)), []).append(drive)
    failures = {region: [drive for drive in inside if drive.failed] for region, inside in regions.items()}
    worst = sorted((r for r in regions if failures[r]), key=lambda r: (-len(failures[r]), len(regions[r]), r))[:WORST]
    rows = []
    for region in worst:
        share, such_as = f"{len(failures[region])} of {len(regions[region])}", failures[region][:SHOWN]
        rows.append([_square(region), share, _kinds(failures[region]), _examples(such_as)])
    rest = all_failures - sum(len(failures[region]) for region in worst)
    others = f"The other {rest} lie elsewhere; `test.json`" if rest else "`test.json`"
    head = f"The worst regions, squares of {REGION:g} m by the goal; metres, world frame:"
    return [
        head,
        markdown(["goal in", "failed", "how", "such as"], rows),
        f"{others} lists every failure with start, goal and end.",
    ]


def _square(region: tuple[int, int]) -> str:
    (west, south) = (REGION * index for index in region)
    return f"x {west:g} to {west + REGION:g}, y {south:g} to {south + REGION:g}"


def _examples(drives: Sequence[DrivenEpisode]) -> str:
    return "; ".join(
        f"{_place(drive.pair.start[:2])} → {_place(drive.pair.goal)}, ends at {_place(drive.end)}" for drive in drives
    )


def _place(place: tuple[float, ...]) -> str:
    return f"({', '.join(f'{value:.2f}' for value in place)})"
