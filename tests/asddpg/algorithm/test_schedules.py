"""The schedule that takes the controller away."""

import numpy as np
import pytest
import torch

from asddpg.algorithm.schedules import Withdrawal, smoothness_scale
from asddpg.config import WithdrawalConfig
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Driver
from tests.asddpg.algorithm.test_agent import Identity, Perfect, make_agent
from tests.support.one_agent import ROBOT, OneAgent


def schedule(stretch_steps: int = 0, first: float = 0.0, last: float = 1.0) -> Withdrawal:
    config = WithdrawalConfig(first, last, begin=0.25, end=0.75, stretch_steps=stretch_steps)
    return Withdrawal(config, 400, np.random.default_rng(0))


def test_the_share_goes_linearly_from_first_to_last() -> None:
    withdrawal, shares = schedule(first=0.2, last=0.8), []
    for _ in range(401):
        shares.append(withdrawal.share)
        withdrawal.advance()
    assert shares[0] == shares[100] == pytest.approx(0.2)
    assert shares[200] == pytest.approx(0.5)
    assert shares[300] == shares[400] == pytest.approx(0.8)
    assert np.all(np.diff(shares) >= 0.0)


def test_episodes_are_drawn_by_the_share() -> None:
    withdrawal = schedule(first=0.3)
    drawn = []
    for _ in range(2000):
        withdrawal.begin_episodes(ROBOT)
        drawn.append(bool(withdrawal.is_alone[0]))
    assert np.mean(drawn) == pytest.approx(0.3, abs=0.04)


def test_stretches_change_within_an_episode() -> None:
    whole, stretches = schedule(first=0.5, last=0.5), schedule(stretch_steps=10, first=0.5, last=0.5)
    for withdrawal, can_change in ((whole, False), (stretches, True)):
        withdrawal.begin_episodes(ROBOT)
        seen = []
        for _ in range(200):
            seen.append(bool(withdrawal.is_alone[0]))
            withdrawal.advance()
        assert (len(set(seen)) == 2) is can_change
        changes = np.flatnonzero(np.diff(seen)) + 1
        assert np.all(changes % 10 == 0)


def test_once_withdrawn_the_actor_drives_every_step_though_the_switch_would_not() -> None:
    agent = make_agent(Perfect())
    assert agent.networks.switch is not None
    agent.networks.switch.out.bias.data[2] += 1.0  # the controller's advantage
    assert agent.decide(np.zeros((1, 3), dtype=np.float32)).by_controller[0]
    agent._withdrawal.is_alone[0] = True
    assert not agent.decide(np.zeros((1, 3), dtype=np.float32)).by_controller[0]
    # The schedule does not change how the switched policy drives once trained.
    assert agent.decide_greedily(np.zeros(3, dtype=np.float32)).driver is Driver.CONTROLLER


def test_the_controller_drives_less_and_less_and_in_the_end_not_at_all() -> None:
    agent = make_agent(Perfect(), withdrawal=WithdrawalConfig(last_share=1.0), imitation=0.0)
    agent.learner._update_policy = lambda *_: torch.zeros(())  # type: ignore[method-assign]
    environment, shares = Identity(seed=0), []
    while agent.steps < 3000:  # the schedule of make_agent goes from step 1000 to 2000
        shares.append(run_episode(environment, OneAgent(agent)).controller_share)
    assert np.mean(shares[50:100]) > 0.5
    assert 0.05 < np.mean(shares[120:180]) < np.mean(shares[50:100])
    assert np.mean(shares[200:]) == 0.0


def test_annealing_brings_adams_steps_to_zero_at_the_end() -> None:
    agent = make_agent(None, annealing=0.5)
    environment = Identity(seed=0)
    rates = []
    while agent.steps < 3000:
        run_episode(environment, OneAgent(agent))
        rates.append(agent.learner._policy_optimizer.param_groups[0]["lr"])
    at = [rates[step // 10 - 1] for step in (1500, 2250, 3000)]
    np.testing.assert_allclose(at, [1e-3, 0.5e-3, 0.0], atol=1e-5)
    run_episode(environment, OneAgent(agent))  # past its end training stands still, and does not climb the loss
    assert agent.learner._policy_optimizer.param_groups[0]["lr"] == 0.0


def test_smoothness_waits_and_then_grows_to_its_full_weight() -> None:
    assert [smoothness_scale(step, 100) for step in (0, 20, 40, 60, 100)] == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
