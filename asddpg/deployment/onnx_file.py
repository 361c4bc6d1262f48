"""A policy as an ONNX file: what others need to know stands in its metadata."""

import json
from pathlib import Path

import numpy as np
import onnx

from asddpg import __version__
from asddpg.algorithm.networks import Networks
from asddpg.atomic_write import write_whole
from asddpg.config import TrainConfig
from asddpg.deployment.onnx_graph import COMMAND, GOAL, PREVIOUS, RANGES, SCANS, SWITCH, VELOCITY, build_graph
from asddpg.errors import UserError

DESCRIPTIONS = {
    RANGES: "newest scan, metres, one number for each of beam_angles; no return: +inf or any beyond max_range; a NaN "
    "makes the command NaN",
    PREVIOUS: "what the last call gave as scans; zeros at the beginning of an episode",
    VELOCITY: "forward speed, m/s, and turn rate, rad/s, to the left positive",
    GOAL: "metres ahead of and to the left of the midpoint between the driven wheels",
    COMMAND: "forward speed, m/s, and turn rate, rad/s, for the next control_timestep",
    SCANS: "previous_scans of the next call",
    SWITCH: "Q(x, σ) of the policy and of the controller",
}


def write_onnx(path: Path, networks: Networks, config: TrainConfig, title: str, with_switch: bool = False) -> None:
    """Write a policy, whole or not at all.

    Args:
        path: of the file.
        networks: of the policy.
        config: of its training.
        title: of the policy, such as pretrained:nav_complex.
        with_switch: whether the file has the switch too.

    Raises:
        UserError: the networks have no switch to write.
    """
    if with_switch and networks.switch is None:
        raise UserError(f"{title} has no switch: its agent, {config.agent.name}, was trained without a controller")
    model = build_graph(networks, config.task, with_switch)
    names = [value.name for value in (*model.graph.input, *model.graph.output)]
    metadata = {**describe(networks, config, title), **{name: DESCRIPTIONS[name] for name in names}}
    onnx.helper.set_model_props(model, {name: _text(value) for name, value in metadata.items()})
    model.doc_string = f"{title}: a policy for local navigation. Call it once every control_timestep."
    write_whole(path, model.SerializeToString(deterministic=True))


def describe(networks: Networks, config: TrainConfig, title: str) -> dict[str, object]:
    """What a user of the file must know, by name; SI units."""
    task, laser, shape = config.task, config.task.laser, networks.shape
    return {
        "policy": title,
        "asddpg_version": __version__,
        "task": task.name,
        "robot": task.robot,
        "control_timestep": task.control_timestep,
        "beam_angles": np.round(laser.ring.angles(), 9).tolist(),  # rad from straight ahead, to the left positive
        "min_range": laser.min_range,
        "max_range": laser.max_range,
        "command_low": [*shape.action_low],  # m/s and rad/s; a robot of the user's own has its own
        "command_high": [*shape.action_high],
        "goal_radius": task.goal_radius,
    }


def _text(value: object) -> str:
    return value if isinstance(value, str) else json.dumps(value)
