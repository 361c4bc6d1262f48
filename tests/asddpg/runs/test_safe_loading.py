"""An untrusted run or recording may not run code, link elsewhere, read the environment or exhaust memory."""

import os
import pickle
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import torch
import yaml
from safetensors.torch import save_file

from asddpg import evaluate, play
from asddpg.errors import UserError
from asddpg.runs.run_folder import RunFolder, read_training
from asddpg.runs.safe_loading import LARGEST_CONFIG
from asddpg.runs.weights_file import read as read_policy
from tests.support.small_runs import Harmful
from tools import diagnose, publish
from tools.diagnosis.step_metrics import NEEDED

NUM_BYTES = 2**20


HARMFUL = pickle.dumps(Harmful())
FOREIGN_CODE = """\
open("ran", "w").close()
from asddpg.algorithm.controllers import ProportionalController as Factory
"""


@pytest.fixture
def run(tiny_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RunFolder:
    """An untrusted run in the working folder, beside a foreign module; harmful code leaves the file `ran` there."""
    shutil.copytree(tiny_run, tmp_path / "run")
    (tmp_path / "foreign.py").write_text(FOREIGN_CODE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "foreign", raising=False)
    monkeypatch.chdir(tmp_path)
    return RunFolder(Path("run"))


def harm_done() -> bool:
    return Path("ran").exists()


def write_steps(run: RunFolder, array: npt.NDArray[Any]) -> None:
    """A step log that has an array in the place of each."""
    arrays: dict[str, Any] = dict.fromkeys(NEEDED, array)
    np.savez_compressed(run.steps, **arrays)


def changed(run: RunFolder, change: Callable[[dict[str, Any]], None]) -> None:
    """Another configuration."""
    values = yaml.safe_load(run.config.read_text())
    change(values)
    run.config.write_text(yaml.safe_dump(values))


PROGRAMS = [
    (evaluate.main, ["run=run", "episodes=1"]),
    (play.main, ["run=run", "episodes=1"]),
    (diagnose.main, ["run=run", "episodes=1"]),
]
programs = pytest.mark.parametrize(("main", "arguments"), PROGRAMS, ids=["evaluate", "play", "diagnose"])
Main = Callable[[list[str]], None]


# Code ---------------------------------------------------------------------------------------------------------------


@programs
def test_a_pickle_in_the_weights_place_is_not_run(run: RunFolder, main: Main, arguments: list[str]) -> None:
    writes = (lambda path: torch.save({"networks": Harmful()}, path), lambda path: path.write_bytes(HARMFUL))
    for write in writes:
        for path in (run.checkpoint("last"), *run.snapshots()):
            write(path)
        with pytest.raises(UserError, match="damaged or not a file of weights"):
            main(arguments)
    assert not harm_done()


def test_a_pickle_in_the_step_log_is_not_run(run: RunFolder) -> None:
    objects = np.array([Harmful()], dtype=object)
    for write in (lambda: write_steps(run, objects), lambda: run.steps.write_bytes(HARMFUL)):
        write()
        with pytest.raises(UserError, match=r"steps.npz is damaged or not written by asddpg.train"):
            diagnose.main(["run=run", "episodes=1"])
    assert not harm_done()


@programs
@pytest.mark.parametrize(
    "line",
    [
        "seed: !!python/object/apply:builtins.exec [\"open('ran', 'w')\"]",
        "seed: !!python/object/new:tests.support.small_runs.Harmful []",
        "seed: !!python/module:foreign",
        "seed: !!python/name:foreign.Factory",
    ],
)
def test_objects_of_python_in_yaml_are_not_made(run: RunFolder, main: Main, arguments: list[str], line: str) -> None:
    run.config.write_text(f"{run.config.read_text()}\n{line}\n")
    with pytest.raises(UserError, match=r"config.yaml is damaged or not written by asddpg.train"):
        main(arguments)
    assert not harm_done()


@programs
def test_a_foreign_controller_runs_only_where_the_user_names_it(
    run: RunFolder, main: Main, arguments: list[str]
) -> None:
    changed(run, lambda values: values["controller"].update(type="foreign:Factory"))
    with pytest.raises(UserError, match="controller.type=foreign:Factory"):
        main(arguments)
    with pytest.raises(UserError, match="controller.type=foreign:Factory"):
        main([*arguments, "controller.type=foreign:Other"])
    assert not harm_done()
    main([*arguments, "controller.type=foreign:Factory"])
    assert harm_done()


@pytest.mark.usefixtures("run")
def test_naming_a_controller_gives_no_run_another() -> None:
    with pytest.raises(UserError, match="a run brings its own controller"):
        evaluate.main(["run=run", "controller.type=foreign:Factory"])
    assert not harm_done()


def test_a_foreign_controller_is_not_published(run: RunFolder) -> None:
    changed(run, lambda values: values["controller"].update(type="foreign:Factory"))
    with pytest.raises(UserError, match="is not shipped"):
        publish.main(["run=run", "name=foreign"])
    assert not harm_done()


# Elsewhere ----------------------------------------------------------------------------------------------------------


@programs
@pytest.mark.parametrize(
    "name", ["evaluation.json.part", "checkpoints/last.safetensors", "played_episodes", "diagnosis"]
)
def test_links_that_lead_out_of_a_run_are_not_followed(
    run: RunFolder, main: Main, arguments: list[str], name: str
) -> None:
    precious = Path("precious")
    precious.mkdir()
    link = run.path / name
    link.unlink(missing_ok=True)
    link.symlink_to(precious.absolute())
    with pytest.raises(UserError, match=f"a link that leads out of it, run/{name}"):
        main(arguments)
    assert not list(precious.iterdir())


def test_a_run_may_be_a_link_and_have_links_within(run: RunFolder) -> None:
    run.checkpoint("best").unlink()
    run.checkpoint("best").symlink_to("last.safetensors")
    Path("mine").symlink_to("run")
    evaluate.main(["run=mine", "episodes=1", "checkpoint=best"])
    assert (run.path / "evaluation.json").exists()


def test_a_run_stays_in_its_folder_whatever_its_configuration_holds(run: RunFolder) -> None:
    changed(run, lambda values: values.update(run_dir=os.path.abspath("elsewhere")))
    evaluate.main(["run=run", "episodes=1", "record.every=1"])
    assert not Path("elsewhere").exists()
    assert {"evaluation.json", "evaluated_episodes"} <= {path.name for path in run.path.iterdir()}


@pytest.mark.parametrize("value", ["${oc.env:SECRET}", "x${oc.env:SECRET}", "$SECRET", "${seed}", "???"])
def test_the_environment_is_not_read(run: RunFolder, value: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SECRET", "leaked")
    changed(run, lambda values: values["agent"].update(name=value))
    assert read_training(run.config)[0].agent.name == value


# Memory -------------------------------------------------------------------------------------------------------------


def test_aliases_that_multiply_are_refused(run: RunFolder) -> None:
    lines = ["a0: &a0 [1, 1]", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 60))]
    run.config.write_text(f"{run.config.read_text()}\n" + "\n".join(lines))
    with pytest.raises(UserError, match="damaged or not written by"):
        read_training(run.config)


