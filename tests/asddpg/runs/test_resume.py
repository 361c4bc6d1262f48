"""A run that was stopped resumes as if it had not been, to the last bit."""

import json
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from asddpg import train, training
from asddpg.episodes.evaluation import EvaluationResult
from asddpg.episodes.side_by_side import evaluate_side_by_side
from asddpg.errors import UserError
from asddpg.observers.metrics_log import read_rows
from asddpg.runs import weights_file
from tests.support.small_runs import (
    KINDS,
    QUICK,
    Died,
    assert_same_recordings,
    assert_same_run,
    at_step,
    die,
    interrupt,
    newest_state,
    scalars,
    stopped,
)


def ends_of_episodes(run: Path) -> list[int]:
    return [int(row["step"]) for row in read_rows(run / "metrics.csv")]


# Where it is stopped ----------------------------------------------------------------------------------------------


def test_the_unbroken_run_has_what_is_to_be_tested(unbroken: Path) -> None:
    assert len(ends_of_episodes(unbroken)) > 6
    assert len(list((unbroken / "episodes").iterdir())) > 3
    assert len(read_rows(unbroken / "validation.csv")) == 2
    assert {tag.split("/")[0] for tag in scalars(unbroken)} == {"train", "validation"}


@pytest.mark.parametrize("act", [interrupt, die])
@pytest.mark.parametrize("place", ["before any checkpoint", "first", "middle", "last", "checkpoint", "end"])
def test_stopped_anywhere_it_comes_out_the_same(unbroken: Path, place: str, act: Callable[[], None], run: Path) -> None:
    third, fourth = ends_of_episodes(unbroken)[2:4]
    step = {"first": third + 1, "middle": fourth - 3, "last": fourth, "checkpoint": 100, "end": 240}.get(place, 30)
    status = stopped([*QUICK, f"run_dir={run}"], step, act)
    assert status == (130 if act is interrupt else -9)
    if act is interrupt:
        assert newest_state(run)["step"] == step
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


@pytest.mark.parametrize("kind", KINDS)
def test_stopped_again_and_again_it_comes_out_the_same(
    unbroken_kind: Callable[[str], Path], kind: str, tmp_path: Path
) -> None:
    run, ends = tmp_path / "run", ends_of_episodes(unbroken_kind(kind))
    stopped([*QUICK, *KINDS[kind], f"run_dir={run}"], ends[0] + 2)
    for step, act in [(ends[2] + 1, interrupt), (161, die), (239, interrupt)]:
        stopped([f"resume={run}"], step, act)
    train.main([f"resume={run}"])
    assert_same_run(unbroken_kind(kind), run)


