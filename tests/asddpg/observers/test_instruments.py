"""Instruments of a training: snapshots, the step log, TD errors by driver."""

from pathlib import Path

import numpy as np
import pytest
import torch

from asddpg import train
from asddpg.algorithm.agent import AsDDPG
from asddpg.algorithm.losses import mean_by_driver
from asddpg.algorithm.networks import CONTROLLER, POLICY
from asddpg.build import make_agent, make_environment
from asddpg.episodes.protocols import Decision, Driver, Episode, Step
from asddpg.observers.metrics_log import MetricsLog, read_rows
from asddpg.observers.step_log import COLUMNS
from asddpg.runs import weights_file
from asddpg.runs.run_folder import RunFolder, read_training
from asddpg.training import Training
from tests.conftest import TINY
from tests.support.one_agent import steps_of


def agent_of(run: Path) -> AsDDPG:
    config, _ = read_training(RunFolder(run).config)
    return make_agent(config, make_environment(config.task, config.reward))


# Snapshots --------------------------------------------------------------------------------------------------------


def test_a_snapshot_acts_as_the_networks_did(tiny_run: Path) -> None:
    last, snapshot = agent_of(tiny_run), agent_of(tiny_run)
    paths = RunFolder(tiny_run).snapshots()
    assert len(paths) == 2
    assert weights_file.load_into(tiny_run / "checkpoints/last.safetensors", last.networks) == 400
    assert weights_file.load_into(paths[-1], snapshot.networks) == 400  # of the validation that ended the training
    observations = np.random.default_rng(0).uniform(-0.5, 0.5, (20, 124)).astype(np.float32)
    for observation in observations:
        np.testing.assert_array_equal(snapshot.act(observation), last.act(observation))
        one, other = snapshot.decide_greedily(observation), last.decide_greedily(observation)
        assert (one.q_policy, one.q_controller, one.driver) == (other.q_policy, other.q_controller, other.driver)
    weights_file.load_into(paths[0], snapshot.networks)
    assert not np.array_equal(snapshot.act(observations[0]), last.act(observations[0]))


def test_snapshots_can_be_left_out(tmp_path: Path) -> None:
    arguments = [*TINY, "total_steps=120", "validation.every=50", "validation.snapshots=false"]
    train.main(["task=nav_empty", *arguments, f"run_dir={tmp_path / 'run'}"])
    assert RunFolder(tmp_path / "run").snapshots() == []
    assert (tmp_path / "run/validation.csv").is_file()


# Step log ---------------------------------------------------------------------------------------------------------


def test_the_step_log_agrees_with_the_metrics(tiny_run: Path) -> None:
    with np.load(tiny_run / "steps.npz", allow_pickle=False) as steps:
        log = dict(steps)
    assert set(log) == set(COLUMNS)
    assert {(column.shape, column.dtype) for column in log.values()} == {((400,), np.dtype(np.float32))}
    for row in read_rows(tiny_run / "metrics.csv"):
        mine = log["episode"] == int(row["episode"])
        assert mine.sum() == int(row["steps"])
        assert log["by_controller"][mine].mean() == pytest.approx(float(row["controller_share"]))
        places = np.stack([log["x"][mine], log["y"][mine]], axis=1)
        np.testing.assert_array_equal(places[0], [0.0, 0.0])  # the start in this room
        driven = np.hypot(*np.diff(places, axis=0).T).sum()
        assert driven <= float(row["path_length"]) + 1e-3  # the last step's way is in the path alone
        assert driven >= float(row["path_length"]) - 0.11


def test_the_step_log_holds_driver_and_q_values(tiny_run: Path) -> None:
    with np.load(tiny_run / "steps.npz", allow_pickle=False) as steps:
        log = dict(steps)
    by_controller, preferred = log["by_controller"] == 1.0, log["q_controller"] > log["q_policy"]
    assert 0 < by_controller.sum() < 400
    assert preferred[by_controller].all()
    assert not by_controller[preferred].all()  # the schedule withdrew the controller although the switch wanted it
    # The controller's action is its own, the policy's is the actor's with noise.
    gap = np.abs(log["omega"] - log["actor_omega"])
    assert (gap[~by_controller] > 0).any()
    assert gap[~by_controller].max() < 2.0
    assert np.isfinite(log["distance"]).all()


def test_without_withdrawal_the_switch_alone_decides(tmp_path: Path) -> None:
    train.main(["task=nav_complex", *TINY, "agent.withdrawal.last_share=0", f"run_dir={tmp_path / 'run'}"])
    with np.load(tmp_path / "run/steps.npz", allow_pickle=False) as steps:
        by_controller = steps["by_controller"] == 1.0
        np.testing.assert_array_equal(by_controller, steps["q_controller"] > steps["q_policy"])
    assert 0 < by_controller.sum() < 400


def test_an_interrupted_training_keeps_its_steps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Training, "_validate", interrupt)
    with pytest.raises(KeyboardInterrupt):
        train.main(["task=nav_empty", *TINY, "validation.every=50", f"run_dir={tmp_path / 'run'}"])
    with np.load(tmp_path / "run/steps.npz", allow_pickle=False) as steps:
        assert len(steps["x"]) == 50


# TD errors --------------------------------------------------------------------------------------------------------


def test_a_driver_without_samples_has_no_error() -> None:
    errors = mean_by_driver(torch.tensor([1.0, 3.0]), torch.ones(2))
    assert errors[POLICY] == 2.0
    assert torch.isnan(errors[CONTROLLER])


class NoWriter:
    def add_scalar(self, tag: str, scalar_value: float, global_step: int) -> None:
        assert np.isfinite(scalar_value), tag


def test_the_metrics_average_over_updates_that_had_samples(tmp_path: Path) -> None:
    log = MetricsLog(tmp_path / "metrics.csv", tmp_path / "timing.csv", NoWriter())
    nan, zeros = float("nan"), np.zeros(2, dtype=np.float32)
    steps = steps_of(Step(zeros, Decision(zeros, Driver.POLICY), 0.0, zeros, False, False, {}))
    for errors in ([(1.0, nan), (2.0, 5.0), (3.0, nan)], [(1.0, nan)], []):
        log.step(steps, ())
        for policy, controller in errors:
            log.step(steps, [{"critic_loss": 1.0, "td_error_policy": policy, "td_error_controller": controller}])
        log.end_episode(0, 1, Episode("reached", 3, 0.0, 0, 0.0))
    log.close()
    found = [(row["td_error_policy"], row["td_error_controller"]) for row in read_rows(tmp_path / "metrics.csv")]
    assert found == [("2.0", "5.0"), ("1.0", ""), ("", "")]


def test_a_run_reports_td_errors_and_no_nan(tiny_run: Path) -> None:
    rows = read_rows(tiny_run / "metrics.csv")
    for name in ("td_error_policy", "td_error_controller"):
        assert any(row[name] and float(row[name]) > 0 for row in rows)
    assert "nan" not in (tiny_run / "metrics.csv").read_text()
