"""Figures of driven episodes, and differences between two drivers along the same pairs."""

import math
from collections.abc import Callable, Sequence

from asddpg.episodes.evaluation import ROWS, episode_metric, episode_spl, summarize_episodes
from asddpg.episodes.intervals import Estimate, mean
from tools.comparison.driven_episodes import DrivenCase, DrivenEpisode

# Titles and forms of the columns.
FIGURES = ROWS | {
    "turn_change": ("mean change of ω (rad/s)", "{:.3f}"),
    "large_changes": ("changes above 0.5 rad/s", "{:.3f}"),
    "sign_flips": ("sign flips of ω", "{:.3f}"),
    "decision_ms": ("ms a decision", "{:.3g}"),
}
DIFFERENCES = {
    "success_rate": ("success rate", "{:+.3f}"),
    "collision_rate": ("collision rate", "{:+.3f}"),
    "metric": ("metric", "{:+.3f}"),
    "time": ("time (s), where both reached", "{:+.1f}"),
    "spl": ("SPL", "{:+.3f}"),
}
Measure = Callable[[DrivenEpisode], float]


def figures_of(case: DrivenCase) -> dict[str, Estimate]:
    """The figures of a driver on a task, by the names of FIGURES; the median of a decision has no interval."""
    episodes = [each.episode for each in case.episodes]
    paths = [each.shortest_path for each in case.episodes]
    summary = summarize_episodes(episodes, paths, case.control_timestep)
    return {
        **{name: getattr(summary, name) for name in ROWS},
        "turn_change": _per_change(case.episodes, lambda each: each.smoothness.total_change),
        "large_changes": _per_change(case.episodes, lambda each: each.smoothness.large_changes, high=1.0),
        "sign_flips": _per_change(case.episodes, lambda each: each.smoothness.sign_flips, high=1.0),
        "decision_ms": Estimate(case.decision_ms, None, None),
    }


def _per_change(episodes: Sequence[DrivenEpisode], amount: Measure, high: float = math.inf) -> Estimate:
    """An amount by the changes of ω of all episodes; Student's interval of a ratio, as episodes differ in length."""
    changes = [each.smoothness.changes for each in episodes]
    if not sum(changes):
        return Estimate(None, None, None)
    ratio, length = sum(map(amount, episodes)) / sum(changes), sum(changes) / len(episodes)
    spread = [(amount(each) - ratio * count) / length for each, count in zip(episodes, changes, strict=True)]
    return mean([ratio + each for each in spread], 0.0, high)


def paired_differences(case: DrivenCase, baseline: DrivenCase) -> tuple[int, dict[str, Estimate]]:
    """A driver less the baseline, on one task.

    Returns:
        The pairs that both drove; by the names of DIFFERENCES the means over them, with Student's intervals.
    """
    theirs = {each.pair: each for each in baseline.episodes}
    both = [(each, theirs[each.pair]) for each in case.episodes if each.pair in theirs]
    in_time = [(mine, other) for mine, other in both if _has_reached(mine) and _has_reached(other)]
    return len(both), {
        "success_rate": mean([_has_reached(mine) - _has_reached(other) for mine, other in both], -1.0, 1.0),
        "collision_rate": mean([_has_crashed(mine) - _has_crashed(other) for mine, other in both], -1.0, 1.0),
        "metric": mean([episode_metric(mine.episode) - episode_metric(other.episode) for mine, other in both]),
        "time": mean([_time(case, mine) - _time(baseline, other) for mine, other in in_time]),
        "spl": mean([_spl(mine) - _spl(other) for mine, other in both], -1.0, 1.0),
    }


def _has_reached(driven: DrivenEpisode) -> bool:
    return driven.episode.outcome == "reached"


def _has_crashed(driven: DrivenEpisode) -> bool:
    return driven.episode.outcome == "crashed"


def _time(case: DrivenCase, driven: DrivenEpisode) -> float:
    return driven.episode.steps * case.control_timestep


def _spl(driven: DrivenEpisode) -> float:
    return episode_spl(driven.episode, driven.shortest_path)
