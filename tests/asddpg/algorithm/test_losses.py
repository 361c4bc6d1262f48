"""Eqs. 4 and 5 against an independent NumPy float64 version."""

import copy
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
import torch

from asddpg.algorithm.flat import FlatParameters
from asddpg.algorithm.losses import (
    Batch,
    PolicyTerms,
    TargetRule,
    Targets,
    advantage,
    bellman_targets,
    critic_dqn_loss,
    policy_loss,
)
from asddpg.algorithm.networks import CONTROLLER, POLICY, Networks, NetworkShape, spread_near
from asddpg.algorithm.value_bins import ValueBins
from tests.support.reference_equations import F64, Reference

SCANS = (3, 40)
SIZE = 124
LOW, HIGH = np.array([0.0, -np.pi / 3]), np.array([0.5, np.pi / 3])
GAMMA = 0.99
SEEDS = pytest.mark.parametrize("seed", range(5))


DTYPES = pytest.mark.parametrize("dtype", [torch.float64, torch.float32], ids=["float64", "float32"])


def make_networks(seed: int, with_switch: bool = True, dtype: torch.dtype = torch.float64, **options: Any) -> Networks:
    torch.manual_seed(seed)
    shape = NetworkShape(SIZE, SCANS, LOW.tolist(), HIGH.tolist(), (32, 24, 16), **options)
    networks = Networks(shape, with_switch).to(dtype)
    with torch.no_grad():  # output layers begin so small that a mistake in them would not show
        for parameter in networks.parameters():
            parameter.add_(0.1 * torch.randn_like(parameter))
    return networks


def make_batch(seed: int, size: int = 32, dtype: torch.dtype = torch.float64) -> Batch:
    """Random transitions: a third ends, a third time limits, a third in between; both drivers."""
    rng = np.random.default_rng(seed)
    discount = rng.permutation(np.resize([0.0, 1.0, 1.0], size))
    parts = (
        rng.uniform(-0.5, 0.5, (size, SIZE)),
        rng.uniform(LOW, HIGH, (size, 2)),
        rng.normal(size=size),
        rng.normal(size=size),
        discount,
        rng.integers(0, 2, size).astype(float),
        rng.uniform(-0.5, 0.5, (size, SIZE)),
        rng.uniform(LOW, HIGH, (size, 2)),
    )
    return Batch(*(torch.from_numpy(part).to(dtype) for part in parts))


def reference_of(networks: Networks) -> Reference:
    weights = {
        name: value.detach().numpy().astype(np.float64, copy=False) for name, value in networks.named_parameters()
    }
    return Reference(weights, SCANS, LOW, HIGH)


def arrays(batch: Batch) -> tuple[F64, ...]:
    return tuple(part.numpy().astype(np.float64) for part in batch)


def reference_targets(batch: Batch, online: Reference, target: Reference) -> tuple[F64, F64]:
    _, _, r, r_switch, discount, _, x_next, _ = arrays(batch)
    y_a = r + GAMMA * discount * target.q_a(x_next, target.policy(x_next))
    chosen = online.v_and_q(x_next)[1].argmax(axis=1)
    y_q = r_switch + GAMMA * discount * target.v_and_q(x_next)[1][np.arange(len(r)), chosen]
    return y_a, y_q


@SEEDS
@DTYPES
def test_targets_equal_the_reference(seed: int, dtype: torch.dtype) -> None:
    online, target = make_networks(seed, dtype=dtype), make_networks(seed + 100, dtype=dtype)
    batch = make_batch(seed, dtype=dtype)
    targets = bellman_targets(batch, online, target, TargetRule(GAMMA))
    y_a, y_q = reference_targets(batch, reference_of(online), reference_of(target))
    # In float32 a target is a sum of numbers about 1, so that one near 0 is exact only to their rounding.
    rounding = 1e-6 if dtype is torch.float32 else 0.0
    np.testing.assert_allclose(targets.y_a.numpy(), y_a, rtol=1e-5, atol=rounding)
    assert targets.y_q is not None
    np.testing.assert_allclose(targets.y_q.numpy(), y_q, rtol=1e-5, atol=rounding)


@SEEDS
def test_the_critic_may_follow_the_switch(seed: int) -> None:
    online, target, batch = make_networks(seed), make_networks(seed + 100), make_batch(seed)
    targets = bellman_targets(batch, online, target, TargetRule(GAMMA, follow_switch=True))
    _, y_q = reference_targets(batch, reference_of(online), reference_of(target))
    _, _, r, r_switch, *_ = arrays(batch)
    np.testing.assert_allclose(targets.y_a.numpy(), y_q - r_switch + r, rtol=1e-5)


