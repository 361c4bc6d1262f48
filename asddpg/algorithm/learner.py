"""Updates of policy and Critic-DQN from batches: Algorithm 1, lines 18 to 21."""

import copy
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

import torch
from torch import Tensor
from torch.optim import Adam

from asddpg.algorithm.flat import FlatParameters
from asddpg.algorithm.losses import Batch, PolicyTerms, TargetRule, bellman_targets, critic_dqn_loss, policy_loss
from asddpg.algorithm.networks import CONTROLLER, POLICY, Networks
from asddpg.algorithm.schedules import learning_rate_scale, smoothness_scale

if TYPE_CHECKING:  # asddpg.config imports tasks, and with it mujoco, which an agent does without
    from asddpg.config import AgentConfig

Losses = Mapping[str, Tensor]  # losses and TD errors of one update


class Learner:
    """Networks, their targets and optimisers.

    Attributes:
        networks: online.
        target: their slow copies.
        updates: made so far, of the Critic-DQN.
    """

    def __init__(
        self,
        networks: Networks,
        config: "AgentConfig",
        total_steps: int,
        smoothing_seed: int,
        device: torch.device,
        is_concurrent: bool = False,
    ) -> None:
        """Prepare to learn.

        Args:
            networks: online networks.
            config: how to learn.
            total_steps: of the training, over which the learning rates decay.
            smoothing_seed: of the noise on π' in y^A.
            device: where the networks live.
            is_concurrent: whether the policy learns beside the Critic-DQN, from the critic as it was before the
                present updates; on a CPU each in a thread of its own.
        """
        self.networks = networks.to(device)
        self.target = copy.deepcopy(self.networks).requires_grad_(False)
        self._config, self._total_steps = config, total_steps
        self._policy_terms = PolicyTerms(config.imitation, config.saturation)
        self._critic_dqn, self._policy = _flatten(self.networks)
        self._target_critic_dqn, self._target_policy = _flatten(self.target)
        self._critic_optimizer = Adam([self._critic_dqn.vector], lr=config.critic_learning_rate, fused=True)
        self._policy_optimizer = Adam([self._policy.vector], lr=config.actor_learning_rate, fused=True)
        self._smoothing = torch.Generator(device).manual_seed(smoothing_seed)
        self.updates = 0
        self._flat = {
            "critic_dqn": self._critic_dqn,
            "policy": self._policy,
            "target_critic_dqn": self._target_critic_dqn,
            "target_policy": self._target_policy,
        }
        self._optimizers = {"critic_dqn": self._critic_optimizer, "policy": self._policy_optimizer}
        self._earlier: Networks | None = None
        # Policy and critic must not share what both would read and write.
        if is_concurrent and not networks.shape.shared_convolutions:
            self._earlier = copy.deepcopy(self.networks).requires_grad_(False)
            self._earlier_critic_dqn = _flatten(self._earlier)[0]
        # A new thread computes on all cores, and so other bits, until it has read the process's number of threads.
        begin = torch.get_num_threads
        is_beside = self._earlier is not None and device.type == "cpu"
        self._threads = ThreadPoolExecutor(1, "policy", initializer=begin) if is_beside else None

    def close(self) -> None:
        """End the policy's thread; may be called again."""
        if self._threads is not None:
            self._threads.shutdown()

    def update(self, batches: Sequence[Batch], steps: int) -> list[Losses]:
        """An update from each batch, after so many training steps: Critic-DQN, every so often policy, soft targets."""
        self._decay_learning_rates(steps)
        self._raise_smoothness(steps)
        if self._earlier is None:
            return [self._update_both(batch) for batch in batches]
        return self._update_side_by_side(batches, self._earlier)

    def _update_both(self, batch: Batch) -> Losses:
        learned = self._update_critic_dqn(batch)
        if self.updates % self._config.policy_every == 0:
            learned["policy_loss"] = self._update_policy(batch, self.networks)
            self._target_policy.soft_update(self._policy, self._config.tau)
        self.updates += 1
        return learned

    def _update_side_by_side(self, batches: Sequence[Batch], earlier: Networks) -> list[Losses]:
        """The policy reads the earlier critic and the Critic-DQN the earlier π': neither sees the other at work."""
        self._earlier_critic_dqn.vector.copy_(self._critic_dqn.vector)
        due = [index for index in range(len(batches)) if (self.updates + index) % self._config.policy_every == 0]

        def update_policy() -> list[Tensor]:
            return [self._update_policy(batches[index], earlier) for index in due]

        if self._threads is None:
            losses = update_policy()
            learned = [self._update_critic_dqn(batch) for batch in batches]
        else:
            waiting = self._threads.submit(update_policy)
            try:
                learned = [self._update_critic_dqn(batch) for batch in batches]
            finally:
                losses = waiting.result()
        for index, loss in zip(due, losses, strict=True):
            learned[index]["policy_loss"] = loss
            self._target_policy.soft_update(self._policy, self._config.tau)
        self.updates += len(batches)
        return [*learned]

    def _update_critic_dqn(self, batch: Batch) -> dict[str, Tensor]:
        """Eq. 4, and the soft update of its target."""
        with self._set_precision():
            targets = bellman_targets(batch, self.networks, self.target, self._target_rule(batch))
            loss = critic_dqn_loss(batch, self.networks.features(batch.x), self.networks, targets)
        self._critic_dqn.backward(loss.total)
        self._critic_optimizer.step()
        self._target_critic_dqn.soft_update(self._critic_dqn, self._config.tau)
        learned = {
            "critic_loss": loss.critic.detach(),
            "td_error_policy": loss.td_errors[POLICY],
            "td_error_controller": loss.td_errors[CONTROLLER],
        }
        return learned if loss.switch is None else learned | {"switch_loss": loss.switch.detach()}

    def _update_policy(self, batch: Batch, critic: Networks) -> Tensor:
        """Eq. 5, by these networks' Q^A; returns the loss."""
        with self._set_precision():
            with torch.no_grad():
                features = critic.features(batch.x)
            objective = policy_loss(batch, features, self.networks, self._policy_terms, critic.critic)
        self._policy.backward(objective)
        self._policy_optimizer.step()
        return objective.detach()

    def _set_precision(self) -> AbstractContextManager[object]:
        """Of the hidden layers' products; weights, outputs, losses and optimisers are float32 in either precision."""
        if self._config.precision == "float32":
            return nullcontext()
        # Its cache of weights is one for all threads, and would be cleared by one at work in another.
        return torch.autocast(self._critic_dqn.vector.device.type, torch.bfloat16, cache_enabled=False)

    def _target_rule(self, batch: Batch) -> TargetRule:
        noise, sigma = None, self._config.target_noise
        if sigma:
            noise = torch.empty_like(batch.a).normal_(0.0, sigma, generator=self._smoothing)
            noise = noise.clamp_(-2.0 * sigma, 2.0 * sigma)
        return TargetRule(self._config.gamma, self._config.critic_follows_switch, noise)

    def _raise_smoothness(self, steps: int) -> None:
        weight = smoothness_scale(steps, self._total_steps) * self._config.smoothness
        self._policy_terms = self._policy_terms._replace(smoothness=weight)

    def _decay_learning_rates(self, steps: int) -> None:
        scale = learning_rate_scale(steps, self._total_steps, self._config.annealing)
        self._critic_optimizer.param_groups[0]["lr"] = scale * self._config.critic_learning_rate
        self._policy_optimizer.param_groups[0]["lr"] = scale * self._config.actor_learning_rate

    # Saving -------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """All that the next updates depend on: plain values and tensors."""
        return {
            "weights": {name: flat.vector.cpu() for name, flat in self._flat.items()},
            "optimizers": {name: _moments(optimizer) for name, optimizer in self._optimizers.items()},
            "smoothing": self._smoothing.get_state(),
            "updates": self.updates,
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned.

        Raises:
            KeyError, RuntimeError, ValueError: it is of another network.
        """
        for name, flat in self._flat.items():
            flat.load(state["weights"][name])
        for name, optimizer in self._optimizers.items():
            _load_moments(optimizer, state["optimizers"][name])
        self._smoothing.set_state(state["smoothing"])
        self.updates = state["updates"]

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
