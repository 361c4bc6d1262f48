"""What AsDDPG does, seen from outside."""

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch

from asddpg.algorithm.agent import AsDDPG
from asddpg.algorithm.controllers import Controllers, ProportionalController
from asddpg.algorithm.exploration import OrnsteinUhlenbeckNoise
from asddpg.algorithm.learner import Learner
from asddpg.algorithm.losses import Batch, PolicyTerms, TargetRule, bellman_targets, critic_dqn_loss, policy_loss
from asddpg.algorithm.networks import Networks, NetworkShape
from asddpg.algorithm.replay import ReplayBuffer, ReplayShape
from asddpg.algorithm.schedules import Withdrawal
from asddpg.config import AgentConfig, ExplorationConfig, WithdrawalConfig
from asddpg.episodes.batch_steps import Decisions, Steps
from asddpg.episodes.drivers import actor_alone
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Action, Decision, Driver, Observation, Step
from tests.support.one_agent import ROBOT, OneAgent, steps_of, transitions

LOW, HIGH = np.array([0.0, -1.0], dtype=np.float32), np.array([0.5, 1.0], dtype=np.float32)


class Identity:
    """Do what the observation says: reward −|a − wanted|², an episode is 10 steps. Knows nothing of robots."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        self.steps = 0
        return self._observe(), {}

    def _observe(self) -> Observation:
        self.wanted: Action = self.rng.uniform(LOW, HIGH).astype(np.float32)
        return np.concatenate([self.wanted, np.ones(1, np.float32)]).astype(np.float32)

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self.steps += 1
        reward = -float(np.sum(((action - self.wanted) / (HIGH - LOW)) ** 2))
        return self._observe(), reward, False, self.steps == 10, {}


# Nothing that only pays over a long training.
FAST: dict[str, Any] = {
    "critic_learning_rate": 1e-3,
    "policy_every": 1,
    "batch_size": 32,
    "samples_per_step": 32,
    "tau": 0.005,
    "n_steps": 1,
    "annealing": 0.0,
    "withdrawal": WithdrawalConfig(last_share=0.0),
}


NOISE = ExplorationConfig(sigma=0.3, decay=0.0, final_scale=1.0)


class Perfect:
    def act(self, observation: Observation) -> Action:
        return observation[:2]


class Useless:
    def act(self, observation: Observation) -> Action:
        return LOW


def make_agent(
    controller: Any, seed: int = 0, shape: NetworkShape | None = None, robots: int = 1, **learning: Any
) -> AsDDPG:
    assisted = controller is not None
    settings = FAST | {"imitation": float(assisted)} | learning
    config = AgentConfig(learning_starts=100, actor_learning_rate=1e-3, gamma=0.5, assisted=assisted, **settings)
    shape = shape or NetworkShape(3, None, LOW.tolist(), HIGH.tolist(), (32, 32), twin_critics=config.twin_critics)
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    networks = Networks(shape, with_switch=controller is not None)
    withdrawal = replace(config.withdrawal, begin=1 / 3, end=2 / 3)
    return AsDDPG(
        Learner(networks, config, 3000, seed, torch.device("cpu"), is_concurrent=robots > 1),
        config,
        ReplayBuffer(ReplayShape(5000, shape.observation_size, 2, n_steps=config.n_steps, robots=robots), rng),
        OrnsteinUhlenbeckNoise((HIGH - LOW) / 2, NOISE, 3000, rng, robots),
        Controllers([controller] * robots) if assisted else None,
        Withdrawal(withdrawal, 3000, np.random.default_rng(seed), robots),
        robots,
    )


def train(agent: AsDDPG, steps: int) -> None:
    environment, done = Identity(seed=1), 0
    while done < steps:
        done += run_episode(environment, OneAgent(agent)).steps


def mean_reward(agent: Any) -> float:
    environment = Identity(seed=2)
    return float(np.mean([run_episode(environment, agent).total_reward / 10 for _ in range(20)]))


PAPER: dict[str, Any] = {"imitation": 0.0, "saturation": 0.0, "charge_critic": True}
TWIN = {"twin_critics": True, "target_noise": 0.1, "policy_every": 2, "n_steps": 3}
FOLLOWS = {"critic_follows_switch": True}
WITHDRAWN = {"withdrawal": WithdrawalConfig(last_share=1.0), "annealing": 0.3}


@pytest.mark.parametrize(
    ("controller", "learning"),
    [
        (None, {}),
        (Useless(), PAPER),
        (Useless(), {}),
        (Useless(), TWIN),
        (Useless(), WITHDRAWN),
        (Useless(), FOLLOWS),
        (Useless(), {"precision": "bfloat16"}),
    ],
    ids=["ddpg", "asddpg_paper", "asddpg", "twin critics", "withdrawn", "follows the switch", "bfloat16"],
)
def test_learns_an_identity_task(controller: Any, learning: dict[str, Any]) -> None:
    agent = make_agent(controller, **learning)
    before = mean_reward(actor_alone(agent))
    train(agent, 3000)
    after = mean_reward(actor_alone(agent))
    assert before < -0.1
    # bfloat16 rounds by 0.4 %, each kind of processor in its own way.
    assert after > (-0.02 if learning.get("precision") == "bfloat16" else -0.01), after


def random_batch(size: int = 16) -> Batch:
    rng = np.random.default_rng(0)
    columns = (rng.normal(size=(size, 3)), rng.uniform(LOW, HIGH, (size, 2)), *rng.normal(size=(2, size)))
    flags = (np.ones(size), rng.integers(0, 2, size), rng.normal(size=(size, 3)), rng.uniform(LOW, HIGH, (size, 2)))
    return Batch(*(torch.from_numpy(np.asarray(part, dtype=np.float32)) for part in (*columns, *flags)))


@pytest.mark.parametrize(
    "options",
    [
        {"shared_convolutions": True},
        {"layer_norm": True},
        {"twin_critics": True},
        {"value_bins": (11, -5.0, 5.0), "twin_critics": True},
        {"log_ranges": True},
    ],
)
def test_every_network_learns_all_its_parameters(options: dict[str, Any]) -> None:
    shape = NetworkShape(23, (1, 20), LOW.tolist(), HIGH.tolist(), (16, 16), **options)
    agent = make_agent(Useless(), shape=shape, **PAPER)
    before = copy.deepcopy(agent.networks)
    rng = np.random.default_rng(0)
    x, x_next = (torch.from_numpy(rng.normal(size=(16, 23)).astype(np.float32)) for _ in range(2))
    agent.learner.update([random_batch()._replace(x=x, x_next=x_next)], steps=0)
    for (name, found), old in zip(agent.networks.named_parameters(), before.parameters(), strict=True):
        assert not torch.equal(found, old), name


@pytest.mark.parametrize("learning", [PAPER, {}, FOLLOWS], ids=["asddpg_paper", "asddpg", "follows the switch"])
def test_an_update_is_critic_then_policy_then_targets(learning: dict[str, Any]) -> None:
    """One update against its parts; Adam's first step is lr · g / (|g| + 1e-8)."""
    agent, batch = make_agent(Useless(), **learning), random_batch()
    with torch.no_grad():
        for parameter in agent.networks.parameters():
            parameter.add_(0.1 * torch.randn_like(parameter))
        agent.networks.policy_head.out.bias.add_(10.0)  # beyond tanh's slope
    twin, target, config = copy.deepcopy(agent.networks), copy.deepcopy(agent.learner.target), agent._config
    agent.learner.update([batch], steps=0)

    def step(parameters: list[torch.nn.Parameter], loss: torch.Tensor, rate: float) -> None:
        gradients = torch.autograd.grad(loss, parameters)
        with torch.no_grad():
            for parameter, gradient in zip(parameters, gradients, strict=True):
                parameter.sub_(rate * gradient / (gradient.abs() + 1e-8))

    rule = TargetRule(config.gamma, follow_switch=config.critic_follows_switch)
    targets = bellman_targets(batch, twin, target, rule)
    loss = critic_dqn_loss(batch, twin.features(batch.x), twin, targets)
    step(twin.critic_dqn_parameters(), loss.total, config.critic_learning_rate)
    terms = PolicyTerms(config.imitation, config.saturation)
    objective = policy_loss(batch, twin.features(batch.x).detach(), twin, terms)
    step(twin.policy_parameters(), objective, config.actor_learning_rate)
    for (name, found), expected in zip(agent.networks.named_parameters(), twin.parameters(), strict=True):
        torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-6, msg=name)
    followed = [name for name, _ in twin.named_parameters()]
    online, before = dict(agent.networks.named_parameters()), dict(target.named_parameters())
    for name in followed:
        between = config.tau * online[name] + (1 - config.tau) * before[name]
        torch.testing.assert_close(agent.learner.target.get_parameter(name), between, msg=name)