def twin_reference(networks: Networks) -> Reference:
    """The reference with the twin critic in the first one's place."""
    reference = reference_of(networks)
    twin = {name: value for name, value in reference.weights.items() if name.startswith("critic_twin")}
    renamed = {name.replace("critic_twin", "critic"): value for name, value in twin.items()}
    return Reference({**reference.weights, **renamed}, SCANS, LOW, HIGH)


@SEEDS
def test_of_twin_critics_the_smaller_one_bootstraps_and_both_learn(seed: int) -> None:
    online, target = (make_networks(seed + offset, twin_critics=True) for offset in (0, 100))
    batch = make_batch(seed)
    targets = bellman_targets(batch, online, target, TargetRule(GAMMA))
    x, a, r, _, discount, _, x_next, _ = arrays(batch)
    first, second = reference_of(target), twin_reference(target)
    action = first.policy(x_next)
    y_a = r + GAMMA * discount * np.minimum(first.q_a(x_next, action), second.q_a(x_next, action))
    np.testing.assert_allclose(targets.y_a.numpy(), y_a, rtol=1e-5)
    loss = critic_dqn_loss(batch, online.features(batch.x), online, targets)
    errors = [np.mean((y_a - reference.q_a(x, a)) ** 2) for reference in (reference_of(online), twin_reference(online))]
    np.testing.assert_allclose(loss.critic.item(), sum(errors), rtol=1e-5)


@SEEDS
def test_over_bins_the_critic_learns_by_cross_entropy(seed: int) -> None:
    bins, low, high = 51, -5.0, 5.0
    online = make_networks(seed, value_bins=(bins, low, high))
    batch = make_batch(seed)
    targets = Targets(torch.linspace(-6.0, 6.0, len(batch.r), dtype=torch.float64), None)
    loss = critic_dqn_loss(batch, online.features(batch.x), online, targets)
    outputs = online.critic._outputs(online.critic.first(online.features(batch.x)), batch.a).detach().numpy()
    width = (high - low) / (bins - 4)
    edges = low - 2 * width + width * np.arange(bins + 1)
    logs = outputs - np.log(np.exp(outputs).sum(axis=1, keepdims=True))
    expected = []
    for y, log in zip(np.clip(targets.y_a.numpy(), low, high), logs, strict=True):
        shares = np.diff([NormalDist(y, 0.75 * width).cdf(edge) for edge in edges])
        expected.append(-(shares / shares.sum()) @ log)
    np.testing.assert_allclose(loss.critic.item(), np.mean(expected), rtol=1e-5)
    means = np.exp(logs) @ (edges[1:] + edges[:-1]) / 2
    np.testing.assert_allclose(online.critic(online.features(batch.x), batch.a).detach().numpy(), means, atol=1e-5)


def test_bins_give_back_the_values_that_they_learn() -> None:
    bins = ValueBins(51, -5.0, 5.0)
    values = torch.linspace(-5.0, 5.0, 41)
    torch.testing.assert_close(bins.mean(torch.log(bins.shares(values) + 1e-30)), values, atol=0.01, rtol=0.0)


@pytest.mark.parametrize("wrong", [(4, -5.0, 5.0), (10**9, -5.0, 5.0), (51, 5.0, 5.0)])
def test_bins_that_no_file_of_ours_has_are_refused_before_they_take_memory(wrong: tuple[int, float, float]) -> None:
    with pytest.raises(ValueError, match="bins from"):
        make_networks(0, value_bins=wrong)


def test_the_logarithm_spreads_near_ranges() -> None:
    near, far = (spread_near(torch.tensor([r, r + 0.01]) / 5.6 - 0.5).diff().item() for r in (0.5, 3.0))
    assert near > 4.5 * far > 0.0
    torch.testing.assert_close(spread_near(torch.tensor([-0.5, 0.5])), torch.tensor([-1.0, 1.01]), atol=0.01, rtol=0.0)


def test_both_convolutions_see_the_logarithm() -> None:
    linear, log = (make_networks(0, log_ranges=log_ranges) for log_ranges in (False, True))
    x = make_batch(0).x
    seen = torch.cat([spread_near(x[:, :120]), x[:, 120:]], dim=1)
    torch.testing.assert_close(log.policy(x), linear.policy(seen))
    torch.testing.assert_close(log.features(x), linear.features(seen))


def test_target_smoothing_moves_the_target_action_within_its_bounds() -> None:
    online, target, batch = make_networks(0), make_networks(1), make_batch(0)
    noise = torch.full_like(batch.a, 10.0)
    targets = bellman_targets(batch, online, target, TargetRule(GAMMA, noise=noise))
    _, _, r, _, discount, _, x_next, _ = arrays(batch)
    y_a = r + GAMMA * discount * reference_of(target).q_a(x_next, np.tile(HIGH, (len(r), 1)))
    np.testing.assert_allclose(targets.y_a.numpy(), y_a, rtol=1e-5)


