"""A policy's file: the weights that drive, without those that only learning needs, in float32.

safetensors and not .npz: a header of JSON and plain tensors, checked against the file's length, with no pickle even as
an option.
"""

import json
from pathlib import Path
from typing import Any, NamedTuple

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as serialised
from torch import Tensor

from asddpg.algorithm.networks import Networks, NetworkShape, branch_size
from asddpg.errors import UserError

KEY, FORMAT = "asddpg_policy", 1
_LEARNING = "critic"  # first part of the names of Q^A's weights: neither the policy nor the switch asks it
_LEARNING_SHAPE = ("layer_norm", "twin_critics")  # what of a shape is Q^A's alone
_LONGEST = 10**6  # numbers in an observation; a hundred scans of 2000 beams are a fifth of it
# What values of the wrong kind or size in a header lead to.
_NONSENSE = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RuntimeError, MemoryError)


class _Content(NamedTuple):
    weights: dict[str, Tensor]
    shape: NetworkShape
    step: int


def save(path: Path, networks: Networks, step: int) -> None:
    """Write policy and, where there is one, switch, after `step` training steps.

    Args:
        path: of the file.
        networks: online networks.
        step: of the training.
    """
    weights = {
        name: value.detach().cpu().clone(memory_format=torch.contiguous_format)
        for name, value in networks.state_dict().items()
        if not name.startswith(_LEARNING)
    }
    # One key: the order of several is not the same each time, and the same weights are to give the same bytes.
    header = json.dumps({"format": FORMAT, "step": step, "shape": networks.shape._asdict()}, sort_keys=True)
    # Not save_file: it makes a file that only its owner may read.
    path.write_bytes(serialised(weights, metadata={KEY: header}))


def load_into(path: Path, networks: Networks) -> int:
    """Give networks the weights in a file; returns the training step they are of. Q^A keeps what it had.

    Raises:
        UserError: the file is missing, not one of this program, or of other networks.
    """
    content = _read(path)
    _fill(networks, content, path)
    return content.step


def read(path: Path) -> tuple[Networks, int, int]:
    """The networks that a file describes, the training step they are of, and the length of their observations.

    Their Q^A is untrained.

    Raises:
        UserError: the file is missing or not one of this program.
    """
    content = _read(path)
    with_switch = any(name.startswith("switch") for name in content.weights)
    try:
        with torch.random.fork_rng(devices=[]):  # building draws weights; the caller's generator stays as it is
            networks = Networks(content.shape, with_switch)
    except _NONSENSE as error:
        raise UserError(f"{path} is damaged: no network can be built as its header describes one") from error
    _fill(networks, content, path)
    return networks.requires_grad_(False), content.step, content.shape.observation_size


def _fill(networks: Networks, content: _Content, path: Path) -> None:
    wanted, described = _driving(networks.shape), _driving(content.shape)
    if others := [name for name, value in wanted.items() if described[name] != value]:
        differences = ", ".join(f"{name} {described[name]} instead of {wanted[name]}" for name in others)
        raise UserError(f"{path} is for a network of another shape than the one that is to hold it: {differences}")
    try:
        missing, unexpected = networks.load_state_dict(content.weights, strict=False)
    except RuntimeError as error:
        raise UserError(f"the weights in {path} are of another shape than its header says") from error
    if unexpected or [name for name in missing if not name.startswith(_LEARNING)]:
        raise UserError(f"the weights in {path} are of other layers than the network that is to hold them has")


def _driving(shape: NetworkShape) -> dict[str, Any]:
    """What a shape says of policy and switch, as JSON gives it back; the actions' bounds are not in the weights."""
    values: dict[str, Any] = json.loads(json.dumps(shape._asdict()))
    return {name: value for name, value in values.items() if name not in _LEARNING_SHAPE}


def _read(path: Path) -> _Content:
    if not path.is_file():
        raise UserError(f"there is no file of a policy {path}")
    try:
        with safe_open(path, framework="pt") as file:
            header = json.loads((file.metadata() or {})[KEY])
            shape = _shape(header["shape"])
            if branch_size(shape) > path.stat().st_size:
                raise ValueError("its header describes a larger network than the file has weights for")
            weights = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118  # not a mapping
        if header["format"] != FORMAT:
            raise UserError(f"{path} is a policy of format {header['format']}, and this version reads {FORMAT}")
        return _Content(weights, shape, int(header["step"]))
    except (SafetensorError, OSError, *_NONSENSE) as error:
        raise UserError(f"{path} is damaged or not a policy written by tools.publish") from error


def _shape(values: dict[str, Any]) -> NetworkShape:
    scan_shape = values.pop("scan_shape")  # JSON knows no tuples
    shape = NetworkShape(**values, scan_shape=None if scan_shape is None else tuple(scan_shape))
    scans, beams = shape.scan_shape or (1, 1)
    if not (scans > 0 < beams and scans * beams <= shape.observation_size <= _LONGEST):
        raise ValueError("no task has such observations")
    return shape
