"""Recorded episodes, run again."""

import itertools
import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from mcap.records import McapRecord, Metadata

from asddpg import train
from asddpg.build import controller_for, make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver, Observation
from asddpg.errors import UserError
from asddpg.recording.files.reading import open_recording
from asddpg.recording.messages.topics import OUTCOME, STEP
from asddpg.recording.recorder import Provenance, Recorder, Selection, every_nth
from asddpg.runs.provenance import environment_hash
from asddpg.runs.run_folder import config_text
from tests.conftest import TINY
from tests.support.recordings import changed, evaluated, with_config, with_messages
from tests.support.small_runs import VARYING
from tools import replay_episode


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    (path,) = evaluated(tmp_path_factory.mktemp("evaluated"), "agent=controller", "task=nav_gazebo", "episodes=1")
    return path


@pytest.mark.parametrize("arguments", [("run=pretrained:nav_complex",), ("agent=controller", "task=nav_office")])
def test_an_evaluation_happens_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]
) -> None:
    paths = evaluated(tmp_path, *arguments, "episodes=2")
    capsys.readouterr()
    replay_episode.main([str(paths[0].parent)])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(paths) == 2
    assert all("the same to the last bit over" in line for line in lines)


def test_a_training_with_noise_and_other_constants_happens_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["task=nav_gazebo", *TINY[1:], "total_steps=150", "task.laser.noise=1", "task.control_timestep=0.1"]
    train.main([*arguments, "record.every=1", f"run_dir={tmp_path / 'run'}"])
    paths = sorted((tmp_path / "run/episodes").iterdir())
    assert paths[-1].name.endswith("_cut.mcap")  # the steps were used up
    capsys.readouterr()
    replay_episode.main([str(tmp_path / "run/episodes")])
    out = capsys.readouterr().out
    assert out.count("the same to the last bit") == len(paths)
    assert ", cut\n" in out


def test_episodes_of_other_rooms_friction_and_mass_happen_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [*TINY[1:], *VARYING, "total_steps=150", "robots=2", "record.every=1"]
    train.main([*arguments, f"run_dir={tmp_path / 'run'}"])
    paths = sorted((tmp_path / "run/episodes").iterdir())
    assert len({open_recording(path).facts["room"] for path in paths}) == len(paths) > 2
    capsys.readouterr()
    replay_episode.main([str(tmp_path / "run/episodes")])
    assert capsys.readouterr().out.count("the same to the last bit") == len(paths)


def test_an_episode_whose_goal_was_moved_happens_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    config = train_config(["task=nav_empty"])
    environment = make_environment(config.task, config.reward)
    inner = navigation_env(environment)
    settings = config_text(config, {})
    facts = {"task": "nav_empty", "model_hash": environment_hash(environment)}
    recorder = Recorder(tmp_path, inner, Provenance(settings, facts), Selection(every_nth(1)), print)
    controller = controller_for(environment, config.controller)
    count = itertools.count()

    def decide(observation: Observation) -> Decision:
        if next(count) == 7:
            observation = inner.set_goal(-2.0, -1.0)
        return Decision(controller.act(observation), Driver.CONTROLLER)

    run_episode(environment, FixedDriver(decide), (recorder,), options={"start": (0, 0, 0), "goal": (1.5, 0.2)})
    replay_episode.main([str(tmp_path)])
    assert "the same to the last bit" in capsys.readouterr().out
    assert open_recording(next(tmp_path.iterdir())).outcome()["outcome"] == "reached"


def slower_in_step_7(data: bytes) -> bytes:
    step = json.loads(data)
    step["action"]["v"] = 0.25 if step["step"] == 7 else step["action"]["v"]
    return json.dumps(step).encode()


@pytest.mark.parametrize(
    ("change", "difference"),
    [
        (with_messages(STEP, slower_in_step_7), "the first to differ is step 7"),
        (with_messages(OUTCOME, lambda _: b'{"outcome": "timeout"}'), "in the end, timeout in the recording"),
    ],
)
def test_the_first_difference_is_printed(
    tmp_path: Path, recording: Path, capsys: pytest.CaptureFixture[str], change: Any, difference: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        replay_episode.main([str(changed(recording, tmp_path / "changed.mcap", change))])
    assert ended.value.code == 1
    assert difference in capsys.readouterr().out


def other_scene(records: list[McapRecord]) -> None:
    (metadata,) = (each for each in records if isinstance(each, Metadata))
    metadata.metadata["model_hash"] = "0" * 16


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (other_scene, "has changed since"),
        (with_config(lambda text: text.replace("nav_gazebo", "nav_cellar")), "names no task of this version: 'nav_cel"),
        (with_config(lambda text: text.replace("goal_radius", "goal_size")), "not a configuration of this version"),
        (with_messages(STEP, lambda data: data.replace(b'"digest"', b'"other"')), "no digest"),
    ],
)
def test_a_recording_of_another_version_is_refused_in_a_sentence(
    tmp_path: Path, recording: Path, change: Any, sentence: str
) -> None:
    path = changed(recording, tmp_path / "other.mcap", change)
    with pytest.raises(UserError, match=sentence):
        replay_episode.main([str(path)])


def test_one_damaged_file_does_not_stop_the_others(
    tmp_path: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.mcap").write_bytes(recording.read_bytes()[:5000])
    with pytest.raises(SystemExit) as ended:
        replay_episode.main([str(tmp_path), str(recording)])
    assert ended.value.code == 2
    said = capsys.readouterr()
    assert "is damaged or not a recording" in said.err
    assert "the same to the last bit" in said.out


def test_invalid_arguments(tmp_path: Path, recording: Path) -> None:
    below = tmp_path / "some" / "where"
    below.mkdir(parents=True)
    shutil.copy(recording, below)
    for arguments, sentence in (
        ([], "RECORDINGS… is missing"),
        (["nowhere.mcap"], "there is no file or folder nowhere.mcap"),
        ([str(tmp_path)], "there are no recordings"),
        ([str(tmp_path)], f"there are some in {below}"),
    ):
        with pytest.raises(UserError, match=sentence):
            replay_episode.main(arguments)