def test_switch_drops_a_useless_controller() -> None:
    agent = make_agent(Useless())
    train(agent, 3000)
    environment = Identity(seed=3)
    shares = [run_episode(environment, OneAgent(agent)).controller_share for _ in range(20)]
    assert np.mean(shares) < 0.2


def test_switch_keeps_a_perfect_controller_while_the_policy_cannot() -> None:
    agent = make_agent(Perfect())
    agent.learner._update_policy = lambda *_: torch.zeros(())  # type: ignore[method-assign]
    train(agent, 3000)
    assert np.mean([run_episode(Identity(seed=4), OneAgent(agent)).controller_share for _ in range(20)]) > 0.8


def test_the_greedy_switch_takes_the_larger_q() -> None:
    agent = make_agent(Useless())
    rng = np.random.default_rng(0)
    assert agent.networks.switch is not None
    seen = set()
    for bias in (-1.0, 1.0):
        with torch.no_grad():
            agent.networks.switch.out.bias.copy_(torch.tensor([0.0, bias, -bias]))
        decision = agent.decide(rng.normal(size=(1, 3)).astype(np.float32)).row(0)
        assert decision.q_policy is not None
        assert decision.q_controller is not None
        assert (decision.driver is Driver.CONTROLLER) == (decision.q_controller > decision.q_policy)
        if decision.driver is Driver.CONTROLLER:
            assert decision.noise is None
            np.testing.assert_array_equal(decision.action, decision.controller_action)
        else:
            assert decision.noise is not None
        seen.add(decision.driver)
    assert seen == {Driver.POLICY, Driver.CONTROLLER}


