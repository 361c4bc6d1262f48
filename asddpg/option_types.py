"""What kind of value each option takes, and the sentence for a word that gives another."""

import dataclasses
import os
import re
import types
import typing
from collections.abc import Mapping
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, OverrideType
from hydra.errors import HydraException

from asddpg.config import TOO_LARGE
from asddpg.errors import UserError, truncated_repr

Kinds = Mapping[str, Any]  # option → its type

_WANTED = {
    int: "a whole number",
    float: "a number",
    bool: "true or false",
    str: "a single text",
    list[int]: "a list of whole numbers, such as [1,2]",
    list[float]: "a list of numbers, such as [1,2.5]",
    list[str]: "a list of words, such as [one,two]",
}
_YES_OR_NO = ("yes", "no", "on", "off", "y", "n", "true", "false")
_HAS_SYNTAX = re.compile(r"""["'\[\]{}\\,]""")


def kinds_of(config: Any, prefix: str = "") -> dict[str, Any]:
    """The type of every option of a configuration, by its full name."""
    kinds: dict[str, Any] = {}
    for name, kind in typing.get_type_hints(config).items():
        full = f"{prefix}{name}"
        kinds |= kinds_of(kind, f"{full}.") if dataclasses.is_dataclass(kind) else {full: kind}
    return kinds


def parse(argument: str, kinds: Kinds) -> Override:
    """A word of a command line.

    Raises:
        UserError: it is not of the form name=value with a value that is written out.
    """
    if "${" in argument:
        raise UserError(f"{truncated_repr(argument)} refers to a value by ${{…}}; write the value itself")
    name, _, value = argument.partition("=")
    override = _parsed(argument) or _parsed(_quoted(argument, kinds))
    if override is None and value and name in kinds:
        raise _wrong_kind(name, kinds[name], value)
    if override is None or override.type is not OverrideType.CHANGE or override.is_sweep_override() or override.package:
        raise UserError(f"{truncated_repr(argument)} is not an option of the form name=value, such as seed=1")
    return override


def _parsed(argument: str) -> Override | None:
    try:
        (override,) = OverridesParser.create().parse_overrides([argument])
    except (HydraException, ValueError, RecursionError):  # the latter two: endless digits, endless brackets
        return None
    return override


def _quoted(argument: str, kinds: Kinds) -> str:
    """A path as a user writes it, läufe or ~/runs, as Hydra reads it; other words as they are."""
    name, _, value = argument.partition("=")
    if str not in _alternatives(kinds.get(name)) or _HAS_SYNTAX.search(value) or not value.isprintable():
        return argument
    return f"{name}='{os.path.expanduser(value)}'"


def check_value(name: str, kind: Any, override: Override) -> None:
    """Hold a value against the type of its option.

    Raises:
        UserError: it is of another one.
    """
    value, text = override.value(), str(override.input_line).partition("=")[2]
    if value in ("", "???"):
        raise UserError(f"{name}={value} gives {name} no value; write one, or leave {name} out")
    if not any(_fits(value, alternative) for alternative in _alternatives(kind)):
        raise _wrong_kind(name, kind, text)
    for number in value if isinstance(value, list) else [value]:
        if isinstance(number, int) and abs(number) >= TOO_LARGE:
            raise UserError(f"{name} must be within ±2^63, not {truncated_repr(number)}")


def _wrong_kind(name: str, kind: Any, text: str) -> UserError:
    wanted = " or ".join(_WANTED.get(alternative, "null") for alternative in _alternatives(kind))
    return UserError(f"{name} must be {wanted}, not {truncated_repr(text)}")


def _alternatives(kind: Any) -> tuple[Any, ...]:
    return typing.get_args(kind) if isinstance(kind, types.UnionType) else (kind,)


def _fits(value: Any, kind: Any) -> bool:
    if kind is types.NoneType:
        return value is None
    if typing.get_origin(kind) is list:
        (inner,) = typing.get_args(kind)
        return isinstance(value, list) and all(_fits(each, inner) for each in value)
    if kind is bool:
        return isinstance(value, bool) or str(value).lower() in _YES_OR_NO
    if kind is str:
        return isinstance(value, str | int | float)  # run_dir=2026 is a number to Hydra
    numbers = int | float if kind is float else int
    return isinstance(value, numbers) and not isinstance(value, bool)
