"""A tree of plain values and arrays as a folder of files that carry data only, with their checksums.

`state.json` the tree, small arrays in it · `arrays.npz` the large ones · `weights.safetensors` torch's tensors ·
`SHA256SUMS` checksums of the three, as `sha256sum -c` reads them. Every number comes back to the last bit.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors.torch import load_file, save_file

STATE, ARRAYS, TENSORS, SUMS = "state.json", "arrays.npz", "weights.safetensors", "SHA256SUMS"
_MOST_INLINE = 512  # numbers of an array that stands in state.json
_INLINE, _ARRAY, _TENSOR = "inline array", "array", "tensor"  # keys of what stands for an array in the tree


class DamagedStateError(Exception):
    """The files are not as they were written; the message says which and how."""


def write(folder: Path, tree: Mapping[str, Any]) -> None:
    """Write a tree of mappings, sequences, strings, numbers, None, arrays and tensors; brought to the disk.

    Args:
        folder: an empty one.
        tree: mappings come back as dicts, sequences as lists.

    Raises:
        OSError: there is no room, or the folder cannot be written.
    """
    arrays: dict[str, Any] = {}
    tensors: dict[str, torch.Tensor] = {}
    text = json.dumps(_plain(tree, "", arrays, tensors))
    (folder / STATE).write_text(text, encoding="utf-8")
    with (folder / ARRAYS).open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)
    _save_tensors(tensors, folder / TENSORS)
    (folder / SUMS).write_text(_sums(folder), encoding="ascii")
    for path in (*(folder / name for name in (STATE, ARRAYS, TENSORS, SUMS)), folder):
        to_disk(path)


def read(folder: Path) -> dict[str, Any]:
    """Read what write() wrote.

    Raises:
        DamagedStateError: a file is missing or not what was written.
    """
    for name in (SUMS, STATE, ARRAYS, TENSORS):
        if not (folder / name).is_file():
            raise DamagedStateError(f"{name} is missing")
    try:
        sums = (folder / SUMS).read_text(encoding="ascii")
        if sums != _sums(folder):
            raise DamagedStateError(f"{_differing(folder, sums)} does not have the checksum in {SUMS}")
        tree = json.loads((folder / STATE).read_text(encoding="utf-8"))
        tensors = load_file(folder / TENSORS)
        with np.load(folder / ARRAYS, allow_pickle=False) as arrays:
            whole: dict[str, Any] = _restored(tree, arrays, tensors)
    except (ValueError, KeyError, EOFError) as error:
        raise DamagedStateError(f"it cannot be read: {error}") from error
    return whole


def to_disk(path: Path) -> None:
    """Wait until a file, or a folder's list of files, is on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def digest_of(path: Path) -> str:
    """SHA-256 of a file, hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _sums(folder: Path) -> str:
    return "".join(f"{digest_of(folder / name)}  {name}\n" for name in (STATE, ARRAYS, TENSORS))


def _differing(folder: Path, sums: str) -> str:
    lines = _sums(folder).splitlines()
    wrong = [line.split()[-1] for line in lines if line not in sums.splitlines()]
    return ", ".join(wrong) or SUMS


def _save_tensors(tensors: Mapping[str, torch.Tensor], path: Path) -> None:
    try:
        save_file({name: tensor.contiguous() for name, tensor in tensors.items()}, path)
    except Exception as error:  # safetensors' own, which says in words alone that the disk is full
        if type(error).__name__ != "SafetensorError":
            raise
        raise OSError(None, str(error), str(path)) from error


def _plain(value: Any, name: str, arrays: dict[str, Any], tensors: dict[str, torch.Tensor]) -> Any:
    """The tree for JSON; arrays and tensors go to their dictionaries, named by their place."""
    if isinstance(value, Mapping):
        return {key: _plain(each, f"{name}.{key}" if name else key, arrays, tensors) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each, f"{name}.{index}", arrays, tensors) for index, each in enumerate(value)]
    if isinstance(value, torch.Tensor):
        tensors[name] = value
        return {_TENSOR: name}
    if not isinstance(value, np.ndarray):
        return value
    if value.size > _MOST_INLINE:
        arrays[name] = value
        return {_ARRAY: name}
    return {_INLINE: value.tolist(), "dtype": value.dtype.str, "shape": value.shape}


def _restored(value: Any, arrays: Mapping[str, Any], tensors: Mapping[str, torch.Tensor]) -> Any:
    if isinstance(value, list):
        return [_restored(each, arrays, tensors) for each in value]
    if not isinstance(value, dict):
        return value
    if _INLINE in value:
        return np.array(value[_INLINE], dtype=np.dtype(value["dtype"])).reshape(value["shape"])
    if _ARRAY in value:
        return arrays[value[_ARRAY]]
    if _TENSOR in value:
        return tensors[value[_TENSOR]]
    return {key: _restored(each, arrays, tensors) for key, each in value.items()}
