"""ARCHITECTURE.md's table of who may import whom, held against the code."""

import ast
from pathlib import Path

import pytest

from tests.conftest import ROOT

CORE = (
    "types",
    "errors",
    "config",
    "controllers",
    "exploration",
    "replay",
    "networks",
    "losses",
    "flat",
    "assistance",
    "agent",
    "drivers",
    "streams",
)
ROOTS = ("train", "evaluate", "compose", "build", "program", "checkpoint", "run_folder")

# Files of a part → what none of them may import.
FORBIDDEN = {
    "tasks": (["tasks/**/*.py"], {"asddpg", "torch", "hydra", "omegaconf", "mcap", "tools", "tests"}),
    "gymnasium in its adapter alone": (["tasks/[!_g]*.py"], {"gymnasium"}),
    "agent core": (
        [f"asddpg/{name}.py" for name in CORE],
        {"tasks", "mujoco", "dm_control", "hydra", "omegaconf", "mcap", "gymnasium", "tools", "tests"},
    ),
    "loop and evaluation": (
        ["asddpg/loop.py", "asddpg/evaluation.py", "asddpg/intervals.py"],
        {"torch", "tasks", "mujoco", "dm_control", "hydra", "omegaconf", "tools", "tests"},
    ),
    "observers": (["asddpg/observers/*.py"], {"torch", "hydra", "omegaconf", "mujoco", "tools", "tests"}),
    "roots": ([f"asddpg/{name}.py" for name in ROOTS], {"tools", "tests"}),
    "tools": (["tools/*.py"], {"tests"}),
}


def imported(path: Path) -> set[str]:
    """Top-level packages a file imports, anywhere in it."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module.partition(".")[0])
    return names


@pytest.mark.parametrize("part", FORBIDDEN)
def test_nobody_imports_what_his_room_may_not(part: str) -> None:
    patterns, forbidden = FORBIDDEN[part]
    files = [path for pattern in patterns for path in ROOT.glob(pattern)]
    assert len(files) >= len(patterns)
    for path in files:
        assert not imported(path) & forbidden, path.relative_to(ROOT)


def test_every_file_of_the_package_has_a_room() -> None:
    covered = {path for patterns, _ in FORBIDDEN.values() for pattern in patterns for path in ROOT.glob(pattern)}
    files = {path for path in (ROOT / "asddpg").rglob("*.py") if path.name != "__init__.py"}
    assert files <= covered


def test_no_module_is_called_after_nothing() -> None:
    for package in ("asddpg", "tasks", "tools"):
        assert not [path for path in (ROOT / package).rglob("*.py") if path.stem in {"utils", "common", "helpers"}]


def test_models_are_data() -> None:
    assert not list((ROOT / "models").rglob("*.py"))
