"""Invalid arguments give one sentence and status 2 and leave nothing behind; valid ones begin the program."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import HealthCheck, assume, given, settings

from asddpg import evaluate, play, train
from asddpg.command_line import driver_config, stored_config, train_config
from asddpg.config import EvaluateConfig, PlayConfig, TrainConfig
from asddpg.errors import UserError
from asddpg.options.parsing import parse_arguments
from asddpg.runs.run_folder import RunFolder, read_training
from tests.support.entry_point import Ended, ended
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


CONTRADICTIONS = (
    "at most agent.buffer_size",
    "needs a controller",
    "bootstraps from itself",
    "come after",
    "needs an agent.batch_size",
    "for the convolutions",
    "below max_linear_velocity",
    "below max_range",
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


def test_what_twin_critics_need_is_said() -> None:
    for option in ("agent.twin_critics=true", "agent.target_noise=0.1"):
        with pytest.raises(UserError, match="bootstraps from itself: agent.critic_follows_switch=false, the default"):
            train_config([option, "agent.critic_follows_switch=true"])


def test_a_configuration_of_before_robots_is_one_of_a_single_robot_with_an_update_after_each_step() -> None:
    values = asdict(train_config(["agent.batch_size=32"]))
    del values["robots"], values["agent"]["samples_per_step"]
    config = stored_config(values)
    assert (config.robots, config.agent.batch_size, config.agent.samples_per_step) == (1, 32, 32)


def test_a_configuration_of_before_the_saturation_loss_has_none() -> None:
    values = asdict(train_config(["agent.tau=0.02"]))
    del values["agent"]["saturation"]
    agent = stored_config(values).agent
    assert (agent.saturation, agent.tau) == (0.0, 0.02)


NAMES = (
    *("läufe", "my runs", "a(1)", "2026_11_29", "1e5", "yes", "12:30", "./a.b", "$x", "運転", "a,b", "O'Brien", "=x="),
    *("[1]", "{a: b}", "#7", "-m", "???", "a\u202fb", "null.", "~nosuch"),
)


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_may_be_called_as_one_likes(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = train_config([f"run_dir={name}"])
    assert config.run_dir == name
    RunFolder(tmp_path).write_config(config, {})
    assert read_training(tmp_path / "config.yaml")[0] == config
    assert driver_config(PlayConfig, [f"run={name}", f"video={name}"]) == PlayConfig(run=name, video=name)
    assert parse_arguments(EpisodesArguments, [f"./{name}"]).folder == Path(name)
    resumed: list[str] = []
    monkeypatch.setattr(train, "resume", lambda path, _: resumed.append(path))
    train.main([f"resume={name}"])
    train.main(["resume=~/a"])  # as run_dir=~/a makes it
    assert resumed == [name, train_config(["run_dir=~/a"]).run_dir] == [name, str(Path.home() / "a")]
