"""Values of options as text: read from a command line, written for one."""

import math
import os
import re
import types
import typing
import unicodedata
from pathlib import Path
from typing import Any

from asddpg.errors import UserError, truncated_repr
from asddpg.options.habits import sweep_hint
from tasks.options import TYPES, Option, alternatives

_WHOLE = re.compile(r"[+-]?[0-9]+(_[0-9]+)*")
_NUMBER = re.compile(r"[+-]?(([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?|inf|nan)", re.IGNORECASE)
_TRUTH = {"true": True, "yes": True, "on": True, "y": True, "false": False, "no": False, "off": False, "n": False}


def read_value(option: Option, text: str) -> Any:
    """The value that a text gives an option.

    Raises:
        UserError: it is of another type, or out of range.
    """
    if not text:
        raise UserError(f"{option.name}= gives {option.name} no value; write one, or leave {option.name} out")
    kinds = alternatives(option.kind)
    value: Any = text
    try:
        value = _read(text, kinds)
        requirement = option.requirement(value)
    except ValueError:
        requirement = " or ".join(TYPES[kind] for kind in kinds)
    if requirement:
        hint = "" if typing.get_origin(kinds[0]) is list else sweep_hint(option.name, text)
        raise UserError(f"{option.name} must be {requirement}, not {truncated_repr(value)}{hint}")
    return value


def check_value(option: Option, value: Any) -> None:
    """UserError where an option does not take the value."""
    if requirement := option.requirement(value):
        raise UserError(f"{option.name} must be {requirement}, not {truncated_repr(value)}")


def check_stored(option: Option, value: Any) -> Any:
    """A value of a YAML file as the option has it: 1 is a number too; UserError where the option does not take it."""
    check_value(option, value)
    if option.kind == list[float]:
        return [float(each) for each in value]
    return float(value) if option.kind is float else value


def _read(text: str, kinds: tuple[Any, ...]) -> Any:
    if text == "null" and types.NoneType in kinds:
        return None
    kind = kinds[0]
    if typing.get_origin(kind) is list:
        return _read_list(text, typing.get_args(kind))
    if kind is int:
        return int(_matching(_WHOLE, text))
    if kind is float:
        return float(_matching(_NUMBER, text))
    if kind is bool:
        if text.lower() not in _TRUTH:
            raise ValueError
        return _TRUTH[text.lower()]
    # It steers no terminal, and libraries that take UTF-8 alone open it as a path: UnicodeError is a ValueError.
    if not text or "Cc" in map(unicodedata.category, os.fsencode(text).decode()):
        raise ValueError
    text = os.path.expanduser(text)
    return Path(text) if kind is Path else text


def _read_list(text: str, kinds: tuple[Any, ...]) -> list[Any]:
    """[1,2] or, without what a shell may want quoted, 1,2."""
    if text.startswith("[") != text.endswith("]"):
        raise ValueError
    items = text.removeprefix("[").removesuffix("]")
    return [_read(item.strip(), kinds) for item in items.split(",")] if items else []


def _matching(form: re.Pattern[str], text: str) -> str:
    if not form.fullmatch(text):
        raise ValueError
    return text


def write_value(value: Any) -> str:
    """A value as a command line has it; read_value() gives it back."""
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, list):
        return f"[{','.join(write_value(item) for item in value)}]"
    return repr(value) if isinstance(value, float) and math.isfinite(value) else str(value)
