"""The commands as a user types them, valid and invalid."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from asddpg import evaluate, play, train
from asddpg.episodes.protocols import Action, Observation
from asddpg.errors import UserError
from asddpg.observers.metrics_log import read_rows
from asddpg.recording.files.reading import open_recording
from asddpg.runs import weights_file
from tasks import ALL_TASKS
from tasks.errors import TaskError
from tasks.rooms.reading import ROOMS

SMALL = ["task=nav_empty", "total_steps=400", "agent.learning_starts=100", "network=fc2x100", "test_episodes=2"]
SMALL += ["robots=2", "validation.every=200", "validation.episodes=1", "task.time_limit_steps=40"]


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "run"
    train.main([*SMALL, f"run_dir={folder}"])
    return folder


def test_a_run_folder_explains_itself(finished_run: Path) -> None:
    config = yaml.safe_load((finished_run / "config.yaml").read_text())
    assert config["task"]["name"] == "nav_empty"
    assert config["agent"]["learning_starts"] == 100
    assert len(config["provenance"]["model_hash"]) == 16
    assert config["provenance"]["mujoco"].startswith("3.")
    rows = read_rows(finished_run / "metrics.csv")
    shares = [[float(row[f"{name}_100"]) for name in ("success", "collision", "timeout")] for row in rows[:-1]]
    assert all(sum(each) == pytest.approx(1.0) for each in shares)
    assert int(rows[-1]["step"]) == 400
    assert {row["outcome"] for row in rows} <= {"reached", "crashed", "timeout", "cut"}
    assert sum(int(row["steps"]) for row in rows) == 400
    assert float(rows[-1]["critic_loss"]) > 0
    assert len(read_rows(finished_run / "validation.csv")) == 2
    assert list((finished_run / "tensorboard").iterdir())
    tested = json.loads((finished_run / "test.json").read_text())
    assert set(tested) >= {"last", "best", "model_hash", "driver"}
    for figure in ("success_rate", "collision_rate", "timeout_rate", "metric", "mean_time", "spl"):
        assert len(tested["last"][figure]["ci95"]) == 2


def test_best_is_where_validation_was_best(finished_run: Path) -> None:
    rows = read_rows(finished_run / "validation.csv")
    best = max(rows, key=lambda row: (float(row["success_rate"]), float(row["metric"])))
    kept = {name: weights_file.read(finished_run / f"checkpoints/{name}.safetensors")[1] for name in ("last", "best")}
    assert kept["last"] == 400
    # A validation is written at the end of the episode in which it falls due.
    assert kept["best"] == int(best["step"])


class Spin:
    """A controller that turns on the spot."""

    def __init__(self, gains: list[float], low: Action, high: Action) -> None:
        self.action = np.array([low[0], high[1]], dtype=np.float32)

    def act(self, observation: Observation) -> Action:
        return self.action


class NotFinite(Spin):
    """A controller with actions that no robot can do."""

    def act(self, observation: Observation) -> Action:
        return np.full(2, np.nan, dtype=np.float32)


@pytest.mark.parametrize("agent", ["asddpg", "ddpg"])
@pytest.mark.parametrize(
    ("kind", "sentence"), [("nowhere:No", "package.module"), (f"{__name__}:NotFinite", "2 numbers")]
)
def test_a_controller_is_tried_before_anything_is_made(
    agent: str, kind: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=sentence):
        train.main([f"agent={agent}", f"controller.type={kind}"])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("driver", ["actor", "switch"])
def test_evaluating_a_run(finished_run: Path, driver: str, capsys: pytest.CaptureFixture[str]) -> None:
    evaluate.main([f"run={finished_run}", "episodes=2", f"driver={driver}", "checkpoint=best"])
    assert "success rate" in capsys.readouterr().out
    found = json.loads((finished_run / "evaluation.json").read_text())
    rates = [found[f"{name}_rate"]["value"] for name in ("success", "collision", "timeout")]
    assert sum(rates) == pytest.approx(1.0)
    assert found["driver"] == driver


def test_results_and_recordings_go_where_out_says(
    finished_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = sorted(finished_run.rglob("*"))
    monkeypatch.chdir(tmp_path)
    for run in (finished_run, "pretrained:nav_simple"):
        out = Path("mine") / Path(run).name
        evaluate.main([f"run={run}", "episodes=1", "record.every=1", f"out={out}"])
        play.main([f"run={run}", "episodes=1", f"out={out}"])
        assert {path.name for path in out.iterdir()} == {"evaluation.json", "evaluated_episodes", "played_episodes"}
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]
    assert sorted(finished_run.rglob("*")) == before


def test_a_run_of_another_owner_names_the_option_that_helps(
    finished_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("asddpg.drivers.driver_setup.os.access", lambda *_: False)
    for program in (evaluate, play):
        with pytest.raises(UserError, match=f"{finished_run} cannot be written; out=<folder> puts"):
            program.main([f"run={finished_run}", "episodes=1"])


@pytest.mark.parametrize("driver", ["actor", "switch"])
def test_a_recorded_driver_s_values_are_those_of_the_switch_and_change_no_result(
    driver: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    results, steps = [], []
    for record in ("record.every=1", "record.every=0"):
        evaluate.main(["run=pretrained:nav_simple", f"driver={driver}", "episodes=2", record])
        results.append({**json.loads(Path("evaluation.json").read_text()), "recordings": ""})
    assert results[0] == results[1]
    for path in Path("evaluated_episodes").iterdir():
        steps += open_recording(path).steps()
    assert all(step["q_policy"] != step["q_controller"] and "value" in step for step in steps)
    if driver == "switch":
        assert all((step["q_controller"] > step["q_policy"]) == (step["driver"] == "controller") for step in steps)


def test_fresh_pairs_are_drawn_by_seed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    results = []
    for seed in (1, 1, 2):
        evaluate.main(["agent=controller", "task=nav_empty", "episodes=3", f"seed={seed}"])
        results.append(json.loads(Path("evaluation.json").read_text()))
    assert results[0] == results[1]
    assert results[0]["metric"] != results[2]["metric"]


def test_baselines_need_no_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main(["agent=controller", "task=nav_empty", "episodes=5"])
    assert json.loads(Path("evaluation.json").read_text())["success_rate"]["value"] == 1.0
    evaluate.main(["agent=random", "task=nav_empty", "episodes=2"])


def test_same_seed_twice_is_equal_to_the_last_bit(tmp_path: Path) -> None:
    """In processes of their own, one beside the other's leftovers of nothing."""
    for name in ("one", "two"):
        arguments = [sys.executable, "-m", "asddpg.train", *SMALL, "seed=3", f"run_dir={tmp_path / name}"]
        subprocess.run(arguments, check=True, capture_output=True)
    one, two = tmp_path / "one", tmp_path / "two"
    assert (one / "metrics.csv").read_bytes() == (two / "metrics.csv").read_bytes()
    assert (one / "validation.csv").read_bytes() == (two / "validation.csv").read_bytes()
    assert (one / "checkpoints/last.safetensors").read_bytes() == (two / "checkpoints/last.safetensors").read_bytes()


