"""The one episode loop: it trains, evaluates and plays."""

import math
from collections.abc import Sequence
from typing import Any

from asddpg.types import Agent, Driver, Environment, Episode, Observer, Step


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
    steps, total_reward, controller_steps, path_length = 0, 0.0, 0, 0.0
    outcome = "cut"
    while max_steps is None or steps < max_steps:
        decision = agent.decide(observation)
        next_observation, reward, terminated, truncated, next_info = environment.step(decision.action)
        step = Step(observation, decision, reward, next_observation, terminated, truncated, next_info)
        learned = agent.learn(step)
        for observer in observers:
            observer.step(step, learned)
        steps += 1
        total_reward += reward
        controller_steps += decision.driver is Driver.CONTROLLER
        path_length += _distance(info, next_info)
        observation, info = next_observation, next_info
        if terminated or truncated:
            outcome = info.get("outcome", "ended" if terminated else "timeout")
            break
    episode = Episode(outcome, steps, total_reward, controller_steps, path_length)
    for observer in observers:
        observer.end_episode(episode)
    return episode


def _distance(before: dict[str, Any], after: dict[str, Any]) -> float:
    if "pose" not in before:
        return 0.0
    return math.dist(before["pose"][:2], after["pose"][:2])
