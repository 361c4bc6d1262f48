"""NaN or an infinite number ends a training with a sentence, and with a folder from which it occurs again."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import torch
import yaml

from asddpg import reproduce, train
from asddpg.algorithm.agent import AsDDPG
from asddpg.episodes.training_episodes import TrainingEpisodes
from asddpg.errors import NumericalFailure, UserError
from asddpg.runs import state_files
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv
from tests.support.small_runs import QUICK, stopped

NAN = float("nan")
Found = tuple[Any, ...]  # what finish_step() returns


class Faulty:
    """The robots of a training, and a fault in one step."""

    def __init__(self, robots: NavigationVectorEnv, steps: int, step: int, fault: "Fault") -> None:
        self.robots, self.physics = robots, robots.envs[0].physics
        self._steps, self._step, self._fault = steps, step, fault

    def __getattr__(self, name: str) -> Any:
        return getattr(self.robots, name)

    def begin_step(self, actions: Any) -> None:
        self._steps += 1
        self._actions = actions
        if self._steps != self._step:
            self.robots.begin_step(actions)

    def finish_step(self) -> Found:
        return self._fault(self, self._actions) if self._steps == self._step else self.robots.finish_step()


Fault = Callable[[Faulty, Any], Found]


def nan_reward(faulty: Faulty, actions: Any) -> Found:
    observations, rewards, *rest = faulty.robots.step(actions)
    return observations, np.full_like(rewards, NAN), *rest


def infinite_observation(faulty: Faulty, actions: Any) -> Found:
    observations, *rest = faulty.robots.step(actions)
    observations[0, 7] = np.inf
    return observations, *rest


def nan_action(faulty: Faulty, _: Any) -> Found:
    return faulty.robots.step(np.full((1, 2), np.nan, np.float32))


def huge_velocity(faulty: Faulty, actions: Any) -> Found:
    faulty.physics.data.ptr.qvel[:] = 1e12
    return faulty.robots.step(actions)


def everything_in_one_place(faulty: Faulty, actions: Any) -> Found:
    """More contacts than MuJoCo has memory for."""
    model, data = faulty.physics.model.ptr, faulty.physics.data.ptr
    free = model.jnt_qposadr[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
    for address in free:
        data.qpos[address : address + 3] = data.qpos[free[0] : free[0] + 3]
    return faulty.robots.step(actions)


def break_at(patch: pytest.MonkeyPatch, step: int, fault: Fault) -> None:
    real = TrainingEpisodes.drive_step

    def drive_step(self: TrainingEpisodes, total_steps: int) -> None:
        if not isinstance(self._environment, Faulty):
            assert isinstance(self._environment, NavigationVectorEnv)
            self._environment = Faulty(self._environment, self.step, step, fault)
        real(self, total_steps)

    patch.setattr(TrainingEpisodes, "drive_step", drive_step)


def limit_memory(patch: pytest.MonkeyPatch, num_bytes: int) -> None:
    compile_ = mujoco.MjSpec.compile

    def compile_small(self: mujoco.MjSpec) -> mujoco.MjModel:
        self.memory = num_bytes
        return compile_(self)

    patch.setattr(mujoco.MjSpec, "compile", compile_small)


def reproduced(capsys: pytest.CaptureFixture[str]) -> str:
    """The output of asddpg.reproduce for the one dump of ./run."""
    (dump,) = Path("run").glob("failure_*")
    capsys.readouterr()
    reproduce.main([str(dump)])
    return capsys.readouterr().out


@pytest.fixture(autouse=True)
def _working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("step", [20, 137])  # before the first checkpoint, and after
@pytest.mark.parametrize(
    ("fault", "what", "finished"),
    [
        (nan_reward, "the reward is nan", 0),
        (infinite_observation, "the observation holds inf", 0),
        (nan_action, "Physics state is invalid.*BADCTRL", -1),
        (huge_velocity, "Physics state is invalid.*BADQ", -1),
    ],
)
def test_a_fault_stops_with_a_sentence_and_is_met_again(
    fault: Fault,
    what: str,
    finished: int,
    step: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    break_at(monkeypatch, step, fault)
    sentence = f"after step {step + finished} {what}.*asddpg.reproduce run/failure"
    with pytest.raises(NumericalFailure, match=sentence) as caught:
        train.main([*QUICK, "run_dir=run"])
    assert "\n" not in str(caught.value)
    output = reproduced(capsys)
    assert f"it was: after step {step + finished} " in output
    assert f"again: after step {step + finished} " in output
    begun = int(output.split("driving from step ")[1].split("\n")[0])
    assert begun == (100 if step > 100 else 0)


def test_a_log_holds_no_failed_step(unbroken: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the fault the run resumes from its last training state."""
    with monkeypatch.context() as patch:
        break_at(patch, 137, nan_reward)
        with pytest.raises(NumericalFailure):
            train.main([*QUICK, "run_dir=run"])
    assert "nan" not in Path("run/metrics.csv").read_text().lower()
    dump = Path("run/failure_00000137")
    assert {path.name for path in dump.iterdir()} == {"config.yaml", "failure.json", "resume"}
    assert [path.name for path in (dump / "resume").iterdir()] == ["step_00000100"]
    assert yaml.safe_load((dump / "config.yaml").read_text())["total_steps"] == 240
    train.main(["resume=run"])
    assert Path("run/metrics.csv").read_bytes() == (unbroken / "metrics.csv").read_bytes()


