"""The one episode loop: it trains, evaluates and plays."""

from collections.abc import Sequence
from typing import Any

from asddpg.episodes.episode_stats import EpisodeStats
from asddpg.episodes.protocols import Agent, Environment, Episode, Observer, Step


def run_episode(
    environment: Environment,
    agent: Agent,
    observers: Sequence[Observer] = (),
    options: dict[str, Any] | None = None,
    max_steps: int | None = None,
) -> Episode:
    """Drive one episode to its end.

    Args:
        environment: where to drive.
        agent: who drives, and learns if it is one that learns.
        observers: who watches.
        options: of the environment's reset, such as start and goal.
        max_steps: after so many steps the episode is cut.
    """
    observation, info = environment.reset(options=options)
    agent.begin_episode()
    for observer in observers:
        observer.begin_episode(observation, info)
    stats = EpisodeStats(info)
    outcome = "cut"
    while max_steps is None or stats.steps < max_steps:
        decision = agent.decide(observation)
        next_observation, reward, terminated, truncated, info = environment.step(decision.action)
        step = Step(observation, decision, reward, next_observation, terminated, truncated, info)
        learned = agent.learn(step)
        stats.add(step)
        for observer in observers:
            observer.step(step, learned)
        observation = next_observation
        if terminated or truncated:
            outcome = info.get("outcome", "ended" if terminated else "timeout")
            break
    episode = stats.episode(outcome)
    for observer in observers:
        observer.end_episode(episode)
    return episode
