"""The presets of task= and agent=."""

import pytest

from asddpg.build import make_agent, make_environment
from asddpg.command_line import train_config
from asddpg.config import ControllerConfig, TrainConfig
from tasks import ALL_TASKS


@pytest.mark.parametrize(
    ("task", "reward", "steps"),
    [
        ("nav_empty", "dense", 30_000),
        ("nav_simple", "dense", 60_000),
        ("nav_complex", "sparse", 100_000),
        ("nav_gazebo", "sparse", 150_000),
        ("nav_office", "sparse", 150_000),
    ],
)
def test_a_task_brings_reward_steps_and_twenty_validations(task: str, reward: str, steps: int) -> None:
    config = train_config([f"task={task}"])
    assert (config.reward.name, config.total_steps) == (reward, steps)
    assert config.total_steps // config.validation.every == 20


def test_the_papers_agent_has_none_of_the_cures_and_the_released_constants() -> None:
    config = train_config(["task=nav_complex", "agent=asddpg_paper"])
    agent = config.agent
    assert (agent.tau, agent.buffer_size, agent.critic_learning_rate) == (0.001, 20_000, 0.001)
    assert agent.charge_critic
    assert not agent.critic_follows_switch
    assert (agent.imitation, agent.saturation) == (0.0, 0.0)
    assert (agent.n_steps, agent.policy_every, agent.annealing) == (1, 1, 0.0)
    assert agent.withdrawal.first_share == agent.withdrawal.last_share == 0.0
    assert config.task.min_linear_velocity == 0.05
    assert config.controller == ControllerConfig(gains=[10.0, 1.0])
    assert config.network.convolutions == "none"


@pytest.mark.parametrize("task", ALL_TASKS)
def test_the_papers_agent_is_the_same_in_every_room(task: str) -> None:
    paper, complex_room = (train_config([f"task={each}", "agent=asddpg_paper"]) for each in (task, "nav_complex"))
    assert (paper.agent, paper.robots) == (complex_room.agent, 1)
    assert (paper.network, paper.safety_margin) == (complex_room.network, 0.0)
    assert paper.agent.batch_size == paper.agent.samples_per_step == 32


def test_what_the_rooms_set() -> None:
    configs = {task: train_config([f"task={task}"]) for task in ALL_TASKS}
    moving = [task for task, config in configs.items() if config.task.min_linear_velocity == 0.05]
    assert moving == ["nav_empty", "nav_simple", "nav_complex", "nav_gazebo", "nav_anywhere"]
    gazebo = configs["nav_gazebo"].agent
    assert (gazebo.samples_per_step, gazebo.imitation) == (24, 0.0)


@pytest.mark.parametrize("agent", ["asddpg", "asddpg_paper", "astd3", "ddpg"])
@pytest.mark.parametrize("convolutions", ["separate", "shared", "none"])
def test_every_agent_is_built_with_every_front(agent: str, convolutions: str) -> None:
    config: TrainConfig = train_config([f"agent={agent}", f"network.convolutions={convolutions}", "network=fc2x100"])
    environment = make_environment(config.task, config.reward)
    built = make_agent(config, environment)
    action = built.act(environment.reset(seed=0)[0])
    assert environment.action_space.contains(action)
    assert action[0] >= config.task.min_linear_velocity


def test_a_least_speed_is_kept_by_policy_and_controller() -> None:
    config = train_config(["task=nav_empty", "task.min_linear_velocity=0.05", "network=fc2x100"])
    environment = make_environment(config.task, config.reward)
    agent = make_agent(config, environment)
    observation, _ = environment.reset(options={"start": (0.0, 0.0, 3.14), "goal": (3.0, 0.0)})
    assert agent.controller is not None
    assert agent.controller.act(observation)[0] == pytest.approx(0.05)  # the goal lies behind
    assert agent.act(observation)[0] >= 0.05
    for _ in range(10):
        observation, *_ = environment.step(agent.controller.act(observation))
    assert observation[-4] == pytest.approx(0.05, abs=0.01)  # v