@pytest.mark.parametrize("memory", [80_000, 200_000])
def test_too_many_contacts(memory: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """With little memory MuJoCo warns, with some more it gives up: both are failures."""
    limit_memory(monkeypatch, memory)
    break_at(monkeypatch, 60, everything_in_one_place)
    with pytest.raises(NumericalFailure, match=r"after step 59 (Physics state is invalid|mj_stackAlloc)") as caught:
        train.main([*QUICK, "task=nav_gazebo", "validation.every=0", "run_dir=run"])
    assert "\n" not in str(caught.value)
    assert "again: after step 59 " in reproduced(capsys)


# Learning ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("loss", ["critic_loss", "switch_loss", "policy_loss"])
def test_a_loss_that_is_nan_stops_the_training(
    loss: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    real = AsDDPG.learn

    def learn(self: AsDDPG) -> Any:
        learned = real(self)
        return [*learned, {loss: torch.tensor(NAN)}] if self.steps == 120 else learned

    monkeypatch.setattr(AsDDPG, "learn", learn)
    with pytest.raises(NumericalFailure, match=f"after step 120 {loss} is nan"):
        train.main([*QUICK, "run_dir=run"])
    assert f"again: after step 120 {loss} is nan" in reproduced(capsys)


def spoil_weights(patch: pytest.MonkeyPatch, step: int) -> None:
    """One weight that no loss depends on yet."""
    real = AsDDPG.learn

    def learn(self: AsDDPG) -> Any:
        learned = real(self)
        if self.steps == step:
            self.learner._target_policy.vector[3] = NAN
        return learned

    patch.setattr(AsDDPG, "learn", learn)


@pytest.mark.parametrize("step", [150, 240])  # a training state's, and the last
def test_a_weight_that_is_nan_is_never_kept(
    step: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil_weights(monkeypatch, step)
    with pytest.raises(NumericalFailure, match=f"after step {step} a weight of target_policy is not finite"):
        train.main([*QUICK, "run_dir=run"])
    for path in Path("run/resume").iterdir():
        for tensor in state_files.read(path)["episodes"]["agent"]["learner"]["weights"].values():
            assert bool(torch.isfinite(tensor).all())
    assert f"again: after step {step} a weight of target_policy is not finite" in reproduced(capsys)


def test_a_weight_that_is_nan_is_noticed_where_a_user_stops(monkeypatch: pytest.MonkeyPatch) -> None:
    spoil_weights(monkeypatch, 130)
    with pytest.raises(NumericalFailure, match="after step 130 a weight of target_policy"):
        stopped([*QUICK, "run_dir=run"], 130)


# Reproducing ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [137, 240])
def test_a_failure_that_does_not_occur_again_is_reported(step: int, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch:
        break_at(patch, step, nan_reward)
        with pytest.raises(NumericalFailure):
            train.main([*QUICK, "run_dir=run"])
    with pytest.raises(NumericalFailure, match=f"step {step} has passed"):
        reproduce.main([f"run/failure_{step:08d}"])


@pytest.mark.parametrize("arguments", [[], ["a", "b"], ["nowhere"], ["."]])
def test_nothing_to_reproduce(arguments: list[str]) -> None:
    with pytest.raises(UserError, match="failure|at most"):
        reproduce.main(arguments)
