"""How Sphinx builds the site from docs/: `make docs`. Warnings are errors there."""

import logging
import re
import sys
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
import asddpg  # noqa: E402

logging.getLogger("absl").setLevel("WARNING")  # MuJoCo's greeting

project = "asddpg"
release = version = asddpg.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["runs"]

html_theme = "furo"
html_title = f"asddpg {release}"
html_theme_options = {"top_of_page_buttons": []}
html_copy_source = False

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # an included README begins with a heading of its own

autodoc_default_options = {"members": True, "member-order": "bysource", "show-inheritance": False}
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
default_role = "code"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

_CODE = re.compile(r"(`[^`]+`)")
_MARKUP = re.compile(r"([*|_\\])")  # in plain text no markup


def _escape(line: str) -> str:
    """A docstring's line, plain text with code in single backticks, as reStructuredText."""
    parts = _CODE.split(line)
    return "".join(f"`{part}`" if part.startswith("`") else _MARKUP.sub(r"\\\1", part) for part in parts)


def _escape_docstring(
    _app: Sphinx, _what: str, _name: str, _object: object, _options: object, lines: list[str]
) -> None:
    lines[:] = [_escape(line) for line in lines]


class OptionsDirective(SphinxDirective):
    """The options of all programs, rendered from their declarations."""

    def run(self) -> list[nodes.Node]:
        """Parse the rendered Markdown in place."""
        from tools.options_reference import options_reference

        return self.parse_text_to_nodes(options_reference(), allow_section_headings=True)


def setup(app: Sphinx) -> None:
    """Register what this project adds to Sphinx."""
    app.add_directive("options", OptionsDirective)
    app.connect("autodoc-process-docstring", _escape_docstring, priority=100)  # before napoleon
