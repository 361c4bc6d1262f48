"""Stable-Baselines3 on our tasks, with our convolutions in front and our widths; it needs the bench extra."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
import stable_baselines3
import torch
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.noise import NormalActionNoise, OrnsteinUhlenbeckActionNoise
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecEnv

from asddpg.algorithm.networks import Features
from asddpg.build import make_environment, make_robots
from asddpg.config import TrainConfig
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv
from tools.benchmarks.peer_settings import SAC_OPTIONS, SETTINGS

ROBOTS = 16
THETA = 0.15  # of the Ornstein-Uhlenbeck noise a step, as in asddpg.config


class Extractor(BaseFeaturesExtractor):  # type: ignore[misc,unused-ignore]  # without the bench extra
    """Our feature extraction as the library's."""

    def __init__(self, space: gymnasium.spaces.Box, scan_shape: tuple[int, int]) -> None:
        super().__init__(space, 1)
        self.features = Features(space.shape[0], scan_shape)
        self._features_dim = self.features.size

    def forward(self, observation: torch.Tensor) -> torch.Tensor:
        """Features of observations."""
        found: torch.Tensor = self.features(observation)
        return found


class RobotVecEnv(VecEnv):  # type: ignore[misc,unused-ignore]
    """Our vector environment as the library's: one in place of 16, so that the robots drive in threads.

    Rewards are float32, as the replay buffer keeps them. `info` holds what the library reads: at an episode's end the
    last observation, and whether the time limit ended it.
    """

    def __init__(self, env: NavigationVectorEnv) -> None:
        """`env` resets in the step that ends an episode."""
        self.env = env
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Any:
        """Begin an episode with each robot."""
        observations, _ = self.env.reset(seed=self._seeds)
        self._reset_seeds()
        return observations

    def step_async(self, actions: Any) -> None:
        """Begin a step; `actions` are in m/s and rad/s, (robots, 2)."""
        self.env.begin_step(actions)

    def step_wait(self) -> Any:
        """Observations, rewards, ends and info."""
        observations, rewards, terminated, truncated, info = self.env.finish_step()
        ends = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for robot in np.flatnonzero(ends):
            last = info["final_obs"][robot]
            timed_out = bool(truncated[robot] and not terminated[robot])
            infos[robot] = {"terminal_observation": last, "TimeLimit.truncated": timed_out}
        return observations, rewards.astype(np.float32), ends, infos

    def close(self) -> None:
        """End the threads."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of each robot's environment."""
        return [getattr(self.env.envs[index], attr_name) for index in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of each robot's environment."""
        for index in self._get_indices(indices):
            setattr(self.env.envs[index], attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Call a method of each robot's environment."""
        return [method(*args, **kwargs) for method in self.get_attr(method_name, indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Whether each robot's environment is wrapped: none is."""
        return [False for _ in self._get_indices(indices)]


def make_vec_env(config: TrainConfig, num_envs: int = ROBOTS) -> RobotVecEnv:
    """Robots of a training's task and reward."""
    return RobotVecEnv(make_robots(config.task, config.reward, num_envs, autoreset_mode=AutoresetMode.SAME_STEP))


def make_peer(config: TrainConfig, algorithm: str, setting: str) -> Any:
    """A model of an algorithm in one of its SETTINGS, with the task, the widths and the seed of a training of ours."""
    env = make_vec_env(config)
    scan_shape = env.get_attr("scan_shape", [0])[0]
    chosen = SETTINGS[setting]
    options: dict[str, Any] = {**chosen.options}
    if algorithm == "sac":
        options |= SAC_OPTIONS if chosen.options else {}
    elif chosen.noise is not None:
        options["action_noise"] = _make_noise(*chosen.noise, size=len(env.get_attr("action_space", [0])[0].low))
    return _make_model(algorithm, env, scan_shape, config.network.widths, seed=config.seed, **options)


def training_loop(config: TrainConfig, share_convolutions: bool, is_flushed: bool = True) -> Callable[[int], None]:
    """Training of DDPG with one robot, as a function of a number of steps; an update a step."""
    env = make_environment(config.task, config.reward)
    model = _make_model(
        "ddpg",
        env,
        env.get_wrapper_attr("scan_shape"),
        config.network.widths,
        share_convolutions,
        batch_size=config.agent.batch_size,
        buffer_size=config.agent.buffer_size,
    )

    def loop(steps: int) -> None:
        torch.set_flush_denormal(is_flushed)  # the library leaves the processor with denormal numbers
        model.learn(steps, reset_num_timesteps=False)
        torch.set_flush_denormal(True)

    return loop


def sample_loop(config: TrainConfig, batch_size: int, gradient_steps: int) -> Callable[[int], float]:
    """Training of DDPG with ROBOTS robots.

    Args:
        config: of the task and the widths.
        batch_size: samples an update.
        gradient_steps: updates for every ROBOTS steps.

    Returns:
        A function of a number of steps; it returns the seconds that they took.
    """
    env = make_vec_env(config)
    options: dict[str, Any] = {
        "batch_size": batch_size,
        "gradient_steps": gradient_steps,
        "buffer_size": config.agent.buffer_size,
    }
    model = _make_model("ddpg", env, env.get_attr("scan_shape", [0])[0], config.network.widths, **options)

    def loop(steps: int) -> float:
        begun = time.perf_counter()
        model.learn(steps, reset_num_timesteps=False)
        return time.perf_counter() - begun

    return loop


def _make_model(
    algorithm: str,
    env: Any,
    scan_shape: tuple[int, int],
    widths: Sequence[int],
    share_convolutions: bool = False,
    **options: Any,
) -> Any:
    policy = {
        "net_arch": [*widths],
        "features_extractor_class": Extractor,
        "features_extractor_kwargs": {"scan_shape": scan_shape},
        "share_features_extractor": share_convolutions,
    }
    return getattr(stable_baselines3, algorithm.upper())(
        "MlpPolicy", env, device="cpu", policy_kwargs=policy, **options
    )


def _make_noise(kind: str, sigma: float, size: int) -> Any:
    mean, sigmas = np.zeros(size), np.full(size, sigma)
    if kind == "gaussian":
        return NormalActionNoise(mean, sigmas)
    return OrnsteinUhlenbeckActionNoise(mean, sigmas, theta=THETA, dt=1.0)
