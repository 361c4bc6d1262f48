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
    "layers",
    "losses",
    "flat",
    "assistance",
    "agent",
    "n_step",
    "withdrawal",
    "annealing",
    "drivers",
    "steering",
    "streams",
)
LOOP = ("loop", "tally", "evaluation", "intervals", "history", "stopping")
ROOTS = (
    "train",
    "evaluate",
    "play",
    "driving",
    "compose",
    "option_kinds",
    "build",
    "memory",
    "program",
    "checkpoint",
    "run_folder",
    "policy_file",
    "pretrained",
    "trained",
    "training",
    "training_states",
    "state_files",
    "growing_files",
    "taking_back",
    "run_lock",
    "resumable",
    "breakdown",
    "reproduce",
    "whole_files",
    "strangers",
)

# Files of a part → what none of them may import.
FORBIDDEN = {
    "tasks": (["tasks/**/*.py"], {"asddpg", "torch", "hydra", "omegaconf", "mcap", "tools", "tests"}),
    "gymnasium in its adapter alone": (
        [f"tasks/{path.name}" for path in (ROOT / "tasks").glob("[!_]*.py") if path.stem != "gymnasium_adapter"],
        {"gymnasium"},
    ),
    "agent core": (
        [f"asddpg/{name}.py" for name in CORE],
        {"tasks", "mujoco", "dm_control", "hydra", "omegaconf", "mcap", "gymnasium", "tools", "tests"},
    ),
    "loop and evaluation": (
        [f"asddpg/{name}.py" for name in LOOP],
        {"torch", "tasks", "mujoco", "dm_control", "hydra", "omegaconf", "tools", "tests"},
    ),
    "observers": (["asddpg/observers/*.py"], {"torch", "hydra", "omegaconf", "mujoco", "tools", "tests"}),
    "recording": (
        ["asddpg/recording/*.py"],
        {"torch", "hydra", "omegaconf", "mujoco", "dm_control", "gymnasium", "tools", "tests"},
    ),
    "foxglove and mcap in the recording alone": (
        [f"asddpg/{name}.py" for name in (*CORE, *LOOP, *ROOTS)],
        {"foxglove", "mcap", "mcap_protobuf"},
    ),
    "safetensors in two files alone": (
        [f"asddpg/{name}.py" for name in (*CORE, *LOOP, *ROOTS) if name not in ("policy_file", "state_files")],
        {"safetensors"},
    ),
    "roots": ([f"asddpg/{name}.py" for name in ROOTS], {"tools", "tests"}),
    "tools": (["tools/*.py"], {"tests"}),
}


def imported(path: Path) -> set[str]:
    """What a file imports, anywhere in it: top-level packages, and modules of ours as asddpg.<name>."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"relative import in {path}"
            modules = [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
        else:
            continue
        names |= {".".join(module.split(".")[:depth]) for module in modules for depth in (1, 2)}
    return names


def test_the_table_in_architecture_md_names_the_same_files() -> None:
    rows = [line for line in (ROOT / "ARCHITECTURE.md").read_text().splitlines() if line.startswith("| ")]
    for title, names in (("agent core", CORE), ("loop, evaluation", LOOP), ("composition roots", ROOTS)):
        (row,) = (line for line in rows if line.startswith(f"| {title} |"))
        files = row.split("|")[2].replace("`asddpg/`", "").replace(",", " ").split()
        assert sorted(files) == sorted(names)


@pytest.mark.parametrize("name", [*CORE, *LOOP])
def test_parts_do_not_import_the_roots(name: str) -> None:
    assert not imported(ROOT / f"asddpg/{name}.py") & {f"asddpg.{root}" for root in ROOTS}


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
