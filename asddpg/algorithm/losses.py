"""The equations of the paper, in its notation. Shapes: B batch, O observation, A action."""

from typing import NamedTuple

import torch
from torch import Tensor

from asddpg.algorithm.networks import CONTROLLER, POLICY, CriticBranch, Networks
from asddpg.algorithm.replay import TransitionLayout


class Batch(NamedTuple):
    """Transitions (x, a, r, σ, x') and the discount of what follows, 0 after an end; in the order of Transitions."""

    x: Tensor  # [B, O]
    a: Tensor  # [B, A]
    r: Tensor  # [B], of y^A
    r_switch: Tensor  # [B], of y^Q
    discount: Tensor  # [B]
    by_policy: Tensor  # [B], σ
    x_next: Tensor  # [B, O]
    controller_action: Tensor  # [B, A]

    @classmethod
    def unpack(cls, rows: Tensor, layout: TransitionLayout) -> "Batch":
        """Views of packed rows, [B, layout.width]."""
        return cls(*(rows[:, columns] for columns in layout))


class Targets(NamedTuple):
    """y^A and y^Q of Eq. 4, each [B]; y^Q is None without a switch."""

    y_a: Tensor
    y_q: Tensor | None


class TargetRule(NamedTuple):
    """How y^A and y^Q bootstrap; the defaults are the paper's Eq. 4.

    Attributes:
        gamma: γ.
        follow_switch: whether Q^A bootstraps from the switch's value and not from its own.
        noise: of target smoothing, [B, A], in units of half an action's range; None without smoothing.
    """

    gamma: float
    follow_switch: bool = False
    noise: Tensor | None = None


@torch.no_grad()
def bellman_targets(batch: Batch, online: Networks, target: Networks, rule: TargetRule) -> Targets:
    """Eq. 4, first two lines.

    y^A = r + γ Q^A'(x', π'(x')),  y^Q = r + γ Q'(x', argmax_σ Q(x', σ)): the online switch chooses, the target switch
    rates (double DQN). After the end of an episode nothing is added; after a time limit the value is.

    With `follow_switch`, y^A takes the value that y^Q takes. With twin critics Q^A' is the smaller of the two, and with
    `noise` π' is smoothed (TD3, Fujimoto et al., 2018).
    """
    gamma_next = rule.gamma * batch.discount
    next_features = target.features(batch.x_next)
    y_q = None
    if online.switch is not None and target.switch is not None:
        sigma = online.switch(online.features(batch.x_next)).argmax(dim=1, keepdim=True)
        next_value = gamma_next * target.switch(next_features).gather(1, sigma).squeeze(1)
        y_q = batch.r_switch + next_value
        if rule.follow_switch:
            return Targets(batch.r + next_value, y_q)
    y_a = batch.r + gamma_next * _actor_value(batch.x_next, next_features, target, rule.noise)
    return Targets(y_a, y_q)


def _actor_value(x: Tensor, features: Tensor, target: Networks, noise: Tensor | None) -> Tensor:
    """Q^A'(x, π'(x)), [B]."""
    action = target.policy(x)
    if noise is not None:
        action = target.policy_head.clip(action + noise * target.policy_head.half_range)
    value: Tensor = target.critic(features, action)
    return value if target.critic_twin is None else torch.minimum(value, target.critic_twin(features, action))


class CriticLoss(NamedTuple):
    """Eq. 4's L, its two parts, and |y^A − Q^A| by driver, [2], columns POLICY, CONTROLLER."""

    total: Tensor
    critic: Tensor
    switch: Tensor | None
    td_errors: Tensor


