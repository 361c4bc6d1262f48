"""A training state is read as it was written, whatever it holds."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as of_numpy

from asddpg.algorithm.replay import BalancedReplay, ReplayBuffer, ReplayShape
from asddpg.runs import state_files
from tests.support.one_agent import ROBOT, transitions
from tests.support.small_runs import assert_same_tree

# The same examples each time.
quick = settings(
    max_examples=60, deadline=None, derandomize=True, database=None, suppress_health_check=[HealthCheck.too_slow]
)


def round_trip(tree: Any) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        state_files.write(Path(folder), tree)
        return state_files.read(Path(folder))


# Trees ------------------------------------------------------------------------------------------------------------

SHAPES = of_numpy.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=5)


@st.composite
def arrays(draw: st.DrawFn) -> np.ndarray[Any, Any]:
    """Any bits, those of denormal numbers and of every NaN among them."""
    dtype, shape = (np.dtype(draw(st.sampled_from(["i1", "i8", "u4", "u8", "f2", "f4", "f8"]))), draw(SHAPES))
    size = int(np.prod(shape)) * dtype.itemsize
    return np.frombuffer(draw(st.binary(min_size=size, max_size=size)), dtype).reshape(shape)


ARRAYS = st.one_of(arrays(), of_numpy.arrays(bool, SHAPES))
FLOATS = st.floats(allow_subnormal=False)  # which a training flushes to zero
LARGE = st.integers(513, 2000).map(lambda size: np.linspace(-1, 1, size, dtype=np.float32))
TENSORS = st.builds(
    lambda shape, dtype: torch.full(shape, 3, dtype=dtype),
    SHAPES,
    st.sampled_from([torch.float32, torch.float64, torch.uint8, torch.int64, torch.bfloat16]),
)
PLAIN = st.one_of(st.none(), st.booleans(), st.integers(-(2**200), 2**200), FLOATS, st.text())
# Names that stand for something in the files, in a zip, in NumPy's or in safetensors' own.
ODD = ["array", "tensor", "mapping", "dtype", "shape", "file", "allow_pickle", "__metadata__", "", "."]
KEYS = st.one_of(st.text(max_size=8), st.sampled_from([*ODD, "a", "a.b", "a.npy", "../a", "a/b", "0"]))
TREES = st.dictionaries(
    KEYS,
    st.recursive(
        st.one_of(PLAIN, ARRAYS, LARGE, TENSORS),
        lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(KEYS, inner, max_size=4)),
        max_leaves=12,
    ),
    max_size=5,
)


@quick
@given(TREES)
def test_a_tree_comes_back_to_the_last_bit(tree: dict[str, Any]) -> None:
    assert_same_tree(tree, round_trip(tree), "tree")


def test_views_and_tensors_that_share_memory() -> None:
    whole, rows = torch.arange(12.0).reshape(3, 4), np.arange(4000.0).reshape(40, 100)
    tree = {"a": whole, "b": whole[1], "c": whole.T, "d": rows[::2], "e": rows.T}
    assert_same_tree(tree, round_trip(tree), "tree")


ARRAYS_OF_OTHERS = (np.array([object()]), np.array([1], ">i4"), np.array(["a"]), np.float32(1))


@pytest.mark.parametrize("value", [object(), {1: 2}, {None: 1}, b"a", {1, 2}, *ARRAYS_OF_OTHERS])
def test_what_would_not_come_back_is_refused(value: object, tmp_path: Path) -> None:
    with pytest.raises(TypeError):
        state_files.write(tmp_path, {"a": value})


# Replay buffers ---------------------------------------------------------------------------------------------------


def fill(ring: ReplayBuffer, number: int, by_policy: bool = True) -> None:
    action = np.full((1, 2), number, np.float32)
    x = ring.observe(np.full((1, 3), number, np.float32), ROBOT)
    ring.add(transitions(x, action, (number, -number, 1.0, float(by_policy)), x))


def buffer(kind: type, capacity: int, seed: int = 0) -> Any:
    return kind(ReplayShape(capacity, 3, 2), np.random.default_rng(seed))


@settings(quick, max_examples=25)
@given(st.integers(1, 9), st.lists(st.booleans(), max_size=40), st.lists(st.booleans(), max_size=30))
@pytest.mark.parametrize("kind", [ReplayBuffer, BalancedReplay])
def test_a_replay_buffer_goes_on_as_if_never_kept(
    kind: type, capacity: int, before: list[bool], after: list[bool]
) -> None:
    one, other = buffer(kind, capacity), buffer(kind, capacity, seed=1)
    for number, by_policy in enumerate(before):
        fill(one, number, by_policy)
        one.sample(2)
    other.load_state(round_trip(one.state()))
    for number, by_policy in enumerate(after):
        for each in (one, other):
            fill(each, 100 + number, by_policy)
        np.testing.assert_array_equal(one.sample(5), other.sample(5))
    assert_same_tree(round_trip(one.state()), round_trip(other.state()), "replay")


@quick
@given(st.integers(1, 9), st.integers(0, 40))
def test_a_ring_holds_the_newest_in_their_order(capacity: int, count: int) -> None:
    ring = buffer(ReplayBuffer, capacity)
    for number in range(count):
        fill(ring, number, True)
    rows = ring._packed(np.arange(ring._begin, ring._end))
    assert rows[:, 0].tolist() == list(range(max(0, count - len(rows)), count))
    assert min(count, capacity) == len(ring) == len(rows)


@quick
@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 20))
def test_a_ring_of_another_size_is_refused_where_its_order_would_be_lost(kept: int, taken: int, count: int) -> None:
    one, other = buffer(ReplayBuffer, kept), buffer(ReplayBuffer, taken)
    for number in range(count):
        fill(one, number, True)
    if kept == taken or count <= min(kept, taken):
        other.load_state(one.state())
        fill(other, 50, True)
        rows = other.state()["rows"][:, 2]
        assert 50 in rows
        assert set(rows) <= {*range(count), 50}
    else:
        with pytest.raises(ValueError, match="cannot take"):
            other.load_state(one.state())