def test_a_delayed_policy_moves_with_every_second_update_and_the_critic_with_every_one() -> None:
    agent, batch = make_agent(Useless(), policy_every=2), random_batch()
    moved = []
    for _ in range(4):
        learner = agent.learner
        parts = (learner._policy, learner._target_policy, learner._critic_dqn, learner._target_critic_dqn)
        before = [part.vector.clone() for part in parts]
        (learned,) = learner.update([batch], steps=0)
        moved.append([not torch.equal(part.vector, old) for part, old in zip(parts, before, strict=True)])
        assert ("policy_loss" in learned) is moved[-1][0]
    assert moved == [[True, True, True, True], [False, False, True, True]] * 2


@pytest.mark.parametrize(("terminated", "last"), [(True, 0.0), (False, 1.0)], ids=["end", "time limit"])
def test_returns_over_three_steps_store_every_step_and_only_an_end_stops_the_bootstrap(
    terminated: bool, last: float
) -> None:
    agent = make_agent(None, n_steps=3)  # γ is 0.5
    observation, decision = np.zeros(3, dtype=np.float32), Decision(LOW, Driver.POLICY)
    agent.begin_episodes(ROBOT, observation[None])
    for index in range(4):
        ends = (terminated and index == 3, not terminated and index == 3)
        agent.store(steps_of(Step(observation, decision, 1.0, observation, *ends, {})))
    rows, layout = agent.replay._packed(np.arange(4)), agent.replay.layout
    np.testing.assert_allclose(rows[:, layout.reward], [1.75, 1.75, 1.5, 1.0])
    np.testing.assert_allclose(rows[:, layout.discount], [0.25, 0.25 * last, 0.5 * last, last])


def test_target_smoothing_is_cut_and_the_same_for_the_same_seed() -> None:
    def noises(seed: int) -> torch.Tensor:
        agent = make_agent(None, seed, target_noise=0.2)
        drawn = [agent.learner._target_rule(random_batch()).noise for _ in range(200)]
        return torch.stack([noise for noise in drawn if noise is not None])

    found = noises(0)
    assert found.abs().max() == pytest.approx(0.4)
    assert found.std() == pytest.approx(0.2, rel=0.15)
    assert torch.equal(found, noises(0))
    assert not torch.equal(found, noises(1))


def test_executed_actions_stay_within_bounds() -> None:
    agent = make_agent(None)
    for _ in range(300):
        (action,) = agent.decide(np.array([[0.5, 1.0, 1.0]], dtype=np.float32)).actions
        assert np.all(action >= LOW)
        assert np.all(action <= HIGH)


def stored(agent: AsDDPG, **changes: Any) -> Mapping[str, float]:
    observation = np.zeros(3, dtype=np.float32)
    decision = Decision(LOW, changes.pop("driver", Driver.POLICY))
    values: dict[str, Any] = {"reward": 1.0, "terminated": False, "truncated": False, "info": {}} | changes
    agent.begin_episodes(ROBOT, observation[None])
    agent.store(steps_of(Step(observation, decision, next_observation=observation, **values)))
    layout = agent.replay.layout
    (row,) = agent.replay._packed(np.array([len(agent.replay) - 1]))
    return {name: row[getattr(layout, name)] for name in ("reward", "switch_reward", "by_policy")}


