"""Two at once in one folder: both complete with all they have made, or the second ends in one sentence."""

import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from asddpg.atomic_write import claim_folder
from asddpg.command_line import train_config
from asddpg.config import EvaluateConfig
from asddpg.drivers import driver_setup
from asddpg.errors import UserError
from asddpg.recording.files.reading import open_recording
from asddpg.recording.pictures.film import Film
from asddpg.runs import weights_file
from asddpg.runs.lock import RunLock
from asddpg.runs.run_folder import create_run, write_json
from asddpg.runs.state_files import file_digest
from tests.asddpg.recording.test_recording import environment_of
from tests.conftest import ROOT
from tools import diagnose

BASELINE = ["agent=controller", "task=nav_empty", "episodes=3", "record.every=1"]


def at_once(act: Callable[[int], object]) -> list[BaseException]:
    """Act in eight threads that begin together; what they raise."""
    begin, raised = threading.Barrier(8), list[BaseException]()

    def run(number: int) -> None:
        begin.wait()
        try:
            act(number)
        except BaseException as error:
            raised.append(error)

    threads = [threading.Thread(target=run, args=(number,)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return raised


@pytest.fixture
def run(tiny_run: Path, tmp_path: Path) -> Path:
    """A copy that may be written to."""
    return Path(shutil.copytree(tiny_run, tmp_path / "run"))


@pytest.mark.parametrize(
    ("program", "arguments", "folder"),
    [
        ("evaluate", BASELINE, "evaluated_episodes"),
        ("evaluate", ["run=run", *BASELINE[2:]], "run/evaluated_episodes"),
        ("play", [*BASELINE, "seed=3"], "played_episodes"),
    ],
)
@pytest.mark.usefixtures("run")
def test_two_programs_lose_neither_recordings_nor_results(
    tmp_path: Path, program: str, arguments: list[str], folder: str
) -> None:
    command = [sys.executable, "-m", f"asddpg.{program}", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    drives = [
        subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)
    ]
    outputs = "".join(drive.communicate(timeout=120)[0] for drive in drives)
    assert [drive.returncode for drive in drives] == [0, 0]
    names = {Path(folder).name, f"{Path(folder).name}_2"}
    for name in names:
        assert f"3 episodes recorded in {Path(folder).with_name(name)};" in outputs
        assert all(open_recording(path).steps() for path in (tmp_path / folder).with_name(name).iterdir())
    if program == "evaluate":
        results = [json.loads(path.read_text()) for path in (tmp_path / folder).parent.glob("evaluation*.json")]
        assert {each["recordings"] for each in results} == names


def test_each_gets_a_folder_of_its_own(tmp_path: Path) -> None:
    claimed: list[Path] = []
    assert not at_once(lambda _: claimed.append(claim_folder(tmp_path / "new" / "folder")))
    assert len(set(claimed)) == 8
    assert set(claimed) == set((tmp_path / "new").iterdir())


def test_a_result_that_cannot_be_written_leaves_the_last_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "evaluation.json"
    write_json(path, {"number": 1}, keeps_old=True)
    monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "no space")))
    with pytest.raises(OSError, match="no space"):
        write_json(path, {"number": 2}, keeps_old=True)
    assert {each.name: json.loads(each.read_text()) for each in tmp_path.iterdir()} == {path.name: {"number": 1}}


def test_results_are_whole_and_none_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "evaluation.json"
    assert not at_once(lambda number: write_json(path, {"number": number, "long": "x" * 10**6}, keeps_old=True))
    last = path.read_bytes()
    write_json(path, json.loads(last), keeps_old=True)  # the same once more
    kept = [json.loads(each.read_text())["number"] for each in tmp_path.iterdir()]
    assert sorted(kept) == [*range(8)]
    assert path.read_bytes() == last


def test_trainings_of_one_second_have_folders_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    config = train_config([])
    assert not at_once(lambda _: create_run(config))
    assert len(list((tmp_path / "runs").glob("*/checkpoints"))) == 8
    config.run_dir = "mine"
    refused = at_once(lambda _: create_run(config))
    assert [str(error) for error in refused] == ["another training has begun in mine; choose another run_dir="] * 7


def test_a_film_is_written_by_one(tmp_path: Path) -> None:
    pytest.importorskip("av")
    environment = environment_of().unwrapped
    first = Film(tmp_path / "film.mp4", environment, width=64, height=48)  # type: ignore[arg-type]
    with pytest.raises(UserError, match=r"another process is writing the film .*; choose another video="):
        Film(tmp_path / "film.mp4", environment, width=64, height=48)  # type: ignore[arg-type]
    first.close()
    Film(tmp_path / "film.mp4", environment, width=64, height=48).close()  # type: ignore[arg-type]
    assert not list(tmp_path.glob("*.part"))


def test_a_run_is_diagnosed_by_one(run: Path) -> None:
    (run / "diagnosis").mkdir()
    with RunLock(run / "diagnosis"), pytest.raises(UserError, match="diagnosis is being written by process"):
        diagnose.main([f"run={run}", "episodes=1"])


def test_recordings_name_the_weights_that_drove_though_a_training_replaced_them(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    load_into, weights = weights_file.load_into, run / "checkpoints/last.safetensors"
    newer = min(run.glob("checkpoints/step_*"))

    def replaced(path: Path, *arguments: object) -> int:
        step = load_into(path, *arguments)  # type: ignore[arg-type]
        shutil.copy(newer, weights)
        return step

    monkeypatch.setattr(weights_file, "load_into", replaced)
    setup = driver_setup.set_up_driver(EvaluateConfig(run=str(run)), "evaluate", 0)
    assert (setup.step, setup.checkpoint["weights_sha256"]) == (int(newer.stem[5:]), file_digest(newer)[:16])
