"""Runs that nothing has stopped, made once for all tests; to be read, not written to."""

from collections.abc import Callable
from pathlib import Path

import pytest

from asddpg import train
from tests.support.small_runs import KINDS, QUICK


@pytest.fixture(scope="session")
def unbroken_kind(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """An uninterrupted run of a kind of KINDS."""
    made: dict[str, Path] = {}

    def run(kind: str) -> Path:
        if kind not in made:
            made[kind] = tmp_path_factory.mktemp("unbroken") / "run"
            train.main([*QUICK, *KINDS[kind], f"run_dir={made[kind]}"])
        return made[kind]

    return run


@pytest.fixture(scope="session")
def unbroken(unbroken_kind: Callable[[str], Path]) -> Path:
    """An uninterrupted run with the default options."""
    return unbroken_kind("default")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """The folder of a run, not made yet."""
    return tmp_path / "run"
