"""Reference of options as Markdown, from the same declarations as --help."""

import importlib
import inspect
import pkgutil
from dataclasses import is_dataclass
from types import ModuleType

import tools
from asddpg import config

PROGRAMS = {"train": config.TrainConfig, "evaluate": config.EvaluateConfig, "play": config.PlayConfig}


def render_options(program: str) -> str:
    """Tables of the options of a program: of asddpg.train, evaluate or play, or, for `tools`, of every tool."""
    if program == "tools":
        names = [module.name for module in pkgutil.iter_modules(tools.__path__) if not module.ispkg]
        modules = [importlib.import_module(f"tools.{name}") for name in names]
        return "\n\n".join(_render_tool(module) for module in modules if hasattr(module, "main"))
    return _table(None, PROGRAMS[program])


def _render_tool(module: ModuleType) -> str:
    kinds = [
        kind
        for name, kind in inspect.getmembers(module, is_dataclass)
        if name.endswith("Arguments") and kind.__module__ == module.__name__
    ]
    doc = inspect.getdoc(module) or ""
    body = _table(doc, kinds[0]) if kinds else f"```text\n{doc}\n```"
    return f"## {module.__name__}\n\n{body}"


def _table(doc: str | None, kind: type) -> str:
    try:
        from asddpg.options.help_text import markdown

        from asddpg.command_line import GROUPS
    except ImportError:
        from options_of_comments import render_comments

        return render_comments(kind)
    return str(markdown(doc, kind, GROUPS if kind is config.TrainConfig else None))
