"""The command `asddpg`: every program by its name, and a sentence for a wrong one."""

import subprocess
import sys
from pathlib import Path

import pytest

from asddpg import __version__
from asddpg.__main__ import PROGRAMS
from tools.options_reference import PROGRAMS as ALL_PROGRAMS

# Of the project's own making: no user needs them.
INTERNAL = {"tools.check_models", "tools.draw_held_out", "tools.options_reference", "tools.benchmarks.compare_peers"}
SCRIPT = "from asddpg.__main__ import main; main()"  # as pip writes it
OWN = """
class Spin:
    name = "spin"
    def __init__(self, gains, low, high): self._high = high
    def act(self, observation): return self._high
"""


def asddpg(folder: Path, *arguments: str, command: tuple[str, ...] = ("-m", "asddpg")) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, *command, *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout, done.stderr


def test_every_program_is_listed() -> None:
    assert set(PROGRAMS) == set(ALL_PROGRAMS) - INTERNAL


@pytest.mark.parametrize("arguments", [[], ["help"], ["--help"]])
def test_the_list(arguments: list[str], tmp_path: Path) -> None:
    status, out, _ = asddpg(tmp_path, *arguments)
    assert status == 0
    assert all(f"  {program.rpartition('.')[2]} " in out for program in PROGRAMS)


def test_version_and_wrong_names(tmp_path: Path) -> None:
    assert asddpg(tmp_path, "--version") == (0, f"asddpg {__version__}\n", "")
    assert asddpg(tmp_path, "trian") == (2, "", "error: there is no program 'trian'; did you mean train?\n")
    status, out, error = asddpg(tmp_path, "fly", "task=nav_empty")
    assert (status, out) == (2, "")
    assert error.startswith("error: there is no program 'fly'; there are train, evaluate, play")


def test_a_program_is_that_of_python_m(tmp_path: Path) -> None:
    by_module = asddpg(tmp_path, "--help", command=("-m", "asddpg.train"))
    assert asddpg(tmp_path, "train", "--help") == by_module
    assert by_module[0] == 0
    status, _, error = asddpg(tmp_path, "evaluate", "run=nowhere")
    assert (status, error) == (2, "error: nowhere is not the folder of a run: it has no config.yaml\n")


def test_the_command_finds_ones_own_code_in_the_present_folder(tmp_path: Path) -> None:
    here = tmp_path / "here"
    here.mkdir()
    (here / "own.py").write_text(OWN)
    (tmp_path / "asddpg_command").write_text(SCRIPT)
    arguments = ["evaluate", "agent=controller", "controller.type=own:Spin", "task=nav_empty", "episodes=1"]
    status, out, error = asddpg(here, *arguments, command=(str(tmp_path / "asddpg_command"),))
    assert status == 0, error
    assert "1 stored test pairs" in out
