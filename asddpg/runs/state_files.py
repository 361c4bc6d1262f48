"""A tree of plain values and arrays as a folder of files that carry data only, with their checksums.

`state.json` the tree, small arrays in it · `arrays.npz` the large ones · `weights.safetensors` torch's tensors ·
`SHA256SUMS` checksums of the three, as `sha256sum -c` reads them. Every number is restored to the last bit.
"""

import hashlib
import json
import os
import re
import zipfile
from base64 import b64decode, b64encode
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from safetensors.torch import save as serialised

from asddpg.runs.safe_loading import check_packed

STATE, ARRAYS, TENSORS, SUMS = "state.json", "arrays.npz", "weights.safetensors", "SHA256SUMS"
_MOST_INLINE = 512  # numbers of an array inside state.json
# Keys of placeholders for arrays in the tree, and for a mapping that has such keys itself.
_INLINE, _ARRAY, _TENSOR, _MAPPING = "inline array", "array", "tensor", "mapping"
_MARKERS = frozenset((_INLINE, _ARRAY, _TENSOR, _MAPPING))
# Raised by files that have right checksums and yet were not written by write().
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
    arrays: dict[str, Any] = {}
    tensors: dict[str, torch.Tensor] = {}
    text = json.dumps(_plain(tree, "", arrays, tensors))
    (folder / STATE).write_text(text, encoding="utf-8")
    with (folder / ARRAYS).open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)
    # Not save_file: it makes a file that only its owner may read, and reports a full disk without an errno.
    (folder / TENSORS).write_bytes(serialised(tensors))
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
        sums = (folder / SUMS).read_text(encoding="ascii", errors="replace")
        if sums != _sums(folder):
            raise DamagedStateError(f"{_differing(folder, sums)} does not have the checksum in {SUMS}")
        tree = json.loads((folder / STATE).read_text(encoding="utf-8"))
        tensors = load_file(folder / TENSORS)
        check_packed(folder / ARRAYS, largest=(folder / ARRAYS).stat().st_size)  # written unpacked
        with np.load(folder / ARRAYS, allow_pickle=False) as archive:
            arrays = dict(archive)  # each once, however often it is named
        whole: dict[str, Any] = _restored(tree, arrays, tensors)
    except (SafetensorError, zipfile.BadZipFile, *INVALID) as error:
        raise DamagedStateError(f"it cannot be read: {error}") from error
    if not isinstance(whole, dict):
        raise DamagedStateError(f"{STATE} holds no mapping")
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


def _plain(value: Any, place: str, arrays: dict[str, Any], tensors: dict[str, torch.Tensor]) -> Any:
    """The tree for JSON; arrays and tensors go to their dictionaries, named by their place."""
    if isinstance(value, Mapping):
        return _plain_mapping(value, place, arrays, tensors)
    if isinstance(value, list | tuple):
        return [_plain(each, f"{place}.{index}", arrays, tensors) for index, each in enumerate(value)]
    if isinstance(value, torch.Tensor):
        name = _name(place, tensors)
        # A copy, because safetensors takes no two that share memory.
        tensors[name] = value.detach().cpu().clone(memory_format=torch.contiguous_format)
        return {_TENSOR: name}
    if not isinstance(value, np.ndarray):
        return value  # for JSON, which refuses what it does not know
    if value.dtype.kind not in "biuf":
        raise TypeError(f"{place} holds an array of {value.dtype}, and arrays of numbers alone can be written")
    if value.size > _MOST_INLINE:
        name = _name(place, arrays)
        arrays[name] = value
        return {_ARRAY: name}
    # Not as decimal numbers: where denormal ones are flushed to zero, reading them would.
    return {_INLINE: b64encode(value.tobytes()).decode(), "dtype": value.dtype.str, "shape": value.shape}


def _plain_mapping(value: Mapping[Any, Any], place: str, arrays: Any, tensors: Any) -> dict[str, Any]:
    if not all(isinstance(key, str) for key in value):
        raise TypeError(f"{place or 'the tree'} has a key that is no string")
    plain = {key: _plain(each, f"{place}.{key}" if place else key, arrays, tensors) for key, each in value.items()}
    return plain if _MARKERS.isdisjoint(value) else {_MAPPING: plain}


def _name(place: str, taken: Mapping[str, Any]) -> str:
    """The place in letters that any file may have, and no name twice."""
    return f"{len(taken):03d}.{re.sub(r'[^A-Za-z0-9_.]', '_', place)[:100]}"


def _restored(value: Any, arrays: Mapping[str, Any], tensors: Mapping[str, torch.Tensor]) -> Any:
    if isinstance(value, list):
        return [_restored(each, arrays, tensors) for each in value]
    if not isinstance(value, dict):
        return value
    if _INLINE in value:
        content = b64decode(value[_INLINE], validate=True)
        return np.frombuffer(content, np.dtype(value["dtype"])).reshape(value["shape"]).copy()
    if _ARRAY in value:
        return arrays[value[_ARRAY]]
    if _TENSOR in value:
        return tensors[value[_TENSOR]]
    return {key: _restored(each, arrays, tensors) for key, each in value.get(_MAPPING, value).items()}
