"""Stable-Baselines3 beside ours: its vector environment, a short run of each algorithm, the table."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asddpg.build import controller_for, make_environment
from asddpg.command_line import train_config
from asddpg.config import ControllerConfig
from asddpg.episodes.drivers import controller_alone
from asddpg.episodes.evaluation import evaluate
from asddpg.errors import UserError
from tasks.evaluation_pairs import stored_pairs
from tools.benchmarks import compare_peers, training
from tools.benchmarks.compare_peers import PeersArguments
from tools.benchmarks.peer_runs import Evaluation, PeerRun, rates_of, train
from tools.benchmarks.peer_settings import ALGORITHMS, SETTINGS


class Model:
    """Learns nothing and counts steps."""

    num_timesteps = _n_updates = 0

    def learn(self, steps: int, callback: Any, reset_num_timesteps: bool) -> None:
        for _ in range(steps):
            self.num_timesteps += 1
            if not callback({}, {}):
                break


def finished(setting: str, seconds: float, success: float) -> PeerRun:
    evaluations = [
        Evaluation(seconds / 2, seconds, 500, 0.5, 0.0),
        Evaluation(seconds, 2 * seconds, 1000, success, 0.1),
    ]
    (peer,) = compare_peers.peers(PeersArguments(["td3"], settings=[setting]))
    return replace(peer, updates=60, evaluations=evaluations)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_short_run_of_each_algorithm_leaves_a_file_and_a_row(
    algorithm: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("stable_baselines3")
    arguments = [algorithm, "settings=[defaults]", "every=160", "limit_minutes=0.01", "episodes=2"]
    compare_peers.main([*arguments, f"folder={tmp_path}"])
    content = json.loads((tmp_path / f"nav_complex_{algorithm}_defaults_seed100.json").read_text())
    assert content["updates"] > 0
    assert content["evaluations"][-1]["training_seconds"] >= 0.6
    assert f"| nav_complex | {algorithm} | defaults | 100 | 0.0, not reached |" in capsys.readouterr().out


@pytest.mark.parametrize("setting", SETTINGS)
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_every_setting_is_taken_by_the_library(algorithm: str, setting: str) -> None:
    pytest.importorskip("stable_baselines3")
    from tools.benchmarks.stable_baselines import make_peer

    config = train_config(["task=nav_empty", "network.widths=[16,16]"])
    model = make_peer(config, algorithm, setting)
    assert (model.action_noise is None) == (algorithm == "sac" or setting == "defaults")
    model.learn(32)
    low, high = model.action_space.low, model.action_space.high
    assert low[0] == pytest.approx(config.task.min_linear_velocity) == 0.05
    actions, _ = model.predict(model.env.reset(), deterministic=True)
    assert ((low <= actions) & (actions <= high)).all()
    model.env.close()


def test_the_librarys_vector_environment_gives_what_its_own_of_single_environments_gives() -> None:
    vec_env: Any = pytest.importorskip("stable_baselines3.common.vec_env")
    from tools.benchmarks.stable_baselines import make_vec_env

    config = train_config(["task=nav_complex"])
    ours = make_vec_env(config, 3)
    theirs = vec_env.DummyVecEnv([lambda: make_environment(config.task, config.reward)] * 3)
    for env in (ours, theirs):
        env.seed(5)
    np.testing.assert_equal(ours.reset(), theirs.reset())
    commands, ends = np.random.default_rng(0).uniform([0.0, -1.0], [0.5, 1.0], (3, 2)), 0
    for _ in range(220):  # beyond the time limit
        (*found, infos), (*expected, others) = ours.step(commands), theirs.step(commands)
        np.testing.assert_equal(found, expected)
        for robot in np.flatnonzero(np.asarray(found[2])):
            assert infos[robot]["TimeLimit.truncated"] == others[robot]["TimeLimit.truncated"]
            np.testing.assert_equal(infos[robot]["terminal_observation"], others[robot]["terminal_observation"])
            ends += 1
    ours.close()
    assert ends > 2


def test_the_rates_are_those_of_the_evaluation_of_one() -> None:
    config = train_config(["task=nav_complex", "validation.episodes=12"])
    env = make_environment(config.task, config.reward)
    controller = controller_for(env, ControllerConfig())
    pairs = stored_pairs("nav_complex", "validation", 0.3)[:12]
    expected = evaluate(env, controller_alone(controller), pairs, 0.2)
    rates = rates_of(lambda seen: np.stack([controller.act(each) for each in seen]), config)
    for _ in range(2):
        assert rates() == (expected.success_rate.value, expected.collision_rate.value)
    assert 0.0 < rates()[0] < 1.0


def test_a_run_ends_where_the_target_is_reached_and_evaluations_count_apart() -> None:
    peer = PeerRun("nav_complex", "td3", "defaults", 0, "", 0.9, 30.0)
    found = iter([(0.4, 0.1), (0.9, 0.0), (1.0, 0.0)])
    train(peer, Model(), lambda: next(found), every=10)
    assert [(each.steps, each.success_rate) for each in peer.evaluations] == [(10, 0.4), (20, 0.9)]
    assert peer.is_reached
    assert all(each.training_seconds < each.wall_seconds for each in peer.evaluations)


def test_a_run_ends_within_its_steps_where_the_limit_is_up() -> None:
    peer = PeerRun("nav_complex", "td3", "defaults", 0, "", 0.9, 0.001)
    train(peer, Model(), lambda: (0.0, 0.0), every=10**9)
    assert len(peer.evaluations) == 1
    assert 0.06 <= peer.evaluations[0].training_seconds < 1.0


def test_the_table_has_the_fastest_first_and_says_what_was_not_reached(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    slow, fast = finished("defaults", 1200.0, 0.9), finished("matched", 600.0, 0.92)
    for peer in (finished("frequent", 60.0, 0.6), slow, fast):
        peer.write(tmp_path / f"{peer.title}.json")
        assert PeerRun.read(tmp_path / f"{peer.title}.json") == peer
    compare_peers.main(["table", f"folder={tmp_path}"])
    rows = [line.split(" | ") for line in capsys.readouterr().out.splitlines()[2:]]
    assert [row[2] for row in rows] == ["matched", "defaults", "frequent"]
    assert [row[4] for row in rows] == ["10.0", "20.0", "1.0, not reached"]


OTHERS = "is a run with target=0.9 limit_minutes=30; folder= takes another folder"


@pytest.mark.parametrize(
    ("option", "sentence"),
    [("limit_minutes=29", OTHERS), ("target=0.95", OTHERS), ("episodes=49", "another task, reward or number of")],
)
def test_a_finished_run_is_not_trained_again_and_stands_for_no_other_conditions(
    option: str, sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("stable_baselines3")
    peer = finished("matched", 60.0, 0.6)
    peer.write(tmp_path / f"{peer.title}.json")
    arguments = ["td3", "settings=[matched]", f"folder={tmp_path}"]
    compare_peers.main(arguments)
    assert "| td3 | matched | 100 | 1.0, not reached |" in capsys.readouterr().out
    with pytest.raises(UserError, match=sentence):
        compare_peers.main([*arguments, option])


def test_a_damaged_file_and_an_empty_folder_are_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    compare_peers.main(["table", f"folder={tmp_path}"])
    assert "there is no finished run" in capsys.readouterr().out
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(UserError, match=r"broken\.json is not a whole run of tools\.benchmarks\.compare_peers"):
        compare_peers.main(["table", f"folder={tmp_path}"])


def test_samples_learned_a_second_are_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("stable_baselines3")
    monkeypatch.setattr(training, "ROUNDS", 1)
    training.samples()
    assert "samples/s" in capsys.readouterr().out
