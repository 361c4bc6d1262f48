"""AsDDPG: Algorithm 1 of the paper, for many robots at once. Without a controller the same code is DDPG."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from asddpg.algorithm.controllers import Controllers
from asddpg.algorithm.exploration import OrnsteinUhlenbeckNoise
from asddpg.algorithm.learner import Learner, Losses
from asddpg.algorithm.losses import Batch
from asddpg.algorithm.n_step import NStepReturns
from asddpg.algorithm.networks import CONTROLLER, POLICY
from asddpg.algorithm.replay import ReplayBuffer, Transitions
from asddpg.algorithm.reward_shaping import assisted_rewards
from asddpg.algorithm.schedules import Withdrawal
from asddpg.episodes.batch_steps import BoolArray, Decisions, Float32Array, IntArray, Steps
from asddpg.episodes.protocols import Action, Controller, Decision, Observation

if TYPE_CHECKING:  # asddpg.config imports tasks, and with it mujoco, which an agent does without
    from asddpg.config import AgentConfig


class AsDDPG:
    """Policy, Critic-DQN and controller; drives robots and learns from all of them.

    Attributes:
        learner: updates the networks.
        networks: online networks.
        replay: the replay buffer R.
        robots: number of robots that it drives while it learns.
        steps: training steps so far, of all robots together.
    """

    def __init__(
        self,
        learner: Learner,
        config: "AgentConfig",
        replay: ReplayBuffer,
        noise: OrnsteinUhlenbeckNoise,
        controllers: Controllers | None,
        withdrawal: Withdrawal,
        robots: int = 1,
    ) -> None:
        """Put the parts together, all made for as many robots.

        Args:
            learner: of networks with a switch branch exactly if there are controllers.
            config: how to learn.
            replay: the replay buffer R.
            noise: exploration noise ε.
            controllers: assist; None makes this DDPG.
            withdrawal: when the actor drives alone.
            robots: their number.
        """
        self.networks = learner.networks
        if (controllers is None) != (self.networks.switch is None):
            raise ValueError("a switch needs a controller to switch to, and a controller needs a switch")
        self.learner, self.robots, self.steps = learner, robots, 0
        self._config, self.replay, self._noise, self._withdrawal = config, replay, noise, withdrawal
        self._controllers = controllers
        self._low = np.asarray(self.networks.shape.action_low, dtype=np.float32)
        self._high = np.asarray(self.networks.shape.action_high, dtype=np.float32)
        self._device = next(self.networks.parameters()).device
        self._returns = NStepReturns(config.n_steps, config.gamma, robots)
        self._observed = np.zeros(robots, np.int64)  # numbers of the present observations in the replay buffer
        self._owed = 0  # samples of the steps that no update has learned from yet
        self._parts: dict[str, Any] = {
            "replay": replay,
            "noise": noise,
            "withdrawal": withdrawal,
            "returns": self._returns,
        }

    @property
    def controller(self) -> Controller | None:
        """What assists robot 0."""
        return self._controllers.first if self._controllers else None

    # Driving ------------------------------------------------------------------------------------------------------

    def begin_episodes(self, robots: IntArray, observations: Float32Array) -> None:
        """Reset the noise of these robots, and draw whether their controllers may drive.

        Args:
            robots: (k,), their numbers.
            observations: (k, observation_size), the first ones.
        """
        self._noise.reset(robots)
        self._withdrawal.begin_episodes(robots)
        self._returns.begin_episodes(robots)
        self._observed[robots] = self.replay.observe(observations, robots)

    def decide(self, observations: Float32Array) -> Decisions:
        """Algorithm 1, lines 9–15: the greedy switch, then the policy with noise, or the controller.

        `observations` are those of all robots, (robots, observation_size).
        """
        decisions = self._choose(observations, self._withdrawal.is_alone)
        noise = np.full_like(decisions.actor_actions, np.nan)
        robots = np.flatnonzero(~decisions.by_controller)
        if len(robots):
            noise[robots] = self._noise.sample(robots)
            noisy = decisions.actor_actions[robots] + noise[robots]
            decisions.actions[robots] = np.minimum(np.maximum(noisy, self._low), self._high)
        return decisions._replace(noise=noise)

    def decide_greedily(self, observation: Observation) -> Decision:
        """For one robot without noise: how actor and controller drive together once trained."""
        return self._choose(observation[None], np.zeros(1, np.bool_)).row(0)

    @torch.no_grad()
    def act(self, observations: Observation) -> Action:
        """π(x), what the policy alone does: float32 (action_size,), physical units; for rows of them, in rows."""
        actions: Action = self.networks.policy(self._as_tensor(np.atleast_2d(observations))).cpu().numpy()
        return actions if observations.ndim > 1 else actions[0]

    def switch_values(self, observation: Observation) -> dict[str, float]:
        """q_policy, q_controller and value of a Decision; empty without a switch."""
        q, values = self._evaluate_switch(observation[None])
        if q is None or values is None:
            return {}
        return {"q_policy": float(q[0, POLICY]), "q_controller": float(q[0, CONTROLLER]), "value": float(values[0])}

    @torch.no_grad()
    def _evaluate_switch(self, observations: Float32Array) -> tuple[Float32Array | None, Float32Array | None]:
        if self.networks.switch is None:
            return None, None
        features = self.networks.features(self._as_tensor(observations))
        values, q = self.networks.switch.value_and_q(features)
        return q.cpu().numpy(), values.cpu().numpy()

    def _choose(self, observations: Float32Array, is_alone: BoolArray) -> Decisions:
        """The greedy switch; the controller does not drive where the actor `is_alone`."""
        actor_actions = self.act(observations)
        q, values = self._evaluate_switch(observations)
        if self._controllers is None or q is None:
            return Decisions(actor_actions.copy(), np.zeros(len(observations), np.bool_), actor_actions)
        controller_actions = self._controllers.act(observations)
        by_controller = (q[:, CONTROLLER] > q[:, POLICY]) & ~is_alone
        actions = np.where(by_controller[:, None], controller_actions, actor_actions)
        return Decisions(actions, by_controller, actor_actions, controller_actions, q=q, values=values)

    def _as_tensor(self, observations: Float32Array) -> torch.Tensor:
        return torch.from_numpy(observations).to(self._device)

    # Learning -----------------------------------------------------------------------------------------------------

    def store(self, steps: Steps) -> None:
        """Algorithm 1, line 17: store a step of every robot."""
        transitions = self._transitions(steps)
        for completed in self._returns.add(transitions, steps.terminated | steps.truncated):
            self.replay.add(completed)
        self._observed = transitions.next_observation
        self.steps += self.robots
        self._noise.advance(self.robots)
        self._withdrawal.advance()

    def learn(self) -> list[Losses]:
        """Algorithm 1, lines 18–21: the updates that are due for a step of every robot, once there are enough samples.

        Returns:
            Losses and TD errors of each update.
        """
        size = self._config.batch_size
        if len(self.replay) < max(self._config.learning_starts, size):
            return []
        count, self._owed = divmod(self._owed + self.robots * self._config.samples_per_step, size)
        rows = [torch.from_numpy(self.replay.sample(size)).to(self._device) for _ in range(count)]
        return self.learner.update([Batch.unpack(each, self.replay.layout) for each in rows], self.steps)

    def _transitions(self, steps: Steps) -> Transitions:
        decisions, config = steps.decisions, self._config
        dense = steps.infos.get("dense_reward", np.zeros(self.robots))
        charged = assisted_rewards(
            steps.rewards, dense, decisions.by_controller, config.gamma_p, price=config.controller_price
        )
        controller_actions = decisions.controller_actions
        return Transitions(
            observation=self._observed,
            action=decisions.actions,
            reward=charged if config.charge_critic else steps.rewards,
            switch_reward=charged,
            discount=np.where(steps.terminated, 0.0, 1.0),
            by_policy=np.where(decisions.by_controller, 0.0, 1.0),
            next_observation=self.replay.observe(steps.next_observations, np.arange(self.robots)),
            controller_action=decisions.actions if controller_actions is None else controller_actions,
        )

    # Saving -------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """All that the next steps depend on: an agent that restores it continues as this one, to the last bit."""
        return {
            "learner": self.learner.state(),
            **{name: part.state() for name, part in self._parts.items()},
            "controllers": self._controllers.state() if self._controllers else None,
            "observed": self._observed.copy(),
            "owed": self._owed,
            "steps": self.steps,
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            KeyError, RuntimeError, ValueError: it is of another network, another number of robots, or of a replay
                buffer of another size.
        """
        self.learner.load_state(state["learner"])
        for name, part in self._parts.items():
            part.load_state(state[name])
        if self._controllers:
            self._controllers.load_state(state["controllers"])
        self._observed, self._owed, self.steps = state["observed"].copy(), state["owed"], state["steps"]
