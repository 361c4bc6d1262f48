"""AsDDPG: Algorithm 1 of the paper. Without a controller the same code is DDPG."""

import copy
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from torch import Tensor
from torch.optim import Adam

from asddpg.algorithm.exploration import OrnsteinUhlenbeckNoise
from asddpg.algorithm.flat import FlatParameters
from asddpg.algorithm.losses import Batch, TargetRule, bellman_targets, critic_dqn_loss, policy_loss
from asddpg.algorithm.n_step import NStepReturns
from asddpg.algorithm.networks import CONTROLLER, POLICY, Networks
from asddpg.algorithm.replay import BalancedReplay, ReplayBuffer, Transition
from asddpg.algorithm.reward_shaping import assisted_reward
from asddpg.algorithm.schedules import Withdrawal, learning_rate_scale
from asddpg.episodes.protocols import Action, Controller, Decision, Driver, Observation, StatefulController, Step

if TYPE_CHECKING:  # asddpg.config imports tasks, and with it mujoco, which an agent does without
    from asddpg.config import AgentConfig


class AsDDPG:
    """Policy, Critic-DQN and controller; drives and learns."""

    def __init__(
        self,
        networks: Networks,
        config: "AgentConfig",
        replay: ReplayBuffer | BalancedReplay,
        noise: OrnsteinUhlenbeckNoise,
        controller: Controller | None,
        withdrawal: Withdrawal,
        total_steps: int,
        smoothing_seed: int,
        device: torch.device,
    ) -> None:
        """Put the parts together.

        Args:
            networks: online networks, with a switch branch exactly if there is a controller.
            config: how to learn.
            replay: the replay buffer R.
            noise: exploration noise ε.
            controller: assists; None makes this DDPG.
            withdrawal: when the actor drives alone.
            total_steps: of the training, over which the learning rates decay.
            smoothing_seed: of the noise on π' in y^A.
            device: where the networks live.
        """
        if (controller is None) != (networks.switch is None):
            raise ValueError("a switch needs a controller to switch to, and a controller needs a switch")
        self.networks = networks.to(device)
        self.target = copy.deepcopy(self.networks).requires_grad_(False)
        self.controller = controller
        self.config = config
        self.device = device
        self._replay, self._noise = replay, noise
        self._low = np.asarray(networks.shape.action_low, dtype=np.float32)
        self._high = np.asarray(networks.shape.action_high, dtype=np.float32)
        self._critic_dqn, self._policy = _flatten(self.networks)
        self._target_critic_dqn, self._target_policy = _flatten(self.target)
        self._critic_optimizer = Adam([self._critic_dqn.vector], lr=config.critic_learning_rate, fused=True)
        self._policy_optimizer = Adam([self._policy.vector], lr=config.actor_learning_rate, fused=True)
        self._returns = NStepReturns(config.n_steps, config.gamma)
        self._withdrawal, self._total_steps = withdrawal, total_steps
        self._smoothing = torch.Generator(device).manual_seed(smoothing_seed)
        self.steps = self.updates = 0
        self._flat = {
            "critic_dqn": self._critic_dqn,
            "policy": self._policy,
            "target_critic_dqn": self._target_critic_dqn,
            "target_policy": self._target_policy,
        }
        self._optimizers = {"critic_dqn": self._critic_optimizer, "policy": self._policy_optimizer}
        self._parts = {"replay": replay, "noise": noise, "withdrawal": withdrawal, "returns": self._returns}

    # Driving ------------------------------------------------------------------------------------------------------

    def begin_episode(self) -> None:
        """Reset the exploration noise, and draw whether the controller may drive."""
        self._noise.reset()
        self._withdrawal.begin_episode()
        self._returns.begin_episode()

    def decide(self, observation: Observation) -> Decision:
        """Algorithm 1, lines 9–15: the greedy switch, then the policy with noise, or the controller."""
        return self._choose(observation, explore=True)

    def decide_greedily(self, observation: Observation) -> Decision:
        """The same without noise: how actor and controller drive together once trained."""
        return self._choose(observation, explore=False)

    @torch.no_grad()
    def act(self, observation: Observation) -> Action:
        """π(x), what the policy alone does: float32 (action_size,), physical units."""
        action: Action = self.networks.policy(self._as_batch(observation))[0].cpu().numpy()
        return action

    @torch.no_grad()
    def switch_values(self, observation: Observation) -> dict[str, float]:
        """q_policy, q_controller and value of a Decision; empty without a switch."""
        return self._evaluate_switch(self._as_batch(observation))

    def _evaluate_switch(self, x: Tensor) -> dict[str, float]:
        if self.networks.switch is None:
            return {}
        value, q = self.networks.switch.value_and_q(self.networks.features(x))
        q_policy, q_controller = q[0].tolist()
        return {"q_policy": q_policy, "q_controller": q_controller, "value": value.item()}

    @torch.no_grad()
    def _choose(self, observation: Observation, explore: bool) -> Decision:
        x = self._as_batch(observation)
        actor_action: Action = self.networks.policy(x)[0].cpu().numpy()
        evaluated: dict[str, Any] = {"actor_action": actor_action}
        driver = Driver.POLICY
        if self.controller is not None:
            evaluated |= self._evaluate_switch(x)
            evaluated["controller_action"] = controller_action = self.controller.act(observation)
            if evaluated["q_controller"] > evaluated["q_policy"] and not (explore and self._withdrawal.is_alone):
                return Decision(controller_action, Driver.CONTROLLER, **evaluated)
        if not explore:
            return Decision(actor_action, driver, **evaluated)
        noise = self._noise.sample()
        action = np.minimum(np.maximum(actor_action + noise, self._low), self._high)
        return Decision(action, driver, noise=noise, **evaluated)

    def _as_batch(self, observation: Observation) -> Tensor:
        return torch.from_numpy(observation).to(self.device)[None]

    # Learning -----------------------------------------------------------------------------------------------------

    def learn(self, step: Step) -> Mapping[str, Tensor]:
        """Algorithm 1, lines 17–21: store the step, and once there are enough, update."""
        for transition in self._returns.add(self._transition(step), step.terminated or step.truncated):
            self._replay.add(transition)
        self.steps += 1
        self._noise.advance()
        self._withdrawal.advance()
        if len(self._replay) < max(self.config.learning_starts, self.config.batch_size):
            return {}
        rows = torch.from_numpy(self._replay.sample(self.config.batch_size)).to(self.device)
        return self.update(Batch.unpack(rows, self._replay.layout))

    def _transition(self, step: Step) -> Transition:
        decision, config = step.decision, self.config
        dense_reward = step.info.get("dense_reward", 0.0)
        charged = assisted_reward(
            step.reward, dense_reward, decision.driver, config.gamma_p, price=config.controller_price
        )
        return Transition(
            observation=step.observation,
            action=decision.action,
            reward=charged if config.charge_critic else step.reward,
            switch_reward=charged,
            discount=0.0 if step.terminated else 1.0,
            next_observation=step.next_observation,
            by_policy=float(decision.driver is Driver.POLICY),
            controller_action=decision.action if decision.controller_action is None else decision.controller_action,
        )

    def update(self, batch: Batch) -> Mapping[str, Tensor]:
        """One update: Critic-DQN by Eq. 4, policy by Eq. 5, then the soft targets."""
        self._decay_learning_rates()
        targets = bellman_targets(batch, self.networks, self.target, self._target_rule(batch))
        loss = critic_dqn_loss(batch, self.networks.features(batch.x), self.networks, targets)
        self._critic_dqn.backward(loss.total)
        self._critic_optimizer.step()
        learned = {
            "critic_loss": loss.critic.detach(),
            "td_error_policy": loss.td_errors[POLICY],
            "td_error_controller": loss.td_errors[CONTROLLER],
        }
        if loss.switch is not None:
            learned["switch_loss"] = loss.switch.detach()

        if self.updates % self.config.policy_every == 0:
            with torch.no_grad():
                features = self.networks.features(batch.x)
            objective = policy_loss(batch, features, self.networks, self.config.imitation)
            self._policy.backward(objective)
            self._policy_optimizer.step()
            self._target_policy.soft_update(self._policy, self.config.tau)
            learned["policy_loss"] = objective.detach()

        self._target_critic_dqn.soft_update(self._critic_dqn, self.config.tau)
        self.updates += 1
        return learned

    def _target_rule(self, batch: Batch) -> TargetRule:
        noise, sigma = None, self.config.target_noise
        if sigma:
            noise = torch.empty_like(batch.a).normal_(0.0, sigma, generator=self._smoothing)
            noise = noise.clamp_(-2.0 * sigma, 2.0 * sigma)
        return TargetRule(self.config.gamma, self.config.critic_follows_switch, noise)

    def _decay_learning_rates(self) -> None:
        scale = learning_rate_scale(self.steps, self._total_steps, self.config.annealing)
        self._critic_optimizer.param_groups[0]["lr"] = scale * self.config.critic_learning_rate
        self._policy_optimizer.param_groups[0]["lr"] = scale * self.config.actor_learning_rate

    # Saving -------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """All that the next steps depend on: an agent that restores it continues as this one, to the last bit."""
        return {
            "weights": {name: flat.vector.cpu() for name, flat in self._flat.items()},
            "optimizers": {name: _moments(optimizer) for name, optimizer in self._optimizers.items()},
            **{name: part.state() for name, part in self._parts.items()},
            "smoothing": self._smoothing.get_state(),
            "controller": self.controller.state() if isinstance(self.controller, StatefulController) else None,
            "steps": self.steps,
            "updates": self.updates,
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            KeyError, RuntimeError, ValueError: it is of another network, or of a replay buffer of another size.
        """
        for name, flat in self._flat.items():
            flat.load(state["weights"][name])
        for name, optimizer in self._optimizers.items():
            _load_moments(optimizer, state["optimizers"][name])
        for name, part in self._parts.items():
            part.load_state(state[name])
        self._smoothing.set_state(state["smoothing"])
        if isinstance(self.controller, StatefulController):
            self.controller.load_state(state["controller"])
        self.steps, self.updates = state["steps"], state["updates"]

    def finite_weights(self) -> dict[str, bool]:
        """Whether each network's weights are all finite."""
        return {name: bool(torch.isfinite(flat.vector).all()) for name, flat in self._flat.items()}


def _flatten(networks: Networks) -> tuple[FlatParameters, FlatParameters]:
    return FlatParameters(networks.critic_dqn_parameters()), FlatParameters(networks.policy_parameters())


def _moments(optimizer: Adam) -> dict[str, Tensor]:
    """Adam's moments and its count of steps; nothing before its first."""
    (vector,) = optimizer.param_groups[0]["params"]
    return {name: value.cpu() for name, value in optimizer.state[vector].items()}


def _load_moments(optimizer: Adam, moments: Mapping[str, Tensor]) -> None:
    (vector,) = optimizer.param_groups[0]["params"]
    optimizer.state[vector] = {name: value.to(vector.device, copy=True) for name, value in moments.items()}
