"""Networks' weights as one safetensors file: policy, switch and, for further learning, the critic.

safetensors: a header of JSON and plain tensors, checked against the file's length, with no pickle even as an option.
Reading a file runs no code; the same weights give the same bytes.
"""

import json
from pathlib import Path
from typing import Any, NamedTuple

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialize
from torch import Tensor

from asddpg.algorithm.layers import drawing_weights
from asddpg.algorithm.networks import Networks, NetworkShape, branch_size
from asddpg.atomic_write import write_whole
from asddpg.errors import UserError
from asddpg.runs.state_files import INVALID

KEY, FORMAT = "asddpg_policy", 1
_CRITIC = "critic"  # first part of the names of Q^A's weights: neither the policy nor the switch needs them
_CRITIC_SHAPE = ("layer_norm", "twin_critics", "value_bins")  # fields of a shape that describe Q^A alone
_MAX_OBSERVATION_SIZE = 10**6  # a hundred scans of 2000 beams are a fifth of it


class _Content(NamedTuple):
    weights: dict[str, Tensor]
    shape: NetworkShape
    step: int


def save(path: Path, networks: Networks, step: int, with_critic: bool = True) -> None:
    """Write the online networks after `step` training steps; a published policy needs no critic. Makes the folder.

    Raises:
        OSError: the file could not be written; what was there before is unchanged.
    """
    weights = {
        name: value.detach().cpu().clone(memory_format=torch.contiguous_format)
        for name, value in networks.state_dict().items()
        if with_critic or not name.startswith(_CRITIC)
    }
    # One key: safetensors writes several in a random order, and the same weights are to give the same bytes.
    header = json.dumps({"format": FORMAT, "step": step, "shape": networks.shape._asdict()}, sort_keys=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, serialize(weights, metadata={KEY: header}))


def load_into(path: Path, networks: Networks, needs_critic: bool = False) -> int:
    """Copy the weights in a file into networks; returns the training step they are of.

    A file without Q^A leaves the networks' own.

    Raises:
        UserError: the file is missing, not one of this program, of other networks, or lacks Q^A where it is needed.
    """
    content = _read(path)
    _fill(networks, content, path)
    if needs_critic and not any(name.startswith(_CRITIC) for name in content.weights):
        raise UserError(f"{path} holds policy and switch alone; the critic of its training is not in it")
    return content.step


def read(path: Path) -> tuple[Networks, int, int]:
    """The networks that a file describes, the training step they are of, and the length of their observations.

    Where the file holds no Q^A, theirs is untrained.

    Raises:
        UserError: the file is missing or not one of this program.
    """
    content = _read(path)
    with_switch = any(name.startswith("switch") for name in content.weights)
    try:
        with drawing_weights():
            networks = Networks(content.shape, with_switch)
    except INVALID as error:
        raise UserError(f"{path} is damaged: no network can be built as its header describes one") from error
    _fill(networks, content, path)
    return networks.requires_grad_(False), content.step, content.shape.observation_size


def _fill(networks: Networks, content: _Content, path: Path) -> None:
    expected, found = _policy_shape(networks.shape), _policy_shape(content.shape)
    if differing := [name for name, value in expected.items() if found[name] != value]:
        differences = ", ".join(f"{name} {found[name]} instead of {expected[name]}" for name in differing)
        raise UserError(f"{path} is for a network of another shape than its run's config.yaml describes: {differences}")
    try:
        missing, unexpected = networks.load_state_dict(content.weights, strict=False)
    except RuntimeError as error:
        raise UserError(f"the weights in {path} are of another shape than its header says") from error
    if unexpected or [name for name in missing if not name.startswith(_CRITIC)]:
        raise UserError(f"the weights in {path} are of other layers than the network of its run's config.yaml has")


def _policy_shape(shape: NetworkShape) -> dict[str, Any]:
    """Fields that policy and switch depend on, as JSON gives them back; the actions' bounds are not in the weights."""
    values: dict[str, Any] = json.loads(json.dumps(shape._asdict()))
    return {name: value for name, value in values.items() if name not in _CRITIC_SHAPE}


def _read(path: Path) -> _Content:
    if not path.is_file():
        raise UserError(f"there is no file of weights {path}")
    try:
        with safe_open(path, framework="pt") as file:
            header = json.loads((file.metadata() or {})[KEY])
            shape = _parse_shape(header["shape"])
            if branch_size(shape) > path.stat().st_size:
                raise ValueError("its header describes a larger network than the file has weights for")
            weights = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118  # not a mapping
        if header["format"] != FORMAT:
            raise UserError(f"{path} is of format {header['format']}, and this version reads {FORMAT}")
        return _Content(weights, shape, int(header["step"]))
    except (SafetensorError, OSError, *INVALID) as error:
        raise UserError(f"{path} is damaged or not a file of weights written by asddpg") from error


def _parse_shape(values: dict[str, Any]) -> NetworkShape:
    scan_shape = values.pop("scan_shape")  # JSON knows no tuples
    shape = NetworkShape(**values, scan_shape=None if scan_shape is None else tuple(scan_shape))
    scans, beams = shape.scan_shape or (1, 1)
    if not (scans > 0 < beams and scans * beams <= shape.observation_size <= _MAX_OBSERVATION_SIZE):
        raise ValueError("no task has such observations")
    return shape
