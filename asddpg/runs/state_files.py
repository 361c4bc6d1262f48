"""A tree of plain values and arrays as a folder of files that carry data only, with their checksums.

`state.json` the tree · `arrays.safetensors` its arrays and tensors · `SHA256SUMS` checksums of both, as `sha256sum -c`
reads them. Every number is restored to the last bit.
"""

import hashlib
import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load_file

STATE, ARRAYS, SUMS = "state.json", "arrays.safetensors", "SHA256SUMS"
# Keys of placeholders for arrays in the tree, and for a mapping that has such keys itself.
_ARRAY, _TENSOR, _MAPPING = "array", "tensor", "mapping"
_MARKERS = frozenset((_ARRAY, _TENSOR, _MAPPING))
# What safetensors calls the kinds of numbers.
_DTYPES = {
    **{torch.float64: "F64", torch.float32: "F32", torch.float16: "F16", torch.bfloat16: "BF16", torch.bool: "BOOL"},
    **{torch.int64: "I64", torch.int32: "I32", torch.int16: "I16", torch.int8: "I8"},
    **{torch.uint64: "U64", torch.uint32: "U32", torch.uint16: "U16", torch.uint8: "U8"},
}
# Raised by values of a wrong kind or size, in files that are whole and yet were not written by this program.
INVALID = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RuntimeError, EOFError, MemoryError)


class DamagedStateError(Exception):
    """The files are not as they were written; the message says which and how."""


def write(folder: Path, tree: Mapping[str, Any]) -> None:
    """Write a tree of mappings, sequences, strings, numbers, None, arrays and tensors; flushed to the disk.

    Args:
        folder: an empty one.
        tree: mappings with string keys are restored as dicts, lists and tuples as lists.

    Raises:
        OSError: the disk is full, or the folder cannot be written.
        TypeError: there is something else in the tree.
    """
    tensors: dict[str, torch.Tensor] = {}
    text = json.dumps(_to_json(tree, "", tensors))
    (folder / STATE).write_text(text, encoding="utf-8")
    _write_tensors(folder / ARRAYS, tensors)
    (folder / SUMS).write_text(_checksums(folder), encoding="ascii")
    for path in (folder / STATE, folder / ARRAYS, folder / SUMS, folder):
        to_disk(path)


def read(folder: Path) -> dict[str, Any]:
    """Read what write() wrote.

    Raises:
        DamagedStateError: a file is missing or not what was written.
    """
    for name in (SUMS, STATE, ARRAYS):
        if not (folder / name).is_file():
            raise DamagedStateError(f"{name} is missing")
    try:
        sums, actual = (folder / SUMS).read_text(encoding="ascii", errors="replace"), _checksums(folder)
        if sums != actual:
            lines = sums.splitlines()
            changed = ", ".join(line.split()[-1] for line in actual.splitlines() if line not in lines) or SUMS
            raise DamagedStateError(f"{changed} does not have the checksum in {SUMS}")
        tree = _from_json(json.loads((folder / STATE).read_text(encoding="utf-8")), load_file(folder / ARRAYS))
    except (SafetensorError, *INVALID) as error:
        raise DamagedStateError(f"it cannot be read: {error}") from error
    if not isinstance(tree, dict):
        raise DamagedStateError(f"{STATE} holds no mapping")
    return tree


def to_disk(path: Path) -> None:
    """Wait until a file, or a folder's list of files, is on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def file_digest(path: Path) -> str:
    """SHA-256 of a file, hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _checksums(folder: Path) -> str:
    return "".join(f"{file_digest(folder / name)}  {name}\n" for name in (STATE, ARRAYS))


def _write_tensors(path: Path, tensors: Mapping[str, torch.Tensor]) -> None:
    """Write a file of safetensors, a tensor after the other.

    The library's own functions hold up to three copies of all of them at once, as much as the rest of a training.
    """
    header, end = {}, 0
    names = sorted(tensors, key=lambda name: -tensors[name].itemsize)  # so that each begins at a multiple of its size
    for name in names:
        tensor = tensors[name]
        begin, end = end, end + tensor.nbytes
        header[name] = {"dtype": _DTYPES[tensor.dtype], "shape": [*tensor.shape], "data_offsets": [begin, end]}
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    with path.open("wb") as file:
        file.write(len(text).to_bytes(8, "little") + text)
        for name in filter(lambda name: tensors[name].numel(), names):  # torch has no bytes of an empty one
            file.write(tensors[name].reshape(-1).view(torch.uint8).numpy().data)


def _to_json(value: Any, place: str, tensors: dict[str, torch.Tensor]) -> Any:
    """The tree for JSON; arrays and tensors go to a dictionary, named by their place."""
    if isinstance(value, Mapping):
        if not all(isinstance(key, str) for key in value):
            raise TypeError(f"{place or 'the tree'} has a key that is no string")
        plain = {key: _to_json(each, f"{place}.{key}" if place else key, tensors) for key, each in value.items()}
        return plain if _MARKERS.isdisjoint(value) else {_MAPPING: plain}
    if isinstance(value, list | tuple):
        return [_to_json(each, f"{place}.{index}", tensors) for index, each in enumerate(value)]
    if not isinstance(value, torch.Tensor | np.ndarray):
        return value  # for JSON, which refuses what it does not know
    # The place in letters that any file may have, and no name twice.
    name = f"{len(tensors):03d}.{re.sub(r'[^A-Za-z0-9_.]', '_', place)[:100]}"
    if isinstance(value, torch.Tensor):
        tensors[name] = value.detach().cpu().contiguous()
        return {_TENSOR: name}
    if value.dtype.kind not in "biuf" or not value.dtype.isnative:
        raise TypeError(f"{place} holds an array of {value.dtype}, and arrays of native numbers alone can be written")
    is_ready = value.flags.c_contiguous and value.flags.writeable  # torch warns of an array that is not writable
    tensors[name] = torch.from_numpy(value if is_ready else value.copy(order="C"))
    return {_ARRAY: name}


def _from_json(value: Any, tensors: Mapping[str, torch.Tensor]) -> Any:
    if isinstance(value, list):
        return [_from_json(each, tensors) for each in value]
    if not isinstance(value, dict):
        return value
    if _ARRAY in value:
        return tensors[value[_ARRAY]].numpy()
    if _TENSOR in value:
        return tensors[value[_TENSOR]]
    return {key: _from_json(each, tensors) for key, each in value.get(_MAPPING, value).items()}
