"""Invalid arguments give one sentence and status 2 and leave nothing behind; valid ones begin the program."""

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import HealthCheck, assume, given, settings

from asddpg import evaluate, play, train
from asddpg.command_line import driver_config, train_config
from asddpg.config import EvaluateConfig, PlayConfig, TrainConfig
from asddpg.errors import UserError
from asddpg.options.parsing import parse_arguments
from asddpg.runs.run_folder import RunFolder, read_training
from tests.support.entry_point import Ended, arranged, ended, made_in
from tests.support.invalid_arguments import invalid_arguments
from tests.support.valid_arguments import valid_arguments
from tools.episodes import EpisodesArguments

SLOW = (HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.function_scoped_fixture)


def examples(count: int, fixed: bool = True) -> settings:
    """So many; the same each time in everyday tests, where no test may fail by chance."""
    return settings(max_examples=count, deadline=None, derandomize=fixed, database=None, suppress_health_check=SLOW)


class AcceptedError(Exception):
    """Raised where a program would begin its work."""


def begin(*_: object, **__: object) -> None:
    raise AcceptedError


@pytest.fixture(autouse=True)
def _nothing_is_driven(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(train, "Training", begin)
    monkeypatch.setattr(evaluate, "evaluate", begin)
    monkeypatch.setattr(play, "_drive_episodes", begin)


def check_refused(found: Ended) -> None:
    assert found.status == 2, found
    assert found.said.startswith("error: "), found
    assert found.said.count("\n") == 1, found
    assert len(found.said) < 2000, found
    assert found.said.rstrip("\n").isprintable(), found
    assert "Traceback" not in found.said
    assert found.made == []


@pytest.mark.parametrize("share", [0.2, pytest.param(1.0, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("program", "config", "count"),
    [(train, TrainConfig, 1000), (evaluate, EvaluateConfig, 300), (play, PlayConfig, 300)],
)
def test_invalid_arguments_are_refused(program: ModuleType, config: type, count: int, share: float) -> None:
    @given(invalid_arguments(config))
    @examples(round(share * count), fixed=share < 1)
    def refuses(arguments: list[str]) -> None:
        check_refused(ended(program.main, arguments))

    refuses()


@pytest.mark.long
def test_invalid_arguments_of_a_process_are_refused(tmp_path_factory: pytest.TempPathFactory) -> None:
    @given(invalid_arguments(TrainConfig))
    @examples(20, fixed=False)
    def refuses(arguments: list[str]) -> None:
        folder = tmp_path_factory.mktemp("process")
        arranged(folder)
        assume(all(_is_encodable(argument) for argument in arguments))
        line = [sys.executable, "-m", "asddpg.train", *arguments]
        done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
        assert done.stdout == ""
        check_refused(Ended(done.returncode, done.stderr, made_in(folder)))

    refuses()


def _is_encodable(argument: str) -> bool:
    """What no shell can hand over is left out."""
    try:
        os.fsencode(argument)
    except UnicodeEncodeError:
        return False
    return True


CONTRADICTIONS = (
    "at most agent.buffer_size",
    "needs a controller",
    "bootstraps from itself",
    "come after",
    "needs an agent.batch_size",
    "for the convolutions",
    "below max_linear_velocity",
)


def contradicts_itself(arguments: Sequence[str]) -> bool:
    """Whether two arguments contradict one another; each on its own must be valid."""
    try:
        train_config(arguments)
    except UserError as error:
        if not any(each in str(error) for each in CONTRADICTIONS):
            raise
        return True
    return False


@pytest.mark.parametrize("count", [15, pytest.param(200, marks=pytest.mark.long)])
def test_valid_arguments_begin_a_training(count: int) -> None:
    @given(valid_arguments(widest=300, most_beams=300))
    @examples(count, fixed=count < 200)
    def accepts(arguments: list[str]) -> None:
        assume(not contradicts_itself(arguments))
        with pytest.raises(AcceptedError):
            ended(train.main, arguments)

    accepts()


@given(valid_arguments())
@examples(60)
def test_valid_arguments_compose(arguments: list[str]) -> None:
    contradicts_itself(arguments)  # which raises where a single argument is invalid


NAMES = (
    "läufe",
    "my runs",
    "a(1)",
    "2026_11_29",
    "1e5",
    "yes",
    "12:30",
    "./a.b",
    "$x",
    "運転",
    "a,b",
    "O'Brien",
    "=x=",
    "[1]",
    "{a: b}",
    "#7",
    "-m",
    "???",
    "a\u202fb",
    "null.",
    "~nosuch",
)


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_may_be_called_as_one_likes(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = train_config([f"run_dir={name}"])
    assert config.run_dir == name
    folder = RunFolder(tmp_path)
    folder.write_config(config, {})
    assert read_training(folder.config)[0] == config
    assert driver_config(EvaluateConfig, [f"run={name}"]).run == name
    assert driver_config(PlayConfig, [f"video={name}"]).video == name
    monkeypatch.chdir(tmp_path)
    assert parse_arguments(EpisodesArguments, [f"./{name}"]).folder == Path(name)
    monkeypatch.setattr(train, "resume", lambda path, _: Path("resumed").write_text(path))
    train.main([f"resume={name}"])
    assert Path("resumed").read_text() == name


def test_a_tilde_is_the_users_home(monkeypatch: pytest.MonkeyPatch) -> None:
    home = str(Path.home() / "runs/1")
    assert train_config(["run_dir=~/runs/1"]).run_dir == home
    monkeypatch.setattr(train, "resume", lambda path, _: begin() if path == home else None)
    with pytest.raises(AcceptedError):
        train.main(["resume=~/runs/1"])
