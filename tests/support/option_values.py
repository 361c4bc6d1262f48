"""The options of the schema, their rules, and values of their types, for property-based tests."""

import typing
from collections.abc import Callable
from types import NoneType, UnionType
from typing import Any

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from tasks.options import options_of

ArgumentLists = SearchStrategy[list[str]]


def options(config: type) -> dict[str, Any]:
    """Options and their types."""
    return {option.name: option.kind for option in options_of(config)}


def rules(config: type) -> dict[str, Callable[[Any], bool]]:
    """The ranges, by option."""
    return {option.name: option.range.includes for option in options_of(config) if option.range}


def base(kind: Any) -> Any:
    """The type of an option that may be null besides."""
    return next(each for each in typing.get_args(kind) if each is not NoneType) if is_optional(kind) else kind


def is_optional(kind: Any) -> bool:
    return isinstance(kind, UnionType)


def values_of(kind: Any) -> SearchStrategy[Any]:
    """Values of a type, near the bounds of the ranges and far from them."""
    if typing.get_origin(kind) is list:
        return st.lists(values_of(typing.get_args(kind)[0]), max_size=5)
    whole = st.one_of(st.integers(-3, 250), st.integers(-(10**6), 10**6), st.integers(-(2**63) + 1, 2**63 - 1))
    kinds: dict[Any, SearchStrategy[Any]] = {
        int: whole,
        float: st.one_of(_floats(-1.5, 2.5), _floats()).filter(_is_no_dust),
        bool: st.booleans(),
        str: st.from_regex(r"[a-z]{1,8}", fullmatch=True),
    }
    return kinds[kind]


def _floats(low: float | None = None, high: float | None = None) -> SearchStrategy[float]:
    # prepare_torch turns off the numbers below the normal ones.
    return st.floats(low, high, allow_nan=False, allow_infinity=False, allow_subnormal=False)


def _is_no_dust(number: float) -> bool:
    return number == 0.0 or abs(number) > 1e-300  # what is smaller is read as 0
