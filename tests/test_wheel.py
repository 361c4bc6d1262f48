"""The wheel carries all it needs: installed into an empty environment, run from an empty folder, it trains."""

import os
import re
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

from asddpg.runs.pretrained import names
from tests.conftest import ROOT
from tests.test_imports import MODULES, PACKAGES, imported


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run([sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)], folder)
    (path,) = folder.glob("asddpg-*.whl")
    return path


def run(arguments: list[str], folder: Path) -> str:
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(arguments, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_models_and_configuration_travel(wheel: Path) -> None:
    members = set(zipfile.ZipFile(wheel).namelist())
    wanted = {
        path.relative_to(ROOT).as_posix().replace("models/", "tasks/models/", 1)
        for pattern in (
            "models/mjcf/**/*.xml",
            "models/pretrained/**/*.*",
            "asddpg/conf/**/*.yaml",
            "tasks/held_out/*.json",
            "*/py.typed",
        )
        for path in ROOT.glob(pattern)
    }
    assert len(wanted) > 15
    assert wanted <= members
    assert {name.split("/")[0] for name in members} == {"asddpg", "tasks", "tools", f"{wheel.stem[:12]}.dist-info"}


def test_every_library_that_is_imported_is_a_dependency_or_in_an_extra() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    named = {*project["dependencies"], *(name for extra in extras.keys() - {"dev", "docs"} for name in extras[extra])}
    declared = {re.split("[<>=]", name)[0].replace("-", "_") for name in named}
    of_module = {"PIL": "pillow", "skimage": "scikit_image", "google": "protobuf", "yaml": "pyyaml"}
    of_module |= {"foxglove": "foxglove_sdk", "mcap_protobuf": "mcap_protobuf_support", "OpenGL": "pyopengl"}
    tops = {name.split(".")[0] for path in MODULES.values() for name in imported(path)}
    tops -= {*PACKAGES, *sys.stdlib_module_names}
    assert {of_module.get(name, name) for name in tops} <= declared


@pytest.mark.parametrize("file", ["README.md", "docs/getting_started.md", "Makefile"])
def test_the_documents_name_the_pythons_that_pip_accepts(file: str) -> None:
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["requires-python"] == ">=3.11,<3.13"
    assert "Python 3.11 or 3.12" in (ROOT / file).read_text()


@pytest.mark.slow
def test_an_installed_wheel_trains_in_an_empty_folder(wheel: Path, tmp_path: Path) -> None:
    environment, folder = tmp_path / "environment", tmp_path / "empty"
    folder.mkdir()
    venv.create(environment, with_pip=True)
    python = str(environment / "bin" / "python")
    run([python, "-m", "pip", "install", "--quiet", "-c", str(ROOT / "constraints.txt"), str(wheel)], folder)
    where = run([python, "-c", "import asddpg, tasks; print(asddpg.__file__, tasks.__file__)"], folder)
    assert all(path.startswith(str(environment)) for path in where.split())
    listed = run([python, "-c", "from asddpg.runs.pretrained import names; print(*names())"], folder)
    assert listed.split() == names()
    arguments = ["task=nav_complex", "total_steps=300", "agent.learning_starts=100", "test_episodes=2", "run_dir=here"]
    printed = run([str(environment / "bin" / "asddpg"), "train", *arguments], folder)
    assert "the run is in here" in printed
    assert (folder / "here/test.json").is_file()
    assert [path.name for path in folder.iterdir()] == ["here"]