def test_shared_convolutions_are_trained_by_the_critic_alone() -> None:
    networks = make_networks(0, shared_convolutions=True)
    names = {id(parameter): name for name, parameter in networks.named_parameters()}
    policy = {names[id(parameter)] for parameter in networks.policy_parameters()}
    critic = {names[id(parameter)] for parameter in networks.critic_dqn_parameters()}
    assert any(name.startswith("features.") for name in critic)
    assert all(name.startswith("policy_head.") for name in policy)
    batch = make_batch(0)
    objective = policy_loss(batch, networks.features(batch.x).detach(), networks)
    gradients = torch.autograd.grad(objective, list(networks.features.parameters()), allow_unused=True)
    assert gradients == (None,) * len(gradients)


@SEEDS
@DTYPES
def test_loss_equals_the_reference(seed: int, dtype: torch.dtype) -> None:
    online, target = make_networks(seed, dtype=dtype), make_networks(seed + 100, dtype=dtype)
    batch = make_batch(seed, dtype=dtype)
    targets = bellman_targets(batch, online, target, TargetRule(GAMMA))
    loss = critic_dqn_loss(batch, online.features(batch.x), online, targets)
    reference = reference_of(online)
    y_a, y_q = reference_targets(batch, reference, reference_of(target))
    x, a, _, _, _, sigma, *_ = arrays(batch)
    q = reference.v_and_q(x)[1]
    q_taken = np.where(sigma == 1.0, q[:, POLICY], q[:, CONTROLLER])
    expected_critic = np.mean((y_a - reference.q_a(x, a)) ** 2)
    expected_switch = np.mean((y_q - q_taken) ** 2)
    errors = np.abs(y_a - reference.q_a(x, a))
    expected_errors = [errors[sigma == 1].mean(), errors[sigma == 0].mean()]
    np.testing.assert_allclose(loss.td_errors.numpy(), expected_errors, rtol=1e-5)  # which needs no gradient
    assert loss.switch is not None
    np.testing.assert_allclose(loss.critic.item(), expected_critic, rtol=1e-5)
    np.testing.assert_allclose(loss.switch.item(), expected_switch, rtol=1e-5)
    np.testing.assert_allclose(loss.total.item(), expected_critic + expected_switch, rtol=1e-5)


@SEEDS
def test_policy_gradient_equals_the_chain_rule_in_the_reference(seed: int) -> None:
    """∇_θ J = mean ∇_a Q^A · ∇_θ π, each factor by central differences of the reference."""
    online, batch = make_networks(seed), make_batch(seed, size=6)
    features = online.features(batch.x).detach()
    parameters = online.policy_parameters()
    gradients = torch.autograd.grad(policy_loss(batch, features, online), parameters)
    reference, x, eps = reference_of(online), batch.x.numpy(), 1e-6
    actions = reference.policy(x)
    dq_da = np.zeros_like(actions)
    for index in range(2):
        shift = np.eye(2)[index] * eps
        dq_da[:, index] = (reference.q_a(x, actions + shift) - reference.q_a(x, actions - shift)) / (2 * eps)
    rng = np.random.default_rng(seed)
    for parameter, gradient in zip(parameters, gradients, strict=True):
        values = parameter.detach().numpy()  # the reference sees the same memory
        for _ in range(10):
            entry = tuple(rng.integers(size) for size in values.shape)
            kept = values[entry]
            values[entry] = kept + eps
            above = reference.policy(x)
            values[entry] = kept - eps
            below = reference.policy(x)
            values[entry] = kept
            expected = -np.mean(np.sum(dq_da * (above - below) / (2 * eps), axis=1))
            np.testing.assert_allclose(gradient.numpy()[entry], expected, rtol=1e-5, atol=1e-9)


@SEEDS
def test_gradient_of_the_advantage_is_the_gradient_of_q(seed: int) -> None:
    """Eq. 5 names ∇_a A; V(x) does not depend on a, so it is ∇_a Q^A."""
    online, batch = make_networks(seed), make_batch(seed)
    features = online.features(batch.x).detach()
    action = batch.a.clone().requires_grad_()
    (of_advantage,) = torch.autograd.grad(advantage(features, action, online).sum(), action)
    (of_q,) = torch.autograd.grad(online.critic(features, action).sum(), action)
    torch.testing.assert_close(of_advantage, of_q, rtol=0.0, atol=0.0)
    assert torch.all(of_q.abs().sum(dim=1) > 0)