def test_a_configuration_without_end_is_refused(run: RunFolder) -> None:
    for text in ("#" * (LARGEST_CONFIG + 1), "seed: " + "[" * 10_000, "seed: " + "9" * 10_000):
        run.config.write_text(text)
        with pytest.raises(UserError, match="damaged or not written by"):
            read_training(run.config)


@programs
@pytest.mark.parametrize(
    ("section", "name", "value", "sentence"),
    [
        ("network", "widths", [60_000, 60_000, 60_000], "fewer than the network has"),
        ("network", "widths", [3000, 3000], "of another shape"),
        ("agent", "buffer_size", 10**400, "agent.buffer_size"),
        ("task", "time_limit_steps", 10**400, "task.time_limit_steps"),
        ("agent", "gamma", 10**400, "not a configuration of this version"),
        ("agent", "gamma", [[0.9]], "agent.gamma"),
        ("controller", "gains", [[1.0], [1.0]], "controller.gains"),
    ],
)
def test_enormous_numbers_are_one_sentence(
    run: RunFolder, main: Main, arguments: list[str], section: str, name: str, value: object, sentence: str
) -> None:
    changed(run, lambda values: values[section].update({name: value}))
    with pytest.raises(UserError, match=sentence):
        main(arguments)


def test_a_step_log_that_unpacks_without_end_is_not_unpacked(run: RunFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tools.diagnosis.step_metrics.MAX_UNPACKED_BYTES", NUM_BYTES)
    write_steps(run, np.zeros(NUM_BYTES, dtype=np.float32))
    assert run.steps.stat().st_size < NUM_BYTES / 10
    with pytest.raises(UserError, match=r"steps.npz is damaged"):
        diagnose.main(["run=run", "episodes=1"])


def test_a_policys_header_takes_no_memory_its_file_does_not_fill(tmp_path: Path) -> None:
    shape = '{"observation_size": 124, "scan_shape": %s, "action_low": [0, -1], "action_high": [1, 1], "widths": %s}'
    wide, narrow = "[60000, 60000, 60000]", "[9, 9]"
    for scan_shape, widths in (("null", wide), ("[100000, 1000000]", narrow), ("[-1, -5]", narrow)):
        header = f'{{"format": 1, "step": 1, "shape": {shape % (scan_shape, widths)}}}'
        save_file({"policy": torch.zeros(3)}, tmp_path / "policy.safetensors", metadata={"asddpg_policy": header})
        with pytest.raises(UserError, match="damaged"):
            read_policy(tmp_path / "policy.safetensors")
