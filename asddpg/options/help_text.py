"""What --help prints of a program, and the same as Markdown: every option with default, range and meaning."""

import inspect
import re
import textwrap
from collections.abc import Mapping
from dataclasses import MISSING

from asddpg.options.parsing import label
from asddpg.options.values import write_value
from tasks.options import TYPES, Option, alternatives, options_of

Choices = Mapping[str, Mapping[str, str]]  # of each group of presets: name → a sentence
_WIDTH, _INDENT = 100, " " * 6


def _groups(kind: type) -> dict[tuple[str, str], list[Option]]:
    """Options by the name and the meaning of their group; the program's own come first."""
    groups: dict[tuple[str, str], list[Option]] = {("", ""): []}
    for option in options_of(kind):
        doc = inspect.getdoc(option.owner) or ""
        meaning = doc.partition("\n\n")[0].replace("\n", " ") if option.group else ""
        groups.setdefault((option.group, meaning), []).append(option)
    return groups


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
    for (name, meaning), options in _groups(kind).items():
        for title, is_named in (("Arguments", False), (f"{name}: {meaning}" if name else "Options", True)):
            if chosen := [option for option in options if option.is_named is is_named]:
                parts.append("\n".join([*textwrap.wrap(title, _WIDTH), *map(_entry, chosen)]))
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
    kinds = [TYPES[kind] for kind in alternatives(option.kind)]
    if option.range is not None:
        kinds[0] = option.range.text
    return " or ".join(kinds)


def markdown(doc: str | None, kind: type, choices: Choices | None = None) -> str:
    """The same as a section of a Markdown document."""
    parts = [_escaped((doc or "").strip())]
    for name, presets in (choices or {}).items():
        rows = [f"| `{name}={preset}` | {_escaped(text)} |" for preset, text in presets.items()]
        parts.append("\n".join([f"| `{name}=` | |", "|---|---|", *rows]))
    for (name, meaning), options in _groups(kind).items():
        title = [f"**`{name}`** – {_escaped(meaning)}", ""] if name else []
        if options:
            parts.append(
                "\n".join([*title, "| option | default | values | meaning |", "|---|---|---|---|", *map(_row, options)])
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