@pytest.mark.parametrize("charge_critic", [True, False])
def test_help_is_charged_to_the_controller_alone(charge_critic: bool) -> None:
    agent = make_agent(Useless(), gamma_p=0.25, charge_critic=charge_critic)
    info = {"dense_reward": 0.4}
    free = stored(agent, driver=Driver.POLICY, info=info)
    assert (free["reward"], free["switch_reward"], free["by_policy"]) == (1.0, 1.0, 1.0)
    charged = stored(agent, driver=Driver.CONTROLLER, info=info)
    assert charged["switch_reward"] == pytest.approx(0.7)
    assert charged["reward"] == pytest.approx(0.7 if charge_critic else 1.0)
    assert charged["by_policy"] == 0.0


def test_proportional_controller_heads_for_the_goal_within_bounds() -> None:
    controller = ProportionalController((2.0, 3.0), LOW, HIGH)
    observation = np.zeros(124, dtype=np.float32)
    observation[-2:] = [0.1, -0.2]
    np.testing.assert_allclose(controller.act(observation), [0.2, -0.6], rtol=1e-6)
    observation[-2:] = [-5.0, 5.0]
    np.testing.assert_array_equal(controller.act(observation), [0.0, 1.0])


def test_noise_wanders_fades_and_starts_anew() -> None:
    noise = OrnsteinUhlenbeckNoise([0.25, 1.0], ExplorationConfig(0.15, 0.2, 1.0, 0.1), 100, np.random.default_rng(0))
    samples = np.array([noise.sample(ROBOT)[0] for _ in range(20_000)]) / [0.25, 1.0]
    # Stationary deviation of n ← (1 − θ) n + σ 𝒩: σ / √(1 − (1 − θ)²).
    np.testing.assert_allclose(samples.std(axis=0), 0.2 / np.sqrt(1 - 0.85**2), rtol=0.05)
    np.testing.assert_allclose([np.corrcoef(samples[:-1, i], samples[1:, i])[0, 1] for i in (0, 1)], 0.85, atol=0.02)
    noise.advance(50)
    assert noise.scale == pytest.approx(0.55)
    noise.advance(100)
    assert noise.scale == pytest.approx(0.1)
    noise.reset(ROBOT)
    assert np.all(np.abs(noise.sample(ROBOT)) < 0.2)


def test_replay_keeps_the_newest_and_gives_back_what_was_put_in() -> None:
    buffer = ReplayBuffer(ReplayShape(4, 3, 2), np.random.default_rng(0))
    for value in range(6):
        part = np.full((1, 3), value, dtype=np.float32)
        x, x_next = (buffer.observe(each, ROBOT) for each in (part, part + 30))
        added = transitions(x, part[:, :2] + 10, (value + 20, value + 50, 1.0, 0.0), x_next)
        buffer.add(added._replace(controller_action=part[:, :2] + 40))
    layout, rows = buffer.layout, buffer.sample(200)
    values = rows[:, 0]
    assert set(values) == {2.0, 3.0, 4.0, 5.0}
    for columns, offset in ((layout.action, 10), (layout.next_observation, 30), (layout.controller_action, 40)):
        assert np.all(rows[:, columns] == values[:, None] + offset)
    assert np.all(rows[:, layout.reward] == values + 20)
    assert np.all(rows[:, layout.switch_reward] == values + 50)


# Many robots ------------------------------------------------------------------------------------------------------


def random_steps(rng: np.random.Generator, robots: int, observations: Any, decisions: Decisions) -> Steps:
    x_next = rng.normal(size=(robots, 3)).astype(np.float32)
    ends = np.zeros(robots, np.bool_)
    return Steps(observations, decisions, rng.normal(size=robots), x_next, ends, ends, {})


def learn_for(agent: AsDDPG, steps: int) -> AsDDPG:
    """Random observations and rewards; what each robot does depends on the agent."""
    rng, everyone = np.random.default_rng(0), np.arange(agent.robots)
    observations = rng.normal(size=(agent.robots, 3)).astype(np.float32)
    agent.begin_episodes(everyone, observations)
    for _ in range(steps):
        made = random_steps(rng, agent.robots, observations, agent.decide(observations))
        agent.learn()
        agent.store(made)
        observations = made.next_observations
    return agent


def weights(agent: AsDDPG) -> torch.Tensor:
    return torch.cat([flat.vector for flat in agent.learner._flat.values()])


