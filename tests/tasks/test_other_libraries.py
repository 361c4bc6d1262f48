"""What other libraries do with the tasks, as an example: Gymnasium's wrappers and vectors, Stable-Baselines3."""

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import vector as vector_wrappers

import tasks  # noqa: F401  # registers the ids

# Gymnasium and Stable-Baselines3 recommend actions in [−1, 1]; here they are m/s and rad/s.
pytestmark = [pytest.mark.long, pytest.mark.filterwarnings("ignore:.*symmetric and normalized")]

ID = "asddpg/NavComplex-v0"
OPTIONS: dict[str, Any] = {"render_mode": "rgb_array", "width": 64, "height": 48, "max_episode_steps": 50}
TURN = np.array([0.0, 0.5], dtype=np.float32)  # m/s, rad/s

# Gymnasium ---------------------------------------------------------------------------------------

UNIT = np.float32(1.0)
ARGUMENTS: dict[str, dict[str, Any]] = {
    "AddWhiteNoise": {"probability_of_noise_per_pixel": 0.1}, "ClipReward": {"max_reward": 1.0},
    "DelayObservation": {"delay": 2}, "DiscretizeAction": {"bins": 5}, "DtypeObservation": {"dtype": np.float32},
    "DiscretizeObservation": {"bins": 5, "multidiscrete": True}, "FrameStackObservation": {"stack_size": 3},
    "ObstructView": {"obstructed_pixels_ratio": 0.1, "obstruction_width": 4}, "RepeatAction": {"num_repeats": 2},
    "RescaleAction": {"min_action": -UNIT, "max_action": UNIT}, "ReshapeObservation": {"shape": (31, 4)},
    "RescaleObservation": {"min_obs": -UNIT, "max_obs": UNIT}, "StickyAction": {"repeat_action_probability": 0.3},
    "TimeLimit": {"max_episode_steps": 5}, "TransformAction": {"func": np.negative, "action_space": None},
    "TransformObservation": {"func": np.negative, "observation_space": None}, "TransformReward": {"func": np.negative},
    "VectorizeTransformAction": {"wrapper": wrappers.ClipAction},
    "VectorizeTransformObservation": {"wrapper": wrappers.FlattenObservation},
    "VectorizeTransformReward": {"wrapper": wrappers.ClipReward, "max_reward": 1.0},
}  # fmt: skip
# They are for Atari, pictures, dictionaries and other arrays than NumPy's, or need a screen or moviepy.
OTHERS = {"AtariPreprocessing", "GrayscaleObservation", "ResizeObservation", "FilterObservation", "ArrayConversion"}
OTHERS |= {"JaxToNumpy", "JaxToTorch", "NumpyToTorch", "HumanRendering", "RecordVideo", "DictInfoToList", "vector"}


@pytest.mark.parametrize("name", sorted({*wrappers.__all__} - OTHERS))
def test_every_wrapper_of_gymnasium_fits(name: str) -> None:
    env: Any = getattr(wrappers, name)(gymnasium.make(ID, **OPTIONS), **ARGUMENTS.get(name, {}))
    env.reset(seed=0)
    for _ in range(3):
        observation, reward, *_ = env.step(env.action_space.sample())
        assert observation in env.observation_space
        assert np.isfinite(reward)
    env.render()
    env.close()


@pytest.mark.parametrize("name", sorted({*vector_wrappers.__all__} - OTHERS))
def test_every_vector_wrapper_of_gymnasium_fits(name: str) -> None:
    vector: Any = getattr(vector_wrappers, name)(gymnasium.make_vec(ID, 2, **OPTIONS), **ARGUMENTS.get(name, {}))
    vector.reset(seed=0)
    for _ in range(3):
        observations, rewards, *_ = vector.step(vector.action_space.sample())
        assert observations in vector.observation_space
        assert np.isfinite(rewards).all()
    vector.close()


@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("vectorization", ["sync", "async"])
def test_a_vector_resets_its_episodes_in_every_mode(vectorization: str, mode: AutoresetMode) -> None:
    vector = gymnasium.make_vec(ID, 2, vectorization, {"autoreset_mode": mode}, max_episode_steps=5)
    vector.reset(seed=0)
    ends = []
    for _ in range(12):
        *_, truncated, _ = vector.step(np.stack([TURN, TURN]))
        ends.append(bool(truncated.all()))
        if ends[-1] and mode is AutoresetMode.DISABLED:
            vector.reset(options={"reset_mask": truncated})
    vector.close()
    gap = 6 if mode is AutoresetMode.NEXT_STEP else 5  # of NEXT_STEP the reset is a step
    assert [step for step, is_end in enumerate(ends, 1) if is_end] == [5, 5 + gap]


@pytest.mark.parametrize("task", ["NavEmpty", "NavSimple", "NavComplex", "NavGazebo", "NavOffice"])
def test_the_checkers_find_no_fault(task: str) -> None:
    check_env(gymnasium.make(f"asddpg/{task}-v0", render_mode="rgb_array").unwrapped)
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    checker.check_env(gymnasium.make(f"asddpg/{task}-v0"))


# Stable-Baselines3 -------------------------------------------------------------------------------


@pytest.mark.parametrize("algorithm", ["DDPG", "TD3", "SAC", "PPO"])
def test_stable_baselines_learns(algorithm: str) -> None:
    """Two environments, a process each, stacked and normalized; with its module the id needs no import there."""
    library = pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.vec_env import SubprocVecEnv, VecFrameStack, VecNormalize

    processes: Any = {"vec_env_cls": SubprocVecEnv, "vec_env_kwargs": {"start_method": "spawn"}}
    env = VecNormalize(VecFrameStack(make_vec_env(f"tasks:{ID}", n_envs=2, seed=0, **processes), n_stack=2))
    model = getattr(library, algorithm)("MlpPolicy", env, device="cpu", seed=0)
    model.learn(total_timesteps=3000)
    env.close()
    assert all(0 < episode["l"] <= 200 for episode in model.ep_info_buffer)
    assert len(model.ep_success_buffer) == len(model.ep_info_buffer) > 0
