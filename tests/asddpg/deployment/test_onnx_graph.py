"""An exported policy computes what the policy does, for every kind of network and observation."""

import math
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
import torch

from asddpg.algorithm.networks import Networks, NetworkShape
from asddpg.config import TaskConfig
from asddpg.deployment.onnx_graph import build_graph
from tasks.gymnasium_api.flat_observation import ScanStack
from tasks.laser import LaserConfig, pool_rays
from tasks.navigation import clip_goal

KINDS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "default": ({}, {}),
    "log ranges, a distribution, rays, far goals": (
        {"log_ranges": True, "value_bins": (51, -5.0, 5.0)},
        {"goal_range": 3.0, "laser": LaserConfig(num_beams=20, rays_per_beam=4)},
    ),
    "one feature extraction": ({"shared_convolutions": True, "layer_norm": True}, {"num_scans": 2}),
    "no convolutions, one scan, twins": ({"scan_shape": None, "twin_critics": True}, {"num_scans": 1}),
}


def build(shape: dict[str, Any], task: TaskConfig) -> Networks:
    torch.manual_seed(3)
    beams = task.laser.num_beams
    values = {"scan_shape": (task.num_scans, beams)} | shape
    options = {"action_low": (0.05, -1.0), "action_high": (0.5, 1.0), "widths": (32, 24)}
    networks = Networks(NetworkShape(task.num_scans * beams + 4, **(values | options)), True)
    with torch.no_grad():
        networks.policy_head.out.weight.mul_(300.0)  # the first actions of new networks are all in the middle
    return networks


def open_session(model: onnx.ModelProto) -> onnxruntime.InferenceSession:
    return onnxruntime.InferenceSession(model.SerializeToString(), providers=["CPUExecutionProvider"])


@pytest.mark.parametrize("kind", KINDS)
def test_commands_and_values_over_episodes(kind: str) -> None:
    shape, options = KINDS[kind]
    task = TaskConfig(name="nav_complex", **options)
    networks, laser = build(shape, task), task.laser
    session = open_session(build_graph(networks, task, with_switch=True))
    names = [value.name for value in session.get_outputs()]
    none = np.zeros((1, task.num_scans - 1, laser.num_beams), np.float32)
    rng, commands = np.random.default_rng(1), []
    stack, kept = ScanStack(task.num_scans, laser.num_beams, laser.max_range), none
    for step in range(60):
        ranges = rng.uniform(0.0, 1.3 * laser.max_range, laser.num_beams * laser.rays_per_beam)
        ranges[rng.random(len(ranges)) < 0.1] = np.inf
        velocity, goal = rng.uniform(-1.0, 1.0, 2), rng.normal(0.0, 3.0, 2)
        scan = pool_rays(np.clip(ranges, laser.min_range, laser.max_range), laser.rays_per_beam)
        seen = np.array(clip_goal((goal[0], goal[1]), task.goal_range))
        observation = {"ranges": scan, "velocity": velocity, "goal": seen}
        is_first = step % 20 == 0
        flat = torch.from_numpy(stack.reset(observation) if is_first else stack.push(observation))[None]
        feed = {"ranges": ranges, "velocity": velocity, "goal": goal}
        given = {name: value.astype(np.float32)[None] for name, value in feed.items()}
        if task.num_scans > 1:
            given["previous_scans"] = none if is_first else kept
        found = dict(zip(names, session.run(None, given), strict=True))
        kept = found.get("scans", none)
        with torch.no_grad():
            assert networks.switch is not None
            values = networks.switch(networks.features(flat))
            command = networks.policy(flat)
        np.testing.assert_allclose(found["command"], command.numpy(), atol=1e-5)
        np.testing.assert_allclose(found["switch_values"], values.numpy(), atol=1e-5, rtol=1e-4)
        commands.append(command.numpy())
    assert np.std(commands, axis=0).min() > 1e-3  # a hundred times the tolerance


def test_several_robots_at_once_and_a_scan_that_is_not_finite() -> None:
    task = TaskConfig(name="nav_complex")
    session = open_session(build_graph(build({}, task), task))
    size, scans = task.laser.num_beams, task.num_scans - 1
    ranges = np.random.default_rng(0).uniform(0.1, 5.0, (3, size)).astype(np.float32)
    feed = {"velocity": np.zeros((3, 2)), "goal": np.ones((3, 2)), "previous_scans": np.zeros((3, scans, size))}
    given = {name: value.astype(np.float32) for name, value in feed.items()}
    together, _ = session.run(None, given | {"ranges": ranges})
    alone, _ = session.run(None, {name: value[1:2] for name, value in (given | {"ranges": ranges}).items()})
    np.testing.assert_allclose(together[1], alone[0], atol=1e-6)
    ranges[1, 7] = math.nan
    damaged, _ = session.run(None, given | {"ranges": ranges})
    assert np.isnan(damaged[1]).all()
    np.testing.assert_allclose(damaged[[0, 2]], together[[0, 2]], atol=1e-6)
