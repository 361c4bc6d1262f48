"""The networks of the paper's Fig. 2: feature extraction, policy, Critic-DQN.

Shapes: B batch, O observation, F features, A action.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import torch
from torch import Tensor, nn

from asddpg.algorithm.layers import Convolution, Linear, Output, drawing_weights
from asddpg.algorithm.value_bins import ValueBins

POLICY, CONTROLLER = 0, 1  # columns of Q(x, σ)
NEAREST = 0.02  # share of the greatest range at which spread_near() begins to flatten; 0.11 m of 5.6 m


class NetworkShape(NamedTuple):
    """What the networks are built for.

    Attributes:
        observation_size: length of the flat observation.
        scan_shape: (scans, beams) at its head, which the convolutions see; None for a task without scans.
        action_low: smallest action, physical units.
        action_high: largest action, physical units.
        widths: of the fully connected layers, alike in policy and critic.
        layer_norm: whether the critic branch normalises each hidden layer.
        twin_critics: whether there are two critic branches (TD3).
        shared_convolutions: whether the policy looks through the Critic-DQN's convolutions, which Eq. 4 then trains.
        log_ranges: whether the convolutions see the logarithm of the ranges.
        value_bins: of the critic's values, their number and range, (bins, low, high); None for a single number.
    """

    observation_size: int
    scan_shape: tuple[int, int] | None
    action_low: Sequence[float]
    action_high: Sequence[float]
    widths: Sequence[int]
    layer_norm: bool = False
    twin_critics: bool = False
    shared_convolutions: bool = False
    log_ranges: bool = False
    value_bins: tuple[int, float, float] | None = None


def spread_near(scan: Tensor) -> Tensor:
    """The logarithm of a scan, r/max_range − 0.5, from −1 at an obstacle to 1 at the greatest range.

    Half a metre away a centimetre changes it five times as much as 3 m away; in the scan itself it is 0.002 everywhere.
    """
    return 1.0 + torch.log((scan + 0.5 + NEAREST).clamp(min=NEAREST)) * (-2.0 / math.log(NEAREST))


class Features(nn.Module):
    """Feature extraction: 1-D convolutions with ReLU over the stacked scans, next to the rest of the observation."""

    def __init__(self, observation_size: int, scan_shape: tuple[int, int] | None, log_ranges: bool = False) -> None:
        super().__init__()
        self.scan_shape, self.log_ranges = scan_shape, log_ranges
        if scan_shape is None:
            self.size = observation_size
            return
        scans, beams = scan_shape
        self.convolutions = nn.Sequential(
            Convolution(scans, 32, kernel=5, stride=2), nn.ReLU(), Convolution(32, 32, kernel=3, stride=2), nn.ReLU()
        )
        with torch.no_grad():
            extracted = self.convolutions(torch.zeros(1, beams, scans)).numel()
        self.size = extracted + observation_size - scans * beams

    def forward(self, observation: Tensor) -> Tensor:  # [B, O] → [B, F]
        """Features of observations."""
        if self.scan_shape is None:
            return observation
        scans, beams = self.scan_shape
        signal = observation[:, : scans * beams].view(-1, scans, beams).transpose(1, 2)
        extracted = self.convolutions(spread_near(signal) if self.log_ranges else signal)
        return torch.cat([extracted.flatten(1), observation[:, scans * beams :]], dim=1)


class PolicyHead(nn.Module):
    """Fully connected layers over the features, and π(x) from their outputs.

    An action from 0 up has a sigmoid, one of both signs a tanh; the sigmoid is tanh of half the input, over its own
    range.
    """

    middle: Tensor
    half_range: Tensor
    steepness: Tensor

    def __init__(self, shape: NetworkShape, features: int) -> None:
        super().__init__()
        self.hidden = mlp([features, *shape.widths])
        self.out = small_linear(shape.widths[-1], len(shape.action_low))
        low, high = torch.tensor(shape.action_low), torch.tensor(shape.action_high)
        self.register_buffer("middle", (high + low) / 2, persistent=False)
        self.register_buffer("half_range", (high - low) / 2, persistent=False)
        self.register_buffer("steepness", torch.where(low >= 0.0, 0.5, 1.0), persistent=False)

    def forward(self, features: Tensor) -> Tensor:  # [B, F] → [B, A], before tanh
        """The outputs for the features of x."""
        outputs: Tensor = self.out(self.hidden(features)) * self.steepness
        return outputs

    def squash(self, outputs: Tensor) -> Tensor:  # [B, A], before tanh → [B, A], physical units
        """π(x) from the outputs for x."""
        return self.middle + self.half_range * torch.tanh(outputs)

    def clip(self, action: Tensor) -> Tensor:  # [B, A] → [B, A], physical units
        """The nearest action within the bounds."""
        low, high = self.middle - self.half_range, self.middle + self.half_range
        return torch.minimum(torch.maximum(action, low), high)


class CriticBranch(nn.Module):
    """Q^A(x, a): the action joins at the second layer; no activation at the output.

    Attributes:
        bins: over which the value is a distribution; None where the output is the value.
    """

    middle: Tensor
    half_range: Tensor

    def __init__(self, shape: NetworkShape, features: int) -> None:
        super().__init__()
        widths = shape.widths
        self.first = mlp([features, widths[0]], shape.layer_norm)
        self.rest = mlp([widths[0] + len(shape.action_low), *widths[1:]], shape.layer_norm)
        bins = shape.value_bins
        self.bins = ValueBins(*bins) if bins else None
        self.out = small_linear(widths[-1], bins[0] if bins else 1)
        low, high = torch.tensor(shape.action_low), torch.tensor(shape.action_high)
        self.register_buffer("middle", (high + low) / 2, persistent=False)
        self.register_buffer("half_range", (high - low) / 2, persistent=False)

    def forward(self, features: Tensor, action: Tensor) -> Tensor:  # [B, F], [B, A] → [B]
        """Q^A(x, a) from the features of x."""
        return self.value_from_hidden(self.first(features), action)

    def value_from_hidden(self, first: Tensor, action: Tensor) -> Tensor:  # [B, widths[0]], [B, A] → [B]
        """Q^A(x, a) from the first layer's output, which several actions at one x may share."""
        outputs = self._outputs(first, action)
        return self.bins.mean(outputs) if self.bins else outputs.squeeze(1)

    def loss(self, features: Tensor, action: Tensor, targets: Tensor) -> tuple[Tensor, Tensor]:
        """Of Q^A(x, a) against targets, [B], Eq. 4's squared error or cross-entropy over bins; and Q^A(x, a), [B]."""
        outputs = self._outputs(self.first(features), action)
        if self.bins:
            with torch.no_grad():
                q = self.bins.mean(outputs)
            return self.bins.cross_entropy(outputs, targets), q
        q = outputs.squeeze(1)
        return torch.square(targets - q).mean(), q.detach()

    def _outputs(self, first: Tensor, action: Tensor) -> Tensor:
        scaled = (action - self.middle) / self.half_range
        outputs: Tensor = self.out(self.rest(torch.cat([first, scaled], dim=1)))
        return outputs


