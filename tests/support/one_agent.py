"""An AsDDPG of one robot as a driver of the episode loop, which learns after each step."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from asddpg.algorithm.agent import AsDDPG
from asddpg.algorithm.replay import Transitions
from asddpg.episodes.batch_steps import Decisions, Steps
from asddpg.episodes.protocols import Decision, Driver, Observation, Step

ROBOT = np.zeros(1, np.int64)


class OneAgent:
    """Drives and learns, an observation at a time."""

    def __init__(self, agent: AsDDPG) -> None:
        self.agent, self._begins = agent, False

    def begin_episode(self) -> None:
        self._begins = True

    def decide(self, observation: Observation) -> Decision:
        if self._begins:
            self.agent.begin_episodes(ROBOT, observation[None])
            self._begins = False
        return self.agent.decide(observation[None]).row(0)

    def learn(self, step: Step) -> Mapping[str, Any]:
        self.agent.store(steps_of(step))
        return {name: value for update in self.agent.learn() for name, value in update.items()}


def steps_of(step: Step) -> Steps:
    decision, controller = step.decision, step.decision.controller_action
    actor = decision.action if decision.actor_action is None else decision.actor_action
    decisions = Decisions(
        decision.action[None],
        np.array([decision.driver is Driver.CONTROLLER]),
        actor[None],
        None if controller is None else controller[None],
    )
    infos = {name: np.array([value]) for name, value in step.info.items()}
    return Steps(
        step.observation[None],
        decisions,
        np.array([step.reward]),
        step.next_observation[None],
        np.array([step.terminated]),
        np.array([step.truncated]),
        infos,
    )


def transitions(x: Any, actions: Any, values: tuple[float, float, float, float], x_next: Any) -> Transitions:
    """Of one robot or of several with the same reward, switch reward, discount and by_policy."""
    reward, switch_reward, discount, by_policy = (np.full(len(x), value) for value in values)
    return Transitions(x, actions, reward, switch_reward, discount, by_policy, x_next, actions)