@pytest.mark.parametrize("learning", [{}, TWIN, {"batch_size": 7}], ids=["default", "twin critics", "batch 7"])
def test_beside_one_another_policy_and_critic_learn_as_one_after_the_other(learning: dict[str, Any]) -> None:
    together, alone = (make_agent(Useless(), robots=4, **learning) for _ in range(2))
    alone.learner._threads = None
    for agent in (together, alone):
        learn_for(agent, 80)
    assert together.learner.updates > 100
    assert torch.equal(weights(together), weights(alone))


def test_a_policy_beside_the_critic_learns_from_the_critic_before() -> None:
    agent, batch = make_agent(Useless(), robots=4, policy_every=1), random_batch()
    before = copy.deepcopy(agent.networks)
    objective = policy_loss(batch, before.features(batch.x).detach(), before, PolicyTerms(1.0, 0.01))
    first, second = agent.learner.update([batch, batch], steps=0)
    assert torch.equal(first["policy_loss"], objective.detach())
    assert not torch.equal(first["policy_loss"], second["policy_loss"])


def test_bfloat16_changes_products_and_neither_weights_nor_decisions_types() -> None:
    exact, coarse = (make_agent(Useless(), robots=4, precision=name) for name in ("float32", "bfloat16"))
    batch = random_batch(64)
    losses = [agent.learner.update([batch], steps=0)[0] for agent in (exact, coarse)]
    for name in ("critic_loss", "switch_loss"):
        assert losses[0][name] != losses[1][name]
        torch.testing.assert_close(losses[1][name], losses[0][name], rtol=0.02, atol=0.0)
    assert not torch.equal(weights(exact), weights(coarse))
    torch.testing.assert_close(weights(coarse), weights(exact), rtol=0.0, atol=2.5e-3)  # a step of Adam either way
    assert weights(coarse).dtype == torch.float32
    observation = batch.x[:1].numpy()
    actions = [agent.decide(observation.repeat(4, axis=0)).actions for agent in (exact, coarse)]
    assert actions[0].dtype == actions[1].dtype == np.float32


def test_bfloat16_learns_the_same_bits_again() -> None:
    first, second = (learn_for(make_agent(Useless(), robots=4, precision="bfloat16"), 80) for _ in range(2))
    assert torch.equal(weights(first), weights(second))


@pytest.mark.parametrize(("robots", "samples", "updates"), [(1, 32, 1.0), (4, 32, 4.0), (4, 8, 1.0), (3, 1, 3 / 32)])
def test_updates_follow_the_samples_a_step(robots: int, samples: int, updates: float) -> None:
    agent = learn_for(make_agent(None, robots=robots, samples_per_step=samples), 200)
    begun = -(-100 // robots)  # steps of each robot before the first update
    assert agent.learner.updates == pytest.approx(updates * (200 - begun), abs=1)


def test_each_robot_has_its_own_noise_and_its_own_withdrawal() -> None:
    agent = make_agent(Perfect(), robots=64, withdrawal=WithdrawalConfig(first_share=0.5, last_share=0.5))
    assert agent.networks.switch is not None
    agent.networks.switch.out.bias.data[2] += 1.0  # the controller's advantage
    observations = np.tile(np.array([0.2, 0.5, 1.0], np.float32), (64, 1))
    agent.begin_episodes(np.arange(64), observations)
    decisions = agent.decide(observations)
    assert 16 < decisions.by_controller.sum() < 48
    np.testing.assert_array_equal(decisions.actions[decisions.by_controller], observations[decisions.by_controller, :2])
    assert decisions.noise is not None
    drawn = decisions.noise[~decisions.by_controller]
    assert len(np.unique(drawn, axis=0)) == len(drawn)
    assert np.isnan(decisions.noise[decisions.by_controller]).all()
    assert decisions.row(int(np.argmax(decisions.by_controller))).driver is Driver.CONTROLLER


class Counting:
    """A controller with a memory: it counts what it has seen."""

    def __init__(self) -> None:
        self.count = 0

    def act(self, observation: Observation) -> Action:
        self.count += 1
        return np.array([0.0, self.count / 100], np.float32)

    def state(self) -> dict[str, int]:
        return {"count": self.count}

    def load_state(self, state: dict[str, int]) -> None:
        self.count = state["count"]


def test_each_robot_has_a_controller_of_its_own_and_gets_its_memory_back() -> None:
    controllers = Controllers([Counting() for _ in range(3)])
    observations = np.zeros((3, 3), np.float32)
    controllers.act(observations)
    controllers.first.act(observations[0])
    resumed = Controllers([Counting() for _ in range(3)])
    resumed.load_state(controllers.state())
    np.testing.assert_allclose(resumed.act(observations)[:, 1], [0.03, 0.02, 0.02])
