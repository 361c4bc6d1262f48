"""ARCHITECTURE.md's table of rooms, held against the imports of the code."""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.conftest import ROOT

PACKAGES = ("asddpg", "tasks", "tools")
MOST_MODULES = {"asddpg": 15, "tools": 23, "tasks": 12}  # directly in a package, __init__.py among them


def modules() -> dict[str, Path]:
    """Every module of the packages, by its dotted name."""
    paths = (path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
    return {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in paths}


MODULES = modules()


@cache
def imported(path: Path) -> frozenset[str]:
    """Modules that a file imports, anywhere in it; for `from package import name` the module it really is."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"relative import in {path}"
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in MODULES else str(node.module) for name in names}
    return frozenset(found)


def rooms() -> Iterator[tuple[Path, set[str], set[str]]]:
    """Rows of the table: a folder, what it may import of ours, and which libraries."""
    for line in (ROOT / "ARCHITECTURE.md").read_text().splitlines():
        if line.startswith("| `") and line.count("|") == 5:
            room, _, ours, libraries = (cell.strip() for cell in line.strip("|").split("|"))
            split = [set(cell.replace("–", "").replace(",", " ").split()) for cell in (ours, libraries)]
            yield ROOT / room.strip("`"), split[0], split[1]


ROOMS = list(rooms())


def in_room(folder: Path) -> list[Path]:
    return [path for path in folder.glob("*.py") if path.name != "__init__.py"]


def is_in(module: str, allowed: set[str]) -> bool:
    return any(module == name or module.startswith(f"{name}.") for name in allowed)


@pytest.mark.parametrize(("folder", "ours", "libraries"), ROOMS, ids=[str(room[0].relative_to(ROOT)) for room in ROOMS])
def test_a_room_imports_what_its_row_says(folder: Path, ours: set[str], libraries: set[str]) -> None:
    own = ".".join(folder.relative_to(ROOT).parts)
    for path in in_room(folder):
        for module in imported(path):
            top = module.split(".")[0]
            is_own = module.rpartition(".")[0] == own or module == own
            is_right = top in libraries or top in sys.stdlib_module_names or is_own or is_in(module, ours)
            assert is_right, f"{path.relative_to(ROOT)} imports {module}, which the row of its room does not allow"


def test_every_folder_has_a_row() -> None:
    folders = {path.parent for path in MODULES.values() if in_room(path.parent)}
    assert folders == {folder for folder, _, _ in ROOMS}


def test_no_import_goes_round_in_a_circle() -> None:
    graph = {name: imported(path) & MODULES.keys() - {name} for name, path in MODULES.items()}
    tuple(TopologicalSorter(graph).static_order())  # raises CycleError, with the circle


def test_programs_are_imported_by_no_module() -> None:
    programs = {name for name, path in MODULES.items() if 'if __name__ == "__main__"' in path.read_text()}
    assert len(programs) > 15
    for name, path in MODULES.items():
        assert not imported(path) & programs, f"{name} imports a program"


def test_tests_are_imported_by_no_module() -> None:
    assert not [name for name, path in MODULES.items() if is_in("tests", set(imported(path)))]


@pytest.mark.parametrize("package", PACKAGES)
def test_few_modules_stand_at_the_top(package: str) -> None:
    assert len(list((ROOT / package).glob("*.py"))) <= MOST_MODULES[package]


def test_no_module_has_a_name_that_says_nothing_or_shadows_the_standard_library() -> None:
    for name in MODULES:
        assert name.rpartition(".")[2] not in {"utils", "common", "helpers", *sys.stdlib_module_names}, name


def test_models_are_data() -> None:
    assert not list((ROOT / "models").rglob("*.py"))
