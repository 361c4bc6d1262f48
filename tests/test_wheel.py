"""The wheel carries all it needs: installed into an empty environment, run from an empty folder, it trains."""

import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from asddpg.runs.pretrained import names
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run([sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)], folder)
    (path,) = folder.glob("asddpg-*.whl")
    return path


def run(arguments: list[str], folder: Path) -> str:
    done = subprocess.run(arguments, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_models_and_configuration_travel(wheel: Path) -> None:
    members = set(zipfile.ZipFile(wheel).namelist())
    wanted = {
        path.relative_to(ROOT).as_posix()
        for pattern in (
            "models/mjcf/**/*.xml",
            "models/pretrained/**/*.*",
            "asddpg/conf/**/*.yaml",
            "tasks/held_out/*.json",
        )
        for path in ROOT.glob(pattern)
    }
    assert len(wanted) > 15
    assert wanted <= members
    assert not [name for name in members if name.startswith("tests/")]


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
    printed = run([python, "-m", "asddpg.train", *arguments], folder)
    assert "the run is in here" in printed
    assert (folder / "here/test.json").is_file()
    assert [path.name for path in folder.iterdir()] == ["here"]
