"""Puts environment and agent together from a configuration: where tasks and agent meet."""

import os
import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import torch
from gymnasium.vector import AutoresetMode

from asddpg.algorithm.agent import AsDDPG
from asddpg.algorithm.controllers import Controllers, make_controller
from asddpg.algorithm.exploration import OrnsteinUhlenbeckNoise
from asddpg.algorithm.layers import drawing_weights
from asddpg.algorithm.learner import Learner
from asddpg.algorithm.memory_check import check_file, check_memory
from asddpg.algorithm.networks import Networks, NetworkShape
from asddpg.algorithm.replay import BalancedReplay, ReplayBuffer, ReplayShape
from asddpg.algorithm.schedules import Withdrawal
from asddpg.config import (
    ControllerConfig,
    MissionConfig,
    PlayConfig,
    RecordConfig,
    RecordEvaluationConfig,
    TaskConfig,
    TrainConfig,
)
from asddpg.episodes.protocols import Action, Controller
from asddpg.episodes.random_streams import stream
from asddpg.errors import UserError, truncated_repr
from asddpg.messages import print_line
from asddpg.recording.live.controls import Steering
from asddpg.recording.live.live_view import LiveView
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.samples import ReadNavigation
from tasks import NavigationConfig, Reward
from tasks.gymnasium_api.navigation_env import NavigationEnv, id_and_scene
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv
from tasks.rooms.reading import find_room, is_room


def make_environment(task: TaskConfig, reward: Reward) -> gymnasium.Env:
    """The task as a Gymnasium environment, actions in m/s and rad/s."""
    config, (environment_id, scene) = _navigation_config(task), id_and_scene(task.name)
    return gymnasium.make(environment_id, **scene, reward=reward, config=config, num_scans=task.num_scans)


def note_omitted(task_name: str) -> None:
    """Print what of a room's file its room lacks."""
    omitted = find_room(task_name).omitted if is_room(task_name) else ()
    if omitted:
        others = f"; python -m tools.room names {len(omitted) - 1} more" if len(omitted) > 1 else ""
        print_line(f"note: of {task_name} was not taken: {omitted[0]}{others}")


def make_robots(
    task: TaskConfig,
    reward: Reward,
    robots: int,
    num_threads: int | None = None,
    autoreset_mode: AutoresetMode = AutoresetMode.DISABLED,
) -> NavigationVectorEnv:
    """The task as a vector environment; its robots begin episodes when they are reset, unless another mode is given."""
    arguments: dict[str, Any] = {"reward": reward, "config": _navigation_config(task), "num_scans": task.num_scans}
    return NavigationVectorEnv(task.name, robots, autoreset_mode, num_threads, **arguments)


def make_training_robots(config: TrainConfig, num_threads: int | None = None) -> NavigationVectorEnv:
    """The robots that a training learns from: they keep its safety margin."""
    robots = make_robots(config.task, config.reward, config.robots, num_threads)
    for environment in robots.envs:
        environment.set_safety_margin(config.safety_margin)
    return robots


def count_driving_threads() -> int:
    """Threads that drive the robots of a training: one for each core but that of the policy's updates.

    The main thread, which learns, is one of them; it drives when its updates are made.
    """
    return max(2, len(os.sched_getaffinity(0)) - 1)


def _navigation_config(task: TaskConfig) -> NavigationConfig:
    """Without the fields of TaskConfig: a spec's JSON holds the task's own."""
    return NavigationConfig(**{each.name: getattr(task, each.name) for each in fields(NavigationConfig)})


def navigation_env(environment: gymnasium.Env) -> NavigationEnv:
    """The environment below its wrappers, for observers to read."""
    inner = environment.unwrapped
    assert isinstance(inner, NavigationEnv)
    return inner


def make_cameras(record: RecordConfig | RecordEvaluationConfig, environment: NavigationEnv) -> Cameras | None:
    """The cameras whose pictures are recorded, if there are any; make them before anything is written.

    Raises:
        TaskError: no such camera, or no graphics library.
        UserError: no encoder.
    """
    if not record.cameras:
        return None
    width, height = record.picture_size
    return Cameras(environment, record.cameras, width, height, is_video=record.codec == "h264")


def make_live(
    config: TrainConfig | PlayConfig | MissionConfig,
    environment: NavigationEnv,
    cameras: Cameras | None,
    steering: Steering | None = None,
    read_navigation: ReadNavigation | None = None,
) -> LiveView:
    """The live view, with pictures and plans; a training has no steering.

    Raises:
        UserError: its port is taken.
    """
    stills = cameras.stills() if cameras else None
    return LiveView(environment, config.port, config.speed, steering, stills, read_navigation)


def action_bounds(environment: gymnasium.Env) -> tuple[Action, Action]:
    """Smallest and largest action."""
    space = environment.action_space
    assert isinstance(space, gymnasium.spaces.Box)
    return space.low, space.high


def controller_for(environment: gymnasium.Env, config: ControllerConfig) -> Controller:
    """The controller for an environment's actions.

    Raises:
        UserError: there is none of that name, or it does not give actions of that space.
    """
    low, high = action_bounds(environment)
    controller = make_controller(config.type, config.gains, low, high)
    assert environment.observation_space.shape is not None
    action = controller.act(np.zeros(environment.observation_space.shape, dtype=np.float32))
    if np.shape(action) != low.shape or not np.all((action >= low) & (action <= high)):
        bounds = f"within {low.tolist()} and {high.tolist()}"
        raise UserError(f"the controller {config.type!r} must give {len(low)} numbers {bounds}, not {action}")
    return controller


