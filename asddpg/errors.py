"""Exceptions that end a program in one sentence."""

from collections.abc import Callable
from importlib import import_module
from typing import Any

_MAX_LENGTH = 60  # characters of a value in a sentence


class NumericalFailure(Exception):  # noqa: N818  # the field's word
    """A training met NaN or an infinite number; the message says where, and how to repeat it."""


class UserError(Exception):
    """One sentence on what is wrong and what would be right; the programs print it and exit with status 2."""


def truncated_repr(value: object) -> str:
    """A value for a sentence: text in quotes, cut where it is long."""
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= _MAX_LENGTH else f"{text[: _MAX_LENGTH - 2]}…{text[-1]}"


def import_factory(name: str) -> Callable[..., Any] | None:
    """What `package.module:Factory` names, which only a user may have typed; None where there is no such callable.

    Raises:
        UserError: the module is there, and cannot be imported.
    """
    module, separator, attribute = name.partition(":")
    if not separator:
        return None
    try:
        factory = getattr(import_module(module), attribute, None)
    except (ValueError, TypeError):  # no name of a module
        return None
    except (ImportError, SyntaxError) as error:
        if isinstance(error, ModuleNotFoundError) and f"{module}.".startswith(f"{error.name}."):
            return None
        raise UserError(f"{truncated_repr(module)} cannot be imported: {error}") from error
    return factory if callable(factory) else None


def import_extra(module: str, extra: str, use: str) -> Any:
    """A library that an extra of this package brings, for a `use` in the plural; UserError where it is missing."""
    try:
        return import_module(module)
    except ImportError as error:
        raise UserError(f"{use} need {module}, which is not installed: pip install 'asddpg[{extra}]'") from error
