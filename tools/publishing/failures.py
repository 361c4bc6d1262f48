"""Failures of a driver, by length of the path and by region of the goal."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import SupportsFloat

from asddpg.episodes.protocols import Episode, Observer, Step
from tasks.room_geometry.held_out import Pair
from tools.experiments.tables import markdown

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
        room = {"room": self.pair.room} if self.pair.room else {}
        return room | place | {"shortest_path": self.pair.shortest_path, "outcome": self.outcome, "end": end}


class EndingsLog(Observer):
    """Records outcome and last place of each episode."""

    def __init__(self) -> None:
        self._endings: list[tuple[str, tuple[float, float]]] = []

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Record the place."""
        x, y, _ = step.info["pose"]
        self._place = (float(x), float(y))

    def end_episode(self, episode: Episode) -> None:
        """Record the outcome."""
        self._endings.append((episode.outcome, self._place))

    def drives(self, pairs: Sequence[Pair]) -> list[DrivenEpisode]:
        """The episodes with their pairs, in the same order."""
        return [DrivenEpisode(pair, *ending) for pair, ending in zip(pairs, self._endings, strict=True)]


def report(drives: Sequence[DrivenEpisode]) -> str:
    """Markdown: failures by kind, by length of the shortest path, and, in one room, by region of the goal."""
    failed = [drive for drive in drives if drive.failed]
    if not failed:
        return f"On none of the {len(drives)} pairs."
    near = sum(math.dist(drive.end, drive.pair.goal) < NEAR for drive in failed)
    ending = f"{near} {'ends' if near == 1 else 'end'} within {NEAR:g} m of the goal"
    kinds = f"It fails on {len(failed)} of {len(drives)} pairs: {_kinds(failed)}; {ending}."
    regions = [] if drives[0].pair.room else _region_table(drives)
    return "\n\n".join([kinds, "By length of the shortest path:", _length_table(drives), *regions])


def _kinds(drives: Iterable[DrivenEpisode]) -> str:
    counts = Counter(drive.outcome for drive in drives)
    return ", ".join(f"{counts[name]} {title}" for name, title in OUTCOME_TITLES.items() if counts[name])


def _length_table(drives: Sequence[DrivenEpisode]) -> str:
    counts = Counter((int(drive.pair.shortest_path), drive.outcome) for drive in drives)
    rows = []
    for metres in sorted({metres for metres, _ in counts}):
        numbers = [counts[metres, name] for name in OUTCOME_TITLES]
        rows.append([f"{metres} to {metres + 1} m", *map(str, [sum(numbers), *numbers])])
    return markdown(["path", "pairs", *OUTCOME_TITLES.values()], rows)


def _region_table(drives: Sequence[DrivenEpisode]) -> list[str]:
    regions: dict[tuple[float, ...], list[DrivenEpisode]] = {}  # by the corner with the least x and y
    for drive in drives:
        regions.setdefault(tuple(REGION * math.floor(value / REGION) for value in drive.pair.goal), []).append(drive)
    failures = {corner: [drive for drive in inside if drive.failed] for corner, inside in regions.items()}
    order = sorted(filter(failures.get, regions), key=lambda at: (-len(failures[at]), len(regions[at]), at))
    rows = [
        [
            f"x {west:g} to {west + REGION:g}, y {south:g} to {south + REGION:g}",
            f"{len(failures[west, south])} of {len(regions[west, south])}",
            _kinds(failures[west, south]),
            "; ".join(map(_describe, failures[west, south][:SHOWN])),
        ]
        for west, south in order[:WORST]
    ]
    rest = sum(len(failures[corner]) for corner in order[WORST:])
    others = f"The other {rest} lie elsewhere; `test.json`" if rest else "`test.json`"
    return [
        f"The worst regions, squares of {REGION:g} m by the goal; metres, world frame:",
        markdown(["goal in", "failed", "how", "such as"], rows),
        f"{others} lists every failure with start, goal and end.",
    ]


def _describe(drive: DrivenEpisode) -> str:
    start, goal, end = (f"({x:.2f}, {y:.2f})" for x, y in (drive.pair.start[:2], drive.pair.goal, drive.end))
    return f"{start} → {goal}, ends at {end}"
