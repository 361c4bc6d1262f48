"""Programs on a system without fcntl, resource and SIGHUP, as Windows: hidden in a process of their own."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import TINY

HIDE = """
import runpy, signal, sys
for module in ("fcntl", "resource"):
    sys.modules[module] = None
del signal.SIGHUP
sys.argv = sys.argv[1:]
runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
"""
DRIVEN = ["episodes=1", "task=nav_empty"]


@pytest.mark.slow
def test_training_and_what_follows(tmp_path: Path) -> None:
    def run(*arguments: str) -> str:
        command = [sys.executable, "-c", HIDE, *arguments]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    printed = run("asddpg.train", "task=nav_empty", *TINY, "total_steps=200", "run_dir=run")
    assert "steps/s\n" in printed
    assert "success rate" in run("asddpg.evaluate", "run=run", *DRIVEN)
    run("asddpg.play", "run=run", *DRIVEN)
    assert len([*tmp_path.glob("run/played_episodes/*.mcap")]) == 1
    compared = run("tools.compare", "drivers=[run,controller]", "tasks=[nav_empty]", "episodes=1", "processes=1")
    assert "| controller | nav_empty | 1 |" in compared
