"""What --help prints of a program, and the same as Markdown: every option with default, range and meaning."""

import dataclasses
import inspect
import re
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import MISSING
from typing import Any, NamedTuple

from asddpg.options.parsing import label
from asddpg.options.values import write_value
from tasks.options import TYPES, Option, alternatives, options_of

Choices = Mapping[str, Mapping[str, str]]  # of each group of presets: name → a sentence
_WIDTH, _INDENT = 100, " " * 6


class OptionGroup(NamedTuple):
    """Options that belong together."""

    name: str  # such as task.laser; empty at the top
    meaning: str
    options: list[Option]


def groups_of(kind: Any, name: str = "") -> Iterator[OptionGroup]:
    """The options of a dataclass, its own and after them those of each nested dataclass."""
    prefix = f"{name}." if name else ""
    inner = [(field.name, value) for field in dataclasses.fields(kind) if (value := _nested(kind, field)) is not None]
    own = [
        each for each in options_of(kind, prefix) if not any(each.name.startswith(f"{prefix}{n}.") for n, _ in inner)
    ]
    if own:
        doc = inspect.getdoc(kind if isinstance(kind, type) else type(kind)) or ""
        yield OptionGroup(name, doc.partition("\n\n")[0].replace("\n", " "), own)
    for field_name, value in inner:
        yield from groups_of(value, f"{prefix}{field_name}")


def _nested(kind: Any, field: dataclasses.Field[Any]) -> Any:
    """The dataclass object in a field; None where it holds another value."""
    if isinstance(kind, type):
        value = field.default if field.default_factory is MISSING else field.default_factory()
    else:
        value = getattr(kind, field.name)
    return value if dataclasses.is_dataclass(value) else None


def help_text(doc: str | None, kind: type, choices: Choices | None = None) -> str:
    """What --help prints.

    Args:
        doc: what the program does.
        kind: the dataclass of its arguments.
        choices: of presets, such as task=.
    """
    parts = [(doc or "").strip()]
    for name, presets in (choices or {}).items():
        width = max(map(len, presets))
        parts.append("\n".join([f"{name}=", *(f"  {preset:{width}}  {text}" for preset, text in presets.items())]))
    for group in groups_of(kind):
        positional = [option for option in group.options if not option.is_named]
        named = [option for option in group.options if option.is_named]
        if positional:
            parts.append("\n".join(["Arguments:", *map(_entry, positional)]))
        if named:
            title = f"{group.name}: {group.meaning}" if group.name else "Options:"
            parts.append("\n".join([*textwrap.wrap(title, _WIDTH), *map(_entry, named)]))
    return "\n\n".join(parts)


def _entry(option: Option) -> str:
    sentence = textwrap.fill(option.meaning, _WIDTH, initial_indent=_INDENT, subsequent_indent=_INDENT)
    return f"  {_with_default(option):40} {range_text(option)}\n{sentence}"


def _with_default(option: Option) -> str:
    if not option.is_named or option.value is MISSING:
        return label(option)
    return f"{option.name}={write_value(option.value)}"


def range_text(option: Option) -> str:
    """The values that an option takes."""
    kinds = [TYPES[kind] for kind in alternatives(option.type)]
    if option.range is not None:
        kinds[0] = option.range.text
    return " or ".join(kinds)


def markdown(doc: str | None, kind: type, choices: Choices | None = None) -> str:
    """The same as a section of a Markdown document."""
    parts = [_escaped((doc or "").strip())]
    for name, presets in (choices or {}).items():
        rows = [f"| `{name}={preset}` | {_escaped(text)} |" for preset, text in presets.items()]
        parts.append("\n".join([f"| `{name}=` | |", "|---|---|", *rows]))
    for group in groups_of(kind):
        title = f"**`{group.name}`** – {_escaped(group.meaning)}\n\n" if group.name else ""
        parts.append(
            f"{title}| option | default | values | meaning |\n|---|---|---|---|\n" + "\n".join(map(_row, group.options))
        )
    return "\n\n".join(parts)


def _row(option: Option) -> str:
    name = option.name if option.is_named else label(option)
    default = "required" if option.value is MISSING else f"`{write_value(option.value)}`"
    return f"| `{name}` | {default} | {_escaped(range_text(option))} | {_escaped(option.meaning)} |"


def _escaped(text: str) -> str:
    """A text for Markdown, which leaves what stands in backquotes as it is."""
    parts = text.split("`")
    parts[::2] = [re.sub(r"([*<|])", r"\\\1", part) for part in parts[::2]]
    return "`".join(parts)
