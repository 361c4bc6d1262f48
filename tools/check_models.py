"""Check the format of everything under models/mjcf: `python -m tools.check_models`."""

import re
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from asddpg.options.help_text import help_text
from asddpg.options.parsing import NoArguments, parse_arguments
from asddpg.program import run
from tasks.graphics.headless import mujoco
from tasks.scene.loading import MODELS

MAX_COLUMNS = 120
INDENT = 2
SCENES = ("nav_*.xml", "scene.xml")
NAMED = ("body", "geom", "joint", "site", "sensor", "camera", "light", "actuator")

_PICTURE = re.compile(r"!\[[^\]]*\]\(([^)\s]+)\)")
_SOURCE_COLUMN = re.compile(r"^.*\|\s*source\s*\|.*\n\s*\|[ :|-]+\|\s*$", re.MULTILINE)
_KNOWN_DIFFERENCES = re.compile(r"^(#+ |\*\*)Known differences", re.MULTILINE)


class Fault(NamedTuple):
    """A fault in a sentence, and its file and line."""

    path: Path
    line: int
    sentence: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.sentence}"


def find_faults(root: Path) -> list[Fault]:
    """All faults of the models under `root`, and of the README that each folder but that of the scenes must have."""
    found: list[Fault] = []
    for path in sorted(root.rglob("*.xml")):
        found += xml_faults(path)
    for scene in sorted(path for pattern in SCENES for path in root.rglob(pattern)):
        found += scene_faults(scene)
    for folder in sorted({path.parent for path in root.rglob("*.xml")} - {root}):
        found += folder_faults(folder)
    return found


def xml_faults(path: Path) -> list[Fault]:
    """Faults in a file's syntax and layout."""
    text = path.read_text(encoding="utf-8")
    try:
        ET.fromstring(text)
    except ET.ParseError as error:
        return [Fault(path, error.position[0], f"this is not XML: {error}")]
    found = [
        Fault(path, number, sentence)
        for number, line in enumerate(text.split("\n"), start=1)
        for sentence in _line_faults(line)
    ]
    if not text.endswith("\n"):
        found.append(Fault(path, text.count("\n") + 1, "the file must end in a newline"))
    return sorted(found + _indent_faults(path, text), key=lambda fault: fault.line)


def _line_faults(line: str) -> Iterator[str]:
    if len(line) > MAX_COLUMNS:
        yield f"the line has {len(line)} columns; {MAX_COLUMNS} are allowed"
    if "\t" in line:
        yield "the line has a tab; indent by spaces"
    if line != line.rstrip():
        yield "the line has trailing blanks"


def _indent_faults(path: Path, text: str) -> list[Fault]:
    """A line that begins with a tag stands two spaces deeper than its parent's."""
    found: list[Fault] = []
    depth = 0
    blanked = re.sub(r"<!--.*?-->", lambda comment: re.sub(r"[^\n]", " ", comment.group()), text, flags=re.DOTALL)
    for number, line in enumerate(blanked.split("\n"), start=1):
        tags = re.findall(r"</|/>|<(?=\w)", line)
        if line.lstrip().startswith("<"):
            expected = INDENT * (depth - line.lstrip().startswith("</"))
            indent = len(line) - len(line.lstrip())
            if indent != expected:
                found.append(Fault(path, number, f"the tag stands in column {indent}; its depth requires {expected}"))
        depth += sum(1 if tag == "<" else -1 for tag in tags)
    return found


def scene_faults(path: Path) -> list[Fault]:
    """Faults of a scene that does not compile or has nameless elements."""
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        return [Fault(path, 1, f"MuJoCo does not compile the scene: {' '.join(str(error).split())}")]
    return [
        Fault(path, 1, f"{kind} number {index} of the compiled scene has no name")
        for kind in NAMED
        for index in _nameless(model, kind)
    ]


def _nameless(model: mujoco.MjModel, kind: str) -> list[int]:
    count = getattr(model, {"joint": "njnt", "camera": "ncam", "actuator": "nu"}.get(kind, f"n{kind}"))
    return [index for index in range(count) if not getattr(model, kind)(index).name]


def folder_faults(folder: Path) -> list[Fault]:
    """Faults of a folder's README: missing, or without picture, sources, differences or a file's name."""
    readme = folder / "README.md"
    if not readme.is_file():
        return [Fault(readme, 1, "a folder with XML files needs a README.md")]
    text = readme.read_text(encoding="utf-8")
    found = list(_picture_faults(readme, text))
    if not _SOURCE_COLUMN.search(text):
        found.append(Fault(readme, 1, "there is no table with a column `source`"))
    if not _KNOWN_DIFFERENCES.search(text):
        found.append(Fault(readme, 1, "there is no section or bold lead 'Known differences'"))
    for path in sorted(folder.glob("*.xml")):
        if not re.search(rf"`{re.escape(path.stem)}(\.xml)?`", text):
            found.append(Fault(readme, 1, f"`{path.name}` is not named"))
    return found


def _picture_faults(readme: Path, text: str) -> Iterator[Fault]:
    if not _PICTURE.search(text):
        yield Fault(readme, 1, "there is no picture")
    for number, line in enumerate(text.splitlines(), start=1):
        for target in _PICTURE.findall(line):
            if "://" not in target and not (readme.parent / target).is_file():
                yield Fault(readme, number, f"the picture {target} does not exist")


def main(arguments: Sequence[str]) -> None:
    """Print every fault and exit with status 1, or print that there is none."""
    parse_arguments(NoArguments, arguments)
    found = find_faults(MODELS)
    for fault in found:
        print(fault._replace(path=_short(fault.path)))
    if found:
        sys.exit(1)
    print(f"{len(list(MODELS.rglob('*.xml')))} model files are well formed")


def _short(path: Path) -> Path:
    return path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path


if __name__ == "__main__":
    run(main, help_text(__doc__, NoArguments))