def critic_dqn_loss(batch: Batch, features: Tensor, online: Networks, targets: Targets) -> CriticLoss:
    """Eq. 4, last line: L = mean (y^A − Q^A(x, a))² + mean (y^Q − Q(x, σ))²; `features` are the online ones of x.

    A twin critic adds its own (y^A − Q^A(x, a))². Over bins, cross-entropy stands in place of these squares.
    """
    critic, q_a = online.critic.loss(features, batch.a, targets.y_a)
    td_errors = mean_by_driver((targets.y_a - q_a).abs(), batch.by_policy)
    if online.critic_twin is not None:
        critic = critic + online.critic_twin.loss(features, batch.a, targets.y_a)[0]
    if online.switch is None or targets.y_q is None:
        return CriticLoss(critic, critic, None, td_errors)
    q = online.switch(features)
    q_taken = torch.where(batch.by_policy > 0.5, q[:, POLICY], q[:, CONTROLLER])
    switch = torch.square(targets.y_q - q_taken).mean()
    return CriticLoss(critic + switch, critic, switch, td_errors)


def mean_by_driver(values: Tensor, by_policy: Tensor) -> Tensor:
    """Means of values, [B], over samples of POLICY and of CONTROLLER: [2], NaN for a driver without samples."""
    origin = torch.stack([by_policy, 1.0 - by_policy])
    return origin @ values / origin.sum(dim=1)


class PolicyTerms(NamedTuple):
    """Weights of what is added to Eq. 5, 0 for what is not.

    Attributes:
        imitation: of the squared distance to the controller's action, in units of half an action's range, on those
            samples where Q^A rates it above its own: "the policy network can improve itself either by imitating the
            external controller or by examining its own policy" (caption of Fig. 1).
        saturation: of the squared distance by which the magnitude of an output before tanh exceeds SATURATED. Far
            beyond, tanh has no slope and Eq. 5 no gradient: a policy that has come to circle there goes on for ever.
        smoothness: of the squared change of the action from x to x', in units of half an action's range: the temporal
            term of CAPS (Mysore et al., 2021). With n-step returns x' lies n steps ahead.
    """

    imitation: float = 0.0
    saturation: float = 0.0
    smoothness: float = 0.0


EQ_5 = PolicyTerms()
SATURATED = 3.0  # tanh is within 0.005 of its limit


def policy_loss(
    batch: Batch, features: Tensor, online: Networks, terms: PolicyTerms = EQ_5, critic: CriticBranch | None = None
) -> Tensor:
    """Eq. 5: the policy ascends A(x, π(x)) = Q^A(x, π(x)) − V(x).

    V does not depend on the action, so ∇_a A = ∇_a Q^A and V need not be computed; tests compare the two gradients.

    Args:
        batch: transitions; only x and the controller's actions are used.
        features: the Critic-DQN's, of x, [B, F], without gradient: Eq. 5 trains the policy alone.
        online: the networks.
        terms: what is added to Eq. 5.
        critic: Q^A; None takes the online one.
    """
    critic = critic or online.critic
    with torch.no_grad():
        first = critic.first(features)
    outputs = online.policy_outputs(batch.x)
    action = online.policy_head.squash(outputs)
    q: Tensor = critic.value_from_hidden(first, action)
    loss = -q.mean()
    if terms.imitation:
        with torch.no_grad():
            is_better = critic.value_from_hidden(first, batch.controller_action) > q
        distance = torch.square((action - batch.controller_action) / online.policy_head.half_range).sum(dim=1)
        loss = terms.imitation * (is_better * distance).mean() + loss
    if terms.saturation:
        excess = torch.relu(outputs.abs() - SATURATED)
        loss = terms.saturation * torch.square(excess).sum(dim=1).mean() + loss
    if terms.smoothness:
        change = (online.policy(batch.x_next) - action) / online.policy_head.half_range
        loss = terms.smoothness * torch.square(change).sum(dim=1).mean() + loss
    return loss


def advantage(features: Tensor, action: Tensor, online: Networks) -> Tensor:
    """A(x, a) = Q^A(x, a) − V(x), [B], with V of the dueling switch branch (section IV-B)."""
    if online.switch is None:
        raise ValueError("without a switch branch there is no V(x), and so no advantage")
    value, _ = online.switch.value_and_q(features)
    q: Tensor = online.critic(features, action)
    return q - value