def test_other_seeds_differ(finished_run: Path, tmp_path: Path) -> None:
    train.main([*SMALL, "seed=5", f"run_dir={tmp_path / 'run'}"])
    assert (tmp_path / "run/metrics.csv").read_bytes() != (finished_run / "metrics.csv").read_bytes()


def test_ddpg_never_uses_the_controller(tmp_path: Path) -> None:
    train.main([*SMALL, "agent=ddpg", f"run_dir={tmp_path / 'run'}"])
    rows = read_rows(tmp_path / "run/metrics.csv")
    assert {float(row["controller_share"]) for row in rows} == {0.0}
    assert rows[-1]["switch_loss"] == ""
    with pytest.raises(UserError, match="driver=actor"):
        evaluate.main([f"run={tmp_path / 'run'}", "driver=switch"])


def test_a_controller_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    evaluate.main(["agent=controller", f"controller.type={__name__}:Spin", "task=nav_empty", "episodes=1"])
    assert json.loads(Path("evaluation.json").read_text())["timeout_rate"]["value"] == 1.0


INVALID_ARGUMENTS = [
    ("task=nav_foo", "nav_empty, nav_simple, nav_complex"),
    ("agent=sac", "asddpg, asddpg_paper, astd3, ddpg"),
    ("agent=controller", "asddpg.evaluate agent=controller"),
    ("network=fc9x9", "fc2x100, fc3x100, fc3x256"),
    ("reward=lush", "dense, sparse"),
    ("device=tpu", "cpu, cuda"),
    ("totl_steps=5", "did you mean total_steps"),
    ("batch_size=5", "agent.batch_size"),
    ("total_steps=abc", "total_steps.*'abc'"),
    ("total_steps=-1", "greater than 0, not -1"),
    ("seed=-5", "from 0 to"),
    ("agent.batch_size=100001", "agent.buffer_size, 100000"),
    ("agent.gamma=1.5", "below 1"),
    ("agent.gamma=nan", "finite"),
    ("controller.gains=[1]", "two numbers"),
    ("controller.type=nowhere:Nothing", "package.module:Factory"),
    ("network.widths=[]", "two or more layers"),
    ("seed", "name=value"),
    ("+seed=1", "no option '.seed'; did you mean seed"),
    (
        "seed=1,2",
        "whole number, not '1,2'; for several runs, .*for value in 1 2; do .*seed=.value; done",
    ),
    ("seed=range(5)", "whole number.*for value in 1 2 3; do"),
    ("agent=asddpg,ddpg", "for value in asddpg ddpg; do"),
    ("--multirun", "for several runs, a loop of the shell"),
    ("hydra.run.dir=x", "run_dir= names the folder"),
    ("--config-name=x", "no file of options is read"),
    ("--cfg", "--help lists the options"),
    ("--seed", "name=value, such as seed=…"),
    ("--run-dir=x", "did you mean run_dir"),
    ("SEED=1", "did you mean seed"),
    ("~seed", "such as seed=…"),
    ("--resume", "such as resume=…"),
    ("run_dir=a\nb", "a single text"),
    ("run_dir=a\udce4b", "a single text"),
    ("test_episodes=500", "200"),
    ("task.name=nav_simple", "no option"),
    ("task.control_timestep=0.013", "multiple of the physics step"),
    ("controller.type=builtins:dict", "act"),
    ("agent.withdrawal.begin=0.95", "must not come after .end, 0.9"),
    ("agent.assisted=false", "agent.imitation needs a controller"),
    ("agent.n_steps=0", "from 1 to 100"),
    ("network.convolutions=deep", "separate, shared or none"),
    ("exploration.theta=2", "below 2"),
    ("task.min_linear_velocity=0.6", "below max_linear_velocity, 0.5"),
]


