"""Programs find their packages whatever the user's files are called; a user's own program keeps its files."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from tests.conftest import ROOT

# Of ours, of libraries, of the standard library.
NAMES = ("tasks", "models", "tests", "torch", "numpy", "gymnasium", "hydra", "mujoco", "yaml", "random", "copy", "csv")
FORM = pytest.mark.parametrize("form", ["{}.py", "{}/__init__.py"])


def write(folder: Path, form: str, names: Sequence[str], text: str = "raise RuntimeError") -> Path:
    for name in names:
        file = folder / form.format(name)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return file


def python(folder: Path, *arguments: str, path: str = str(ROOT)) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": path}
    return subprocess.run([sys.executable, *arguments], cwd=folder, env=environment, capture_output=True, text=True)


@FORM
@pytest.mark.parametrize(("module", "also"), [("asddpg.train", "tools"), ("tools.robot_figures", "asddpg")])
def test_a_program_runs_beside_files_with_the_names_of_packages(
    tmp_path: Path, module: str, also: str, form: str
) -> None:
    write(tmp_path / "here", form, [*NAMES, also])
    write(tmp_path / "before", form, ["tasks"])
    done = python(tmp_path / "here", "-m", module, "--help", path=f"{tmp_path / 'before'}:{ROOT}")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("file", ["asddpg/reproduce.py", "tools/robot_figures.py"])
def test_a_program_runs_by_its_path(tmp_path: Path, file: str) -> None:
    write(tmp_path, "{}.py", ["tasks"])
    done = python(tmp_path, str(ROOT / file), "--help", path=f"{tmp_path}:{ROOT}")
    assert done.returncode == 0, done.stderr


def test_a_controller_in_the_present_folder_is_still_found(tmp_path: Path) -> None:
    write(tmp_path, "{}.py", ["own"], "print('found')")
    done = python(tmp_path, "-m", "asddpg.train", "controller.type=own:Factory", "task=nav_empty")
    assert "found" in done.stdout
    assert "no controller 'own:Factory'" in done.stderr


@FORM
@pytest.mark.parametrize("arguments", [["-c", "import own"], ["-m", "own.program", "-m", "asddpg.train"]])
def test_a_users_program_keeps_its_tasks_and_the_error_names_the_file(
    tmp_path: Path, form: str, arguments: list[str]
) -> None:
    write(tmp_path, "own/{}.py", ["program"])
    program = "import sys; before = list(sys.path)\ntry: import asddpg\nfinally: assert sys.path == before"
    write(tmp_path, "own/{}.py", ["__init__"], program)
    file = write(tmp_path, form, ["tasks"])
    assert python(tmp_path, *arguments).stderr.splitlines()[-1] == (
        f"ImportError: asddpg needs the package {ROOT / 'tasks'}, and `import tasks` finds {file}: "
        f"rename that, or put {ROOT} before it in PYTHONPATH"
    )
