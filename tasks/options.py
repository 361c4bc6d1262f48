"""Options: fields of a dataclass, each with its default, its meaning and its range beside it.

The same declaration checks a value that a program passes, a value of a stored configuration and one of a command line,
and it becomes `--help` and the reference of the documentation.
"""

import copy
import dataclasses
import difflib
import math
import reprlib
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING
from numbers import Integral, Real
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from tasks.errors import TaskError

T = TypeVar("T")

_LARGEST = 2**63  # no option needs such a whole number, and not every counter can hold it


class Range(NamedTuple):
    """The values that an option takes, and the end of the sentence "it must be …"."""

    includes: Callable[[Any], bool]
    text: str


def between(low: float, high: float, note: str = "") -> Range:
    """From the one to the other, both included."""
    return Range(lambda value: low <= value <= high, f"from {low} to {high}{note}")


def one_of(*choices: str) -> Range:
    """One of these texts."""
    return Range(lambda value: value in choices, " or ".join(filter(None, (", ".join(choices[:-1]), choices[-1]))))


def some_of(*choices: str) -> Range:
    """A list of some of these texts."""
    return Range(lambda values: set(values) <= set(choices), f"some of {', '.join(choices)}")


POSITIVE = Range(lambda value: value > 0, "greater than 0")
NOT_NEGATIVE = Range(lambda value: value >= 0, "0 or more")
SHARE = between(0, 1)


def suggest_name(name: str, known: Iterable[str], otherwise: str) -> str:
    """The end of a sentence on a wrong name: the known name that it is a slip of, if any, else what there is."""
    alike = difflib.get_close_matches(name, list(known), n=1, cutoff=0.8)
    return f"did you mean {alike[0]}?" if alike else otherwise


TYPES: dict[Any, str] = {
    int: "a whole number",
    float: "a number",
    bool: "true or false",
    str: "a single text",
    Path: "a path",
    list[int]: "a list of whole numbers, such as [1,2]",
    list[float]: "a list of numbers, such as [1,2.5]",
    list[str]: "a list of texts, such as [one,two]",
    list[Path]: "paths",
    types.NoneType: "null",
}
_CLASSES: dict[Any, type] = {
    int: Integral,
    float: Real,
    bool: bool,
    str: str,
    Path: Path,
    types.NoneType: types.NoneType,
}


def option(default: Any, meaning: str, values: Range | None = None, *, name: str = "", is_named: bool = True) -> Any:
    """A field that a user may set.

    Args:
        default: its value where the user gives none; MISSING where one must be given. Lists are copied.
        meaning: one sentence, with the unit.
        values: its range; None where the type says it all.
        name: on a command line, where it is not the field's.
        is_named: whether a command line gives it as name=value; else by its place.
    """
    metadata = {"meaning": meaning, "range": values, "name": name, "is_named": is_named}
    if isinstance(default, list):
        return dataclasses.field(default_factory=default.copy, metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def argument(meaning: str, default: Any = MISSING, values: Range | None = None) -> Any:
    """A field that a command line gives by its place, without a name; arguments come before options."""
    return option(default, meaning, values, is_named=False)


class Option(NamedTuple):
    """An option as declared: its full name, its type, and what stands beside it."""

    name: str  # such as task.laser.noise
    kind: Any
    value: Any  # of a class the default; MISSING where one must be given
    meaning: str
    range: Range | None
    is_named: bool
    group: str  # such as task.laser; empty at the top
    owner: type  # the dataclass that declares it

    def requirement(self, value: Any) -> str:
        """What the value must be, such as "0 or more"; empty if it is."""
        kinds = alternatives(self.kind)
        if not any(_is_of(value, kind) for kind in kinds):
            return " or ".join(TYPES[kind] for kind in kinds)
        for number in value if isinstance(value, list) else [value]:
            if isinstance(number, float) and not math.isfinite(number):
                return "a finite number"
            if isinstance(number, int) and abs(number) >= _LARGEST:
                return "within ±2^63"
        return "" if value is None or self.range is None or self.range.includes(value) else self.range.text


def alternatives(kind: Any) -> tuple[Any, ...]:
    """The types that an option takes: int | None takes two."""
    return typing.get_args(kind) if isinstance(kind, types.UnionType) else (kind,)


def _is_of(value: Any, kind: Any) -> bool:
    if typing.get_origin(kind) is list:
        (inner,) = typing.get_args(kind)
        return isinstance(value, list) and all(_is_of(each, inner) for each in value)
    return isinstance(value, _CLASSES[kind]) and (kind is bool or not isinstance(value, bool))


def options_of(config: Any, group: str = "") -> Iterator[Option]:
    """Every option of a dataclass or of an object of it, nested ones by their full names."""
    owner = config if isinstance(config, type) else type(config)
    hints, prefix = typing.get_type_hints(owner), f"{group}." if group else ""
    for each in dataclasses.fields(config):
        value = default_of(each) if isinstance(config, type) else getattr(config, each.name)
        about = each.metadata
        if dataclasses.is_dataclass(value):
            yield from options_of(value, f"{prefix}{each.name}")
        elif about:
            name, kind = about["name"] or f"{prefix}{each.name}", hints[each.name]
            yield Option(name, kind, value, about["meaning"], about["range"], about["is_named"], group, owner)


def default_of(field: dataclasses.Field[Any]) -> Any:
    """The value of a field where none is given; MISSING where one must be."""
    return field.default if field.default_factory is MISSING else field.default_factory()


def check_options(config: Any) -> None:
    """Hold every option of an object against its type and its range.

    Raises:
        TaskError: the first that is out of range.
    """
    for name, value in vars(config).items():
        if isinstance(value, np.generic):  # JSON has Python's numbers; float32's 0.2 becomes 0.2
            setattr(config, name, float(str(value)) if isinstance(value, np.floating) else value.item())
    for each in options_of(config):
        if requirement := each.requirement(each.value):
            raise TaskError(f"{each.name} must be {requirement}, not {reprlib.repr(each.value)}")


def build_options(owner: type[T], name: str, value: Any) -> T:
    """An object of a class of options, or of a derived one: a copy, checked again, or made of a mapping by name.

    Raises:
        TaskError: neither; an unknown option; a value out of range.
    """
    names = [each.name for each in dataclasses.fields(typing.cast(Any, owner))]
    if isinstance(value, owner):
        copied: Any = copy.deepcopy(value)
        copied.__post_init__()
        return typing.cast(T, copied)
    if not isinstance(value, Mapping):
        raise TaskError(f"{name} must be a {owner.__name__} or a mapping of its options, not {reprlib.repr(value)}")
    for key in value:
        if key not in names:
            raise TaskError(f"{name} has no option {key!r}; there are {', '.join(names)}")
    return owner(**value)
