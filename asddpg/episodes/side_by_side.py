"""Drives the episodes of an evaluation with many robots at once; for one at a time see evaluation.py."""

from collections.abc import Callable, Sequence

import numpy as np

from asddpg.episodes.batch_steps import Decisions, Float32Array, Infos, Steps
from asddpg.episodes.episode_sums import EpisodeSums, outcome_of
from asddpg.episodes.evaluation import EvaluationResult, StartGoalPair, summarize_episodes
from asddpg.episodes.protocols import Episode
from asddpg.episodes.training_episodes import RobotsEnvironment


def evaluate_side_by_side(
    environment: RobotsEnvironment,
    act: Callable[[Float32Array], Float32Array],
    pairs: Sequence[StartGoalPair],
    control_timestep: float,
    before_step: Callable[[], None] = lambda: None,
) -> EvaluationResult:
    """Drive one episode for each pair, each robot the next pair when its episode is over.

    Args:
        environment: where to drive; a robot that has no pair left drives on, and is not counted.
        act: the actions, (n, action_size), for observations, (n, observation_size).
        pairs: from where to where.
        control_timestep: seconds a step.
        before_step: called before each step; may raise to stop the evaluation.
    """
    robots = environment.num_envs
    environment.reset(seed=0)  # of the laser's noise: the same evaluation has the same result
    episodes: list[Episode | None] = [None] * len(pairs)
    driving = [0] * robots  # numbers of the robots' pairs; beyond the last for those that have none left
    sums, waiting = EpisodeSums(robots), np.ones(robots, np.bool_)
    infos: Infos
    following = 0
    while any(episode is None for episode in episodes):
        before_step()
        for robot in np.flatnonzero(waiting).tolist():
            pair = pairs[min(following, len(pairs) - 1)]
            mask = np.arange(robots) == robot
            observations, infos = environment.reset(options={"reset_mask": mask} | pair.reset_options)
            driving[robot], following = following, following + 1
        sums.reset(np.flatnonzero(waiting))
        actions = act(observations)
        environment.begin_step(actions)
        found = environment.finish_step()
        decisions = Decisions(actions, np.zeros(robots, np.bool_), actions)
        steps = Steps(observations, decisions, found[1], found[0], *found[2:])
        sums.add(steps, infos)
        observations, infos = steps.next_observations, steps.infos
        waiting = steps.terminated | steps.truncated
        for robot in np.flatnonzero(waiting).tolist():
            if driving[robot] < len(pairs):
                episodes[driving[robot]] = sums.episode(robot, outcome_of(steps, robot))
    ended = [episode for episode in episodes if episode is not None]
    return summarize_episodes(ended, [pair.shortest_path for pair in pairs], control_timestep)