class SwitchBranch(nn.Module):
    """Q(x, σ), dueling: V(x) + advantage of each σ less their mean (Wang et al., 2015)."""

    def __init__(self, shape: NetworkShape, features: int) -> None:
        super().__init__()
        self.hidden = mlp([features, *shape.widths])
        self.out = small_linear(shape.widths[-1], 3)

    def forward(self, features: Tensor) -> Tensor:  # [B, F] → [B, 2], columns POLICY, CONTROLLER
        """Q(x, σ) from the features of x."""
        return self.value_and_q(features)[1]

    def value_and_q(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """V(x), [B], and Q(x, σ), [B, 2]."""
        value, advantage = self.out(self.hidden(features)).split((1, 2), dim=1)
        return value.squeeze(1), value + advantage - advantage.mean(dim=1, keepdim=True)


class Networks(nn.Module):
    """Everything that has a target: policy, critic branch and, where there is a controller, switch branch.

    Policy and Critic-DQN have convolutions of their own, the branches of the Critic-DQN share theirs: the paper draws
    one feature extraction before all three and does not say which gradient trains it. With `shared_convolutions` there
    is one, and Eq. 4 trains it.
    """

    def __init__(self, shape: NetworkShape, with_switch: bool) -> None:
        super().__init__()
        self.shape = shape
        own = not shape.shared_convolutions
        seen = shape.observation_size, shape.scan_shape, shape.log_ranges
        self.policy_features = Features(*seen) if own else None
        self.features = Features(*seen)
        self.policy_head = PolicyHead(shape, self.features.size)
        self.critic = CriticBranch(shape, self.features.size)
        self.switch = SwitchBranch(shape, self.features.size) if with_switch else None
        self.critic_twin = CriticBranch(shape, self.features.size) if shape.twin_critics else None

    def policy(self, observation: Tensor) -> Tensor:  # [B, O] → [B, A], physical units
        """π(x)."""
        return self.policy_head.squash(self.policy_outputs(observation))

    def policy_outputs(self, observation: Tensor) -> Tensor:  # [B, O] → [B, A], before tanh
        """The policy's outputs, of which tanh makes π(x)."""
        if self.policy_features is not None:
            features = self.policy_features(observation)
        else:
            features = self.features(observation).detach()
        outputs: Tensor = self.policy_head(features)
        return outputs

    def policy_parameters(self) -> list[nn.Parameter]:
        """What Eq. 5 trains."""
        return [parameter for name, parameter in self.named_parameters() if name.startswith("policy")]

    def critic_dqn_parameters(self) -> list[nn.Parameter]:
        """What Eq. 4 trains."""
        return [parameter for name, parameter in self.named_parameters() if not name.startswith("policy")]


def branch_size(shape: NetworkShape) -> int:
    """Number of weights in the hidden layers of one branch, computed without allocating them."""
    with drawing_weights():
        features = Features(shape.observation_size, shape.scan_shape).size
    return sum(fan_in * fan_out for fan_in, fan_out in pairwise([features, *shape.widths]))


def mlp(sizes: Sequence[int], layer_norm: bool = False) -> nn.Sequential:
    """Fully connected layers, each followed by ReLU, with an optional normalisation between."""
    layers: list[nn.Module] = []
    for fan_in, fan_out in pairwise(sizes):
        layers += [Linear(fan_in, fan_out), *([nn.LayerNorm(fan_out)] if layer_norm else []), nn.ReLU()]
    return nn.Sequential(*layers)


def small_linear(fan_in: int, fan_out: int) -> Output:
    """An output layer with weights within ±0.003, so that first actions and values are near the middle (DDPG)."""
    return Output(fan_in, fan_out, bound=3e-3)