def test_stopped_during_a_validation(unbroken: Path, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopping(*arguments: Any, **options: Any) -> EvaluationResult:
        interrupt()
        return evaluate_side_by_side(*arguments, **options)

    monkeypatch.setattr(training, "evaluate_side_by_side", stopping)
    with pytest.raises(SystemExit) as ended:
        train.main([*QUICK, f"run_dir={run}"])
    assert ended.value.code == 130
    assert not (run / "validation.csv").exists()
    monkeypatch.undo()
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


def test_stopped_during_the_test_at_the_end(unbroken: Path, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopping(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(train, "test", stopping)
    with pytest.raises(KeyboardInterrupt):
        train.main([*QUICK, f"run_dir={run}"])
    monkeypatch.undo()
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


def test_killed_between_the_last_checkpoint_and_the_last_weights(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = weights_file.save

    def save(path: Path, networks: Any, step: int) -> None:
        if step == 240:
            raise Died
        real(path, networks, step)

    monkeypatch.setattr(weights_file, "save", save)
    with pytest.raises(Died):
        train.main([*QUICK, "validation.every=0", f"run_dir={run}"])
    monkeypatch.undo()
    train.main([f"resume={run}"])
    for name in ("last", "best"):
        assert weights_file.read(run / f"checkpoints/{name}.safetensors")[1] == 240


def test_a_clock_that_was_set_back_changes_nothing(unbroken: Path, run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each resume happens years before the one before."""
    now = time.time()
    stopped([*QUICK, f"run_dir={run}"], 120)
    for step in (130, 170, 240):
        monkeypatch.setattr(time, "time", lambda step=step: now - 1e7 * step)
        stopped([f"resume={run}"], step, die)
    train.main([f"resume={run}"])
    assert_same_run(unbroken, run)


def test_what_was_recorded_and_kept_is_the_same(tmp_path: Path) -> None:
    """Only the newest recordings are kept, and those of before the resume are among them."""
    arguments = [*QUICK, "record.every=1", "record.keep=3", "validation.every=0", "test_episodes=0"]
    train.main([*arguments, f"run_dir={tmp_path / 'one'}"])
    stopped([*arguments, f"run_dir={tmp_path / 'other'}"], 165)
    train.main([f"resume={tmp_path / 'other'}"])
    assert len(list((tmp_path / "one/episodes").iterdir())) == 3
    assert_same_recordings(tmp_path / "one/episodes", tmp_path / "other/episodes")


# Options of a resume ----------------------------------------------------------------------------------------------


def begin(arguments: list[str], stop: int | None) -> None:
    """Train to the end, or up to a step."""
    if stop is None:
        train.main(arguments)
    else:
        stopped(arguments, stop)


@pytest.mark.parametrize("is_over", [False, True])
def test_total_steps_may_be_raised_and_earlier_results_stay(is_over: bool, run: Path) -> None:
    arguments = [*QUICK, "total_steps=230", "checkpoint_every=46", "validation.every=115"]  # with both at the very end
    begin([*arguments, f"run_dir={run}"], None if is_over else 125)
    snapshots, validation = set(run.glob("checkpoints/step_*")), (run / "validation.csv").read_bytes()
    tested = (run / "test.json").read_bytes() if is_over else b""
    assert newest_state(run)["validations"] == 1 + is_over  # the one after the last step is not made again
    train.main([f"resume={run}", "total_steps=300"])
    assert (run / "validation.csv").read_bytes().startswith(validation)
    assert set(run.glob("checkpoints/step_*")) >= snapshots
    assert not is_over or (run / "test_step_00000230.json").read_bytes() == tested
    rows = read_rows(run / "metrics.csv")
    assert sum(int(row["steps"]) for row in rows) == int(rows[-1]["step"]) == 300
    assert [int(row["episode"]) for row in rows] == list(range(1, len(rows) + 1))
    # The old end stays what it was.
    assert [int(row["step"]) for row in rows[:-1] if row["outcome"] == "cut"] == [230] * is_over
    config = yaml.safe_load((run / "config.yaml").read_text())
    assert config["total_steps"] == 300
    assert config["provenance"]["prolonged"] == f"from 230 to 300 at step {230 if is_over else 125}"
    validated = [int(row["step"]) for row in read_rows(run / "validation.csv")]
    assert sorted(path.name for path in run.glob("checkpoints/step_*")) == [
        f"step_{step:08d}.safetensors" for step in validated
    ]
    assert step_of_best(run) in validated
    assert (run / "test.json").exists()
    for metrics in scalars(run).values():
        assert len({step for step, _ in metrics}) == len(metrics)


def step_of_best(run: Path) -> int:
    return weights_file.read(run / "checkpoints/best.safetensors")[1]


def test_the_best_weights_are_of_this_past_and_no_other(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Weights that a validation after the checkpoint found best are of steps that are made otherwise."""
    rates = [0.5, 1.0]

    def rated(*arguments: Any, **options: Any) -> EvaluationResult:
        metrics = evaluate_side_by_side(*arguments, **options)
        return replace(metrics, success_rate=metrics.success_rate._replace(value=rates.pop(0) if rates else 0.0))

    monkeypatch.setattr(training, "evaluate_side_by_side", rated)
    stopped(
        [*QUICK, "validation.every=110", f"run_dir={run}"], 239, die
    )  # the second validation lies after the checkpoint of step 200
    first, second = (int(row["step"]) for row in read_rows(run / "validation.csv"))
    assert first < 200 < second == step_of_best(run)
    train.main([f"resume={run}", "total_steps=250"])
    assert step_of_best(run) == first


def test_a_run_that_resumes_in_another_scene_records_it(
    halfway: Path, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(halfway, run)
    config = run / "config.yaml"
    config.write_text(re.sub("model_hash: .*", "model_hash: 0ld5cene", config.read_text()))
    train.main([f"resume={run}"])
    assert "note: it resumes with model_hash" in capsys.readouterr().out
    provenance = yaml.safe_load(config.read_text())["provenance"]
    assert provenance["model_hash"] == "0ld5cene"
    assert provenance["resumed"].startswith("at step")
    assert "resumed" in json.loads((run / "test.json").read_text())


def test_a_folder_that_is_moved_while_it_is_written_ends_the_training(run: Path, tmp_path: Path) -> None:
    def move() -> None:
        run.rename(tmp_path / "moved")

    with pytest.raises(UserError, match="has been removed or replaced"):
        stopped([*QUICK, "checkpoint_every=0", f"run_dir={run}"], 60, move)


@pytest.fixture(scope="module")
def halfway(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that was stopped; to be read, not written to."""
    run = tmp_path_factory.mktemp("halfway") / "run"
    stopped([*QUICK, f"run_dir={run}"], 60)
    return run


PAST = (
    *("seed=5", "agent.n_steps=1", "record.every=7", "validation.every=7", "network.widths=[8,8]"),
    *("run_dir=elsewhere", "agent=ddpg", "task=nav_empty", "reward=sparse"),
)


@pytest.mark.parametrize(
    ("argument", "sentence"),
    [
        *((argument, f"{argument.split('=')[0]}= would change the past") for argument in PAST),
        ("total_steps=100", "raised, not lowered: it has 240"),
        ("checkpoint_every=-1", "0 or more"),
        ("port=many", "port.*many"),
        ("totl_steps=5", "did you mean total_steps"),
        ("resume=runs/b", "one run at a time"),
    ],
)
def test_other_options_are_refused_by_name(halfway: Path, argument: str, sentence: str) -> None:
    before = {path: path.read_bytes() for path in halfway.rglob("*") if path.is_file()}
    with pytest.raises(UserError, match=sentence) as caught:
        train.main([f"resume={halfway}", argument])
    assert "\n" not in str(caught.value)
    assert before == {path: path.read_bytes() for path in halfway.rglob("*") if path.is_file()}


def test_the_same_option_again_is_no_mistake(unbroken: Path, run: Path) -> None:
    stopped([*QUICK, f"run_dir={run}"], 60)
    train.main([f"resume={run}", "seed=0", "network.widths=[16,16]", "checkpoint_every=30"])
    assert (unbroken / "metrics.csv").read_bytes() == (run / "metrics.csv").read_bytes()


@pytest.mark.parametrize(
    ("path", "sentence"),
    [("", "no value"), ("nowhere", "^nowhere is not the folder of a run"), (".", "is not the folder of a run")],
)
def test_only_the_folder_of_a_run_can_be_resumed(
    path: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=sentence):
        train.main([f"resume={path}"])
    assert not list(tmp_path.iterdir())


def test_a_finished_run_is_left_alone(unbroken: Path) -> None:
    with pytest.raises(UserError, match="is complete; total_steps= above 240 prolongs it"):
        train.main([f"resume={unbroken}"])


@pytest.mark.parametrize("is_over", [False, True])
def test_a_run_without_its_training_states_is_not_restarted(is_over: bool, run: Path, tmp_path: Path) -> None:
    """All that it holds would be lost."""
    begin([*QUICK, f"run_dir={run}"], None if is_over else 130)
    (run / "resume").rename(tmp_path / "resume")
    logged = (run / "metrics.csv").read_bytes()
    with pytest.raises(UserError, match="no training state in .* to resume from; nothing has been changed"):
        train.main([f"resume={run}", "total_steps=300"])
    assert (run / "metrics.csv").read_bytes() == logged


def test_a_training_state_of_another_configuration_is_refused(run: Path) -> None:
    stopped([*QUICK, f"run_dir={run}"], 60)
    config = yaml.safe_load((run / "config.yaml").read_text())
    for section, name, value in [("network", "widths", [8, 8]), ("agent", "buffer_size", 50)]:
        changed = config | {section: config[section] | {name: value}}
        (run / "config.yaml").write_text(yaml.safe_dump(changed))
        with pytest.raises(UserError, match=r"does not fit its config\.yaml"):
            train.main([f"resume={run}"])


def test_an_error_of_a_resumed_training_is_not_blamed_on_the_checkpoint(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def break_down() -> None:
        raise ValueError("of a controller of one's own")

    stopped([*QUICK, f"run_dir={run}"], 60)
    at_step(monkeypatch, 70, break_down)
    with pytest.raises(ValueError, match="of a controller of one's own"):
        train.main([f"resume={run}"])