@pytest.mark.parametrize(("argument", "sentence"), INVALID_ARGUMENTS)
def test_invalid_arguments_are_one_sentence_and_create_nothing(
    argument: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((UserError, TaskError), match=sentence) as caught:
        train.main([argument])
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_user_sees_a_sentence_and_status_2(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "asddpg.train", "task=nav_foo"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == f"error: there is no task 'nav_foo'; there are {', '.join(ALL_TASKS)}, or {ROOMS}\n"
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_not_empty_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "precious.txt").write_text("mine")
    with pytest.raises(UserError, match="not empty"):
        train.main([*SMALL, f"run_dir={tmp_path}"])
    assert [path.name for path in tmp_path.iterdir()] == ["precious.txt"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ([], "run=<run_dir>"),
        (["run=nowhere"], "not the folder of a run"),
        (["agent=pilot"], "controller, random"),
        (["agent=controller"], "task="),
        (["agent=controller", "task=nav_foo"], "nav_empty"),
        (["agent=controller", "task=nav_empty", "episodes=201"], "200 pairs"),
        (["agent=controller", "task=nav_empty", "episodes=0"], "from 1 to a million"),
        (["run=x", "driver=ghost"], "actor or switch"),
        (["run=x", "checkpoint=first"], "last or best"),
        (["rnu=x"], "did you mean run"),
    ],
)
def test_invalid_evaluations_are_one_sentence(
    arguments: list[str], sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((UserError, TaskError), match=sentence):
        evaluate.main(arguments)
    assert not list(tmp_path.iterdir())


def test_a_run_without_weights(finished_run: Path, tmp_path: Path) -> None:
    shutil.copy(finished_run / "config.yaml", tmp_path)
    with pytest.raises(UserError, match="no file of weights"):
        evaluate.main([f"run={tmp_path}", "episodes=1"])
    assert not (tmp_path / "evaluation.json").exists()


@pytest.mark.parametrize("text", ["", "- 1", "provenance: {}\ntask: {nmae: x}", "{", "task: {name: nav_empty}"])
def test_a_damaged_configuration(text: str, tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text(text)
    with pytest.raises(UserError, match="config.yaml"):
        evaluate.main([f"run={tmp_path}", "episodes=1"])