@SEEDS
def test_imitation_counts_where_the_critic_prefers_the_controller(seed: int) -> None:
    online, batch = make_networks(seed), make_batch(seed)
    reference, x, controller = reference_of(online), batch.x.numpy(), batch.controller_action.numpy()
    action = reference.policy(x)
    preferred = reference.q_a(x, controller) > reference.q_a(x, action)
    assert 0 < preferred.sum() < len(x)
    distance = np.sum(((action - controller) / ((HIGH - LOW) / 2)) ** 2, axis=1)
    expected = 0.7 * np.mean(preferred * distance) - np.mean(reference.q_a(x, action))
    found = policy_loss(batch, online.features(batch.x).detach(), online, PolicyTerms(imitation=0.7))
    np.testing.assert_allclose(found.item(), expected, rtol=1e-5)


@SEEDS
def test_saturation_counts_beyond_three_before_tanh(seed: int) -> None:
    online, batch = make_networks(seed), make_batch(seed)
    with torch.no_grad():  # so that half of the outputs lie beyond
        scale = 3.0 / online.policy_outputs(batch.x).abs().median()
        online.policy_head.out.weight.mul_(scale)
        online.policy_head.out.bias.mul_(scale)
    features = online.features(batch.x).detach()
    outputs = online.policy_outputs(batch.x).detach().numpy()
    assert 0 < (np.abs(outputs) > 3.0).sum() < outputs.size
    expected = 0.5 * np.mean(np.sum(np.maximum(np.abs(outputs) - 3.0, 0.0) ** 2, axis=1))
    alone = policy_loss(batch, features, online).item()
    found = policy_loss(batch, features, online, PolicyTerms(saturation=0.5)).item()
    np.testing.assert_allclose(found - alone, expected, rtol=1e-5)


@SEEDS
def test_smoothness_is_the_squared_change_of_the_action_to_the_next_state(seed: int) -> None:
    online, batch = make_networks(seed), make_batch(seed)
    features, half = online.features(batch.x).detach(), online.policy_head.half_range
    with torch.no_grad():
        change = ((online.policy(batch.x_next) - online.policy(batch.x)) / half).numpy()
    alone = policy_loss(batch, features, online).item()
    found = policy_loss(batch, features, online, PolicyTerms(smoothness=0.5)).item()
    assert found > alone
    np.testing.assert_allclose(found - alone, 0.5 * np.mean(np.sum(change**2, axis=1)), rtol=1e-5)


def test_a_policy_at_its_bounds_learns_again_with_the_saturation_loss_alone() -> None:
    """From outputs of 30 on tanh has no slope in float32: Eq. 5 by itself moves nothing."""
    for weight, learns in ((0.0, False), (0.01, True)):
        online, batch = make_networks(0, dtype=torch.float32), make_batch(0, dtype=torch.float32)
        with torch.no_grad():
            online.policy_head.out.bias.fill_(60.0)
        before = online.policy_outputs(batch.x).detach()
        optimizer = torch.optim.Adam(online.policy_parameters(), lr=1e-3)
        for _ in range(100):
            optimizer.zero_grad()
            features = online.features(batch.x).detach()
            torch.autograd.backward(policy_loss(batch, features, online, PolicyTerms(saturation=weight)))
            optimizer.step()
        assert bool((online.policy_outputs(batch.x) < before - 1.0).all()) == learns


def test_advantage_is_q_less_v() -> None:
    online, batch = make_networks(0), make_batch(0)
    reference = reference_of(online)
    found = advantage(online.features(batch.x), batch.a, online).detach().numpy()
    x, a, *_ = arrays(batch)
    np.testing.assert_allclose(found, reference.q_a(x, a) - reference.v_and_q(x)[0], rtol=1e-5)


def test_flat_gradient_is_autograds() -> None:
    online, target, batch = make_networks(0), make_networks(1), make_batch(0)
    twin = copy.deepcopy(online)
    targets = bellman_targets(batch, online, target, TargetRule(GAMMA))
    flat = FlatParameters(online.critic_dqn_parameters())
    flat.backward(critic_dqn_loss(batch, online.features(batch.x), online, targets).total)
    critic_dqn_loss(batch, twin.features(batch.x), twin, targets).total.backward()  # type: ignore[no-untyped-call]
    expected = torch.cat([p.grad.reshape(-1) for p in twin.critic_dqn_parameters() if p.grad is not None])
    assert flat.vector.grad is not None
    torch.testing.assert_close(flat.vector.grad, expected)


def test_without_a_switch_there_is_one_loss() -> None:
    online, target, batch = make_networks(0, with_switch=False), make_networks(1, with_switch=False), make_batch(0)
    targets = bellman_targets(batch, online, target, TargetRule(GAMMA))
    loss = critic_dqn_loss(batch, online.features(batch.x), online, targets)
    assert targets.y_q is None
    assert loss.switch is None
    assert loss.total is loss.critic
