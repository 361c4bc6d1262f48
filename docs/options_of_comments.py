"""Options as Markdown from the comments in asddpg/config.py, until tools/options_reference.py renders them."""

import ast
import inspect
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

from asddpg import config

PROGRAMS = {"train": config.TrainConfig, "evaluate": config.EvaluateConfig, "play": config.PlayConfig}


def options_reference() -> str:
    """A section for each program, with a table of its options."""
    return "\n\n".join(f"## `asddpg.{name}`\n\n{_table(kind)}" for name, kind in PROGRAMS.items())


def _table(kind: type) -> str:
    rows = []
    for name, default, meaning in _walk(kind, ""):
        allowed = config.RULES.get(name, (None, ""))[1]
        rows.append(f"| `{name}` | `{default}` | {allowed} | {meaning} |")
    return "\n".join(["| option | default | range | meaning |", "|---|---|---|---|", *rows])


def _walk(kind: type[Any], prefix: str) -> Iterator[tuple[str, str, str]]:
    comments = {name: text for base in reversed(kind.__mro__[:-1]) for name, text in _comments(base).items()}
    for field in fields(kind):
        value = field.default if field.default_factory is MISSING else field.default_factory()
        if is_dataclass(value):
            yield from _walk(type(value), f"{prefix}{field.name}.")
        elif field.name != "name":
            yield f"{prefix}{field.name}", str(value), comments.get(field.name, "").replace("|", "\\|")


def _comments(kind: type[Any]) -> dict[str, str]:
    lines = inspect.getsource(kind).splitlines()
    found = {}
    for node in ast.walk(ast.parse("\n".join(lines))):
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            above, row = [], node.lineno - 2
            while lines[row].lstrip().startswith("#"):
                above.insert(0, lines[row].lstrip().removeprefix("# "))
                row -= 1
            found[node.target.id] = " ".join(above)
    return found
