"""Drives the episodes of an evaluation and turns them into figures."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from asddpg.episodes.intervals import Estimate, mean, rate
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Agent, Environment, Episode, Observer

# Figures that tables show, with their titles and the form of their numbers.
ROWS = {
    "success_rate": ("success rate", "{:.3f}"),
    "collision_rate": ("collision rate", "{:.3f}"),
    "timeout_rate": ("time-out rate", "{:.3f}"),
    "metric": ("metric", "{:.3f}"),
    "mean_time": ("mean time (s)", "{:.1f}"),
    "spl": ("SPL", "{:.3f}"),
}
STEP_PENALTY, REACH_BONUS = -0.01, 2.0  # the paper's task metric, section V


class StartGoalPair(Protocol):
    """A start (x, y, yaw), a goal (x, y) and the shortest free path between them; metres, radians."""

    @property
    def start(self) -> tuple[float, float, float]:
        """Pose of the base."""

    @property
    def goal(self) -> tuple[float, float]:
        """Where to go."""

    @property
    def shortest_path(self) -> float:
        """Length of the shortest free path to within the goal's radius."""

    @property
    def reset_options(self) -> dict[str, Any]:
        """Of the environment's reset: start, goal and, if the task has one for each episode, the room."""


@dataclass(frozen=True)
class EvaluationResult:
    """What an evaluation measured, each figure with its 95 % interval."""

    episodes: int
    success_rate: Estimate
    collision_rate: Estimate
    timeout_rate: Estimate
    metric: Estimate  # −0.01 a step, +2 for reaching
    mean_time: Estimate  # seconds to the goal, of the episodes that reached it
    spl: Estimate  # success weighted by path length (Anderson et al., 2018)
    controller_share: float  # of all steps

    def as_dict(self) -> dict[str, object]:
        """For evaluation.json: each figure as value and 95 % interval."""
        return {
            name: {"value": figure.value, "ci95": [figure.low, figure.high]} if isinstance(figure, Estimate) else figure
            for name, figure in vars(self).items()
        }


def evaluate(
    environment: Environment,
    agent: Agent,
    pairs: Iterable[StartGoalPair],
    control_timestep: float,
    observers: Sequence[Observer] = (),
    before_episode: Callable[[], None] = lambda: None,
) -> EvaluationResult:
    """Drive one episode for each pair.

    Args:
        environment: where to drive; its reset takes options start and goal.
        agent: the driver.
        pairs: from where to where.
        control_timestep: seconds a step.
        observers: notified of the episodes.
        before_episode: called before each; may raise to stop the evaluation.
    """
    episodes: list[Episode] = []
    shortest_paths = []
    for pair in pairs:
        options = pair.reset_options
        if not episodes:
            environment.reset(seed=0, options=options)  # of the laser's noise: the same evaluation has the same result
        before_episode()
        episodes.append(run_episode(environment, agent, observers, options=options))
        shortest_paths.append(pair.shortest_path)
    return summarize_episodes(episodes, shortest_paths, control_timestep)


def summarize_episodes(
    episodes: Sequence[Episode], shortest_paths: Sequence[float], control_timestep: float
) -> EvaluationResult:
    """The figures of episodes driven along pairs with those shortest paths (m)."""
    count = len(episodes)
    reached = [episode.outcome == "reached" for episode in episodes]
    steps = sum(episode.steps for episode in episodes)
    return EvaluationResult(
        episodes=count,
        success_rate=rate(sum(reached), count),
        collision_rate=rate(sum(episode.outcome == "crashed" for episode in episodes), count),
        timeout_rate=rate(sum(episode.outcome == "timeout" for episode in episodes), count),
        metric=mean([episode_metric(e) for e in episodes], high=REACH_BONUS),
        mean_time=mean([e.steps * control_timestep for e, hit in zip(episodes, reached, strict=True) if hit], low=0.0),
        spl=mean(
            [episode_spl(e, length) for e, length in zip(episodes, shortest_paths, strict=True)], low=0.0, high=1.0
        ),
        controller_share=sum(episode.controller_steps for episode in episodes) / max(steps, 1),
    )


def episode_metric(episode: Episode) -> float:
    """The paper's metric of one episode."""
    return STEP_PENALTY * episode.steps + REACH_BONUS * (episode.outcome == "reached")


def episode_spl(episode: Episode, shortest_path: float) -> float:
    """What one episode adds to SPL's mean; the shortest path in metres."""
    if episode.outcome != "reached":
        return 0.0
    longest = max(episode.path_length, shortest_path)
    return shortest_path / longest if longest > 0 else 1.0


def table(columns: dict[str, EvaluationResult]) -> str:
    """Figures side by side as text, one column each."""
    lines = [f"{'':15}" + "".join(f"{name:>27}" for name in columns)]
    for field, (title, form) in ROWS.items():
        cells = (cell(getattr(result, field), form) for result in columns.values())
        lines.append(f"{title:15}" + "".join(f"{cell:>27}" for cell in cells))
    counts = ", ".join(str(result.episodes) for result in columns.values())
    return "\n".join([*lines, f"in brackets the 95 % interval; {counts} episodes"])


def cell(figure: Estimate, form: str) -> str:
    """A figure and its interval as text, each number in a form such as {:.3f}."""
    if figure.value is None:
        return "–"
    if figure.low is None or figure.high is None:
        return form.format(figure.value)
    return f"{form} [{form}, {form}]".format(*figure)
