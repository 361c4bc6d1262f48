"""The one parser of command lines: a dataclass of options declares what a program takes."""

import dataclasses
import difflib
import os
from collections.abc import Mapping, Sequence
from dataclasses import MISSING
from typing import Any, TypeVar

from asddpg.errors import UserError, truncated_repr
from asddpg.options.habits import hydra_sentence
from asddpg.options.values import check_value, read_value
from tasks.options import Option, default_of, options_of

Arguments = TypeVar("Arguments")


@dataclasses.dataclass(frozen=True)
class NoArguments:
    """Of a program that takes none."""


def parse_arguments(kind: type[Arguments], arguments: Sequence[str], may_repeat: bool = False) -> Arguments:
    """The arguments of a program.

    Args:
        kind: a dataclass of options and, before them, of positional arguments; the last of those may be a list.
        arguments: of the command line, each name=value or, by their order, positional.
        may_repeat: whether an option may be given several times; the last counts.

    Raises:
        UserError: one is unknown, given twice, of another type or out of range, or one is missing.
    """
    options = list(options_of(kind))
    named = {option.name: option for option in options if option.is_named}
    positional = [option for option in options if not option.is_named]
    values: dict[str, Any] = {}
    texts: dict[str, str] = {}
    plain: list[str] = []
    for argument in arguments:
        name, equals, text = argument.partition("=")
        is_option = argument.startswith("-") or (equals and "/" not in name)
        if positional and name not in named and (not is_option or os.path.exists(argument)):
            plain.append(argument)
            continue
        option = find_option(argument, named)
        if name in texts and not may_repeat:
            raise UserError(f"{name} is given twice, as {truncated_repr(texts[name])} and {truncated_repr(text)}")
        texts[name], values[name] = text, read_value(option, text)
    values |= _assign(positional, plain)
    for option in options:
        if option.name not in values and option.value is MISSING:
            raise UserError(f"{label(option)} is missing: {option.meaning[0].lower()}{option.meaning[1:].rstrip('.')}")
    parsed: Arguments = with_values(kind, values)
    return parsed


def find_option(argument: str, options: Mapping[str, Option], others: Sequence[str] = ()) -> Option:
    """The option that an argument name=value sets.

    Args:
        argument: of a command line.
        options: by name.
        others: further names to suggest.

    Raises:
        UserError: it is of another form, or there is no such option.
    """
    name, equals, _ = argument.partition("=")
    if equals and name in options:
        return options[name]
    if sentence := hydra_sentence(name):
        raise UserError(f"{truncated_repr(argument)} is no option; {sentence}")
    if not options:
        raise UserError(f"this program takes no options, not {truncated_repr(argument)}")
    known = [*others, *options]
    meant = name.lstrip("-+~").replace("-", "_").lower()
    if not equals or not name:
        example = next((each for each in (meant, "seed") if each in known), known[-1])
        raise UserError(f"{truncated_repr(argument)} is not an option of the form name=value, such as {example}=…")
    raise UserError(f"there is no option {truncated_repr(name)}; {_suggestion(meant, known)}")


def _suggestion(name: str, known: Sequence[str]) -> str:
    last = name.rsplit(".", 1)[-1]
    alike = [option for option in known if option.rsplit(".", 1)[-1] == last]
    alike = alike or difflib.get_close_matches(name, known, n=3, cutoff=0.6)
    return f"did you mean {' or '.join(alike)}?" if alike else f"there are {', '.join(known)}"


def _assign(options: Sequence[Option], plain: Sequence[str]) -> dict[str, Any]:
    """Positional arguments by name."""
    values: dict[str, Any] = {}
    rest = list(plain)
    for option in options:
        if is_list(option):
            values |= {option.name: [read_value(_item(option), text) for text in rest]} if rest else {}
            if rest:
                check_value(option, values[option.name])
            return values
        if rest:
            values[option.name] = read_value(option, rest.pop(0))
    if rest:
        taken = f"{len(options)} argument{'s' * (len(options) > 1)} without a name at most"
        names, shown = " and ".join(map(label, options)), ", ".join(map(truncated_repr, plain[:3]))
        raise UserError(f"the program takes {taken}, {names}, not {len(plain)}: {shown}{', …' * (len(plain) > 3)}")
    return values


def _item(option: Option) -> Option:
    return option._replace(kind=option.kind.__args__[0], range=None)


def is_list(option: Option) -> bool:
    """Whether an option takes several values."""
    return getattr(option.kind, "__origin__", None) is list


def label(option: Option) -> str:
    """How an option without a default is called: FILE, FILES… or run=."""
    return f"{option.name}=" if option.is_named else f"{option.name.upper()}{'…' * is_list(option)}"


def with_values(config: Any, values: Mapping[str, Any]) -> Any:
    """A dataclass, or an object of it, with other values of some options.

    Args:
        config: the one or the other; an object stays as it is.
        values: by the full names of options.

    Raises:
        TaskError: values of a task contradict one another.
    """
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(config):
        name = field.metadata.get("name") or field.name
        inner = {key.partition(".")[2]: value for key, value in values.items() if key.startswith(f"{name}.")}
        if name in values:
            changes[field.name] = values[name]
        elif inner:
            current = default_of(field) if isinstance(config, type) else getattr(config, field.name)
            changes[field.name] = with_values(current, inner)
    return config(**changes) if isinstance(config, type) else dataclasses.replace(config, **changes)


def flatten(values: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Values of nested mappings by their full names, such as agent.gamma."""
    flat: dict[str, Any] = {}
    for name, value in values.items():
        flat |= flatten(value, f"{prefix}{name}.") if isinstance(value, Mapping) else {f"{prefix}{name}": value}
    return flat