def _network_shape(config: TrainConfig, environment: gymnasium.Env) -> NetworkShape:
    """What the networks of a configuration are built for in an environment."""
    low, high = action_bounds(environment)
    assert environment.observation_space.shape is not None
    (observation_size,) = environment.observation_space.shape
    network = config.network
    scan_shape = None if network.convolutions == "none" else getattr(environment.unwrapped, "scan_shape", None)
    spaces = (observation_size, scan_shape, low.tolist(), high.tolist())
    return NetworkShape(
        *spaces,
        network.widths,
        network.layer_norm,
        config.agent.twin_critics,
        shared_convolutions=network.convolutions == "shared",
        log_ranges=network.ranges == "log",
        value_bins=_value_bins(config),
    )


def _value_bins(config: TrainConfig) -> tuple[int, float, float] | None:
    if not config.agent.value_bins:
        return None
    metres = config.task.max_linear_velocity * config.task.control_timestep
    return config.agent.value_bins, *config.reward.bound_returns(config.agent.gamma, metres)


def make_agent(config: TrainConfig, environment: gymnasium.Env, weights: Path | None = None) -> AsDDPG:
    """The agent of a run, untrained, its random streams from the run's seed.

    Args:
        config: of the training.
        environment: where it drives.
        weights: the file whose weights it is to be given, if any.

    Raises:
        UserError: there is no such controller, the file is too short, or the memory is.
    """
    low, high = action_bounds(environment)
    shape = _network_shape(config, environment)
    learning = config.agent
    if weights is not None:
        check_file(weights, shape)
    robots, total_steps = config.robots, config.total_steps
    scan_shape = getattr(environment.unwrapped, "scan_shape", None)
    replay_shape = ReplayShape(
        learning.buffer_size, shape.observation_size, len(low), scan_shape, learning.n_steps, robots
    )
    check_memory(shape, learning, replay_shape)
    kind_of_replay = BalancedReplay if learning.balanced_batches else ReplayBuffer
    controllers = [controller_for(environment, config.controller) for _ in range(robots)]  # checked in DDPG too
    half_range, noise_rng = (high - low) / 2, stream(config.seed, "exploration")
    return AsDDPG(
        learner=Learner(
            _initial_networks(shape, learning.assisted, stream(config.seed, "weights")),
            learning,
            total_steps,
            smoothing_seed=int(stream(config.seed, "smoothing").integers(2**63)),
            device=torch.device(config.device),
            is_concurrent=robots > 1,
        ),
        config=learning,
        replay=kind_of_replay(replay_shape, stream(config.seed, "replay")),
        noise=OrnsteinUhlenbeckNoise(half_range, config.exploration, total_steps, noise_rng, robots),
        controllers=Controllers(controllers) if learning.assisted else None,
        withdrawal=Withdrawal(learning.withdrawal, total_steps, stream(config.seed, "withdrawal"), robots),
        robots=robots,
    )


def _initial_networks(shape: NetworkShape, with_switch: bool, rng: np.random.Generator) -> Networks:
    with drawing_weights(int(rng.integers(2**63))):
        return Networks(shape, with_switch)


def check_device(device: str) -> None:
    """UserError where torch has no such device."""
    if not re.fullmatch(r"(cpu|cuda)(:[0-9]{1,4})?", device):
        raise UserError(f"there is no device {truncated_repr(device)}; there are cpu, cuda and cuda:<n>")
    kind, _, index = device.partition(":")
    if kind == "cuda" and not torch.cuda.is_available():
        raise UserError(f"device {device} needs a CUDA build of torch and a GPU, and there is none; cpu always works")
    if kind == "cuda" and index and int(index) >= torch.cuda.device_count():
        raise UserError(f"there is no {device}; there are {torch.cuda.device_count()} CUDA devices, counted from 0")
    if kind == "cpu" and index not in ("", "0"):
        raise UserError(f"there is no device {device!r}; the processor is cpu")


_settings = threading.Lock()
_before: list[list[Any]] = []  # settings of the process when prepare_torch() was entered, the last entry last


@contextmanager
def prepare_torch() -> Iterator[None]:
    """One thread, float32, the CPU, gradients, no denormals, for a `with` or a function; then all is as it was.

    Small networks gain nothing from a second thread and lose much to it beside another process. Adam's moments of tiny
    gradients become denormal numbers, on which a CPU is many times slower.
    """
    was_flushed, device = sys.float_info.min / 2 == 0.0, torch.get_default_device()  # of this thread
    with _settings:
        mine: list[Any] = [torch.get_num_threads(), torch.get_default_dtype()]
        _before.append(mine)
        torch.set_num_threads(1)
        torch.set_default_dtype(torch.float32)
    torch.set_flush_denormal(True)
    torch.set_default_device(None)
    try:
        with torch.inference_mode(False), torch.enable_grad(), torch.autocast("cpu", enabled=False):
            yield
    finally:
        with _settings:
            place = next(index for index, each in enumerate(_before) if each is mine)
            del _before[place]
            if place < len(_before):
                _before[place][:] = mine  # another thread entered later and still needs its own: it restores these
            else:
                torch.set_num_threads(mine[0])
                torch.set_default_dtype(mine[1])
        torch.set_flush_denormal(was_flushed)
        torch.set_default_device(None if device.type == "cpu" else device)
