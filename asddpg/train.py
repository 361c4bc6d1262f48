"""Train: `python -m asddpg.train task=nav_complex agent=asddpg reward=sparse network=fc3x256 seed=0`.

A training that was stopped resumes with `python -m asddpg.train resume=<run_dir>`; total_steps= may be raised with it.

task=, agent=, network= and reward= choose presets; the defaults below are those of task=nav_complex.
"""

import csv
import shlex
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import MISSING

import gymnasium

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import (
    check_device,
    count_driving_threads,
    make_agent,
    make_cameras,
    make_live,
    make_training_robots,
    navigation_env,
    note_omitted,
    prepare_torch,
)
from asddpg.command_line import GROUPS, resumed_config, train_config
from asddpg.config import TrainConfig
from asddpg.episodes.drivers import actor_alone
from asddpg.episodes.evaluation import EvaluationResult, evaluate, table
from asddpg.errors import UserError
from asddpg.messages import ERR, print_line
from asddpg.observers.metrics_log import read_rows
from asddpg.options.help_text import help_text
from asddpg.options.values import read_value
from asddpg.program import python, run
from asddpg.recording.how_to_open import how_to_watch
from asddpg.runs import weights_file
from asddpg.runs.lock import RunLock
from asddpg.runs.provenance import current_versions, peak_memory, recording_provenance, update_provenance
from asddpg.runs.rewind import check_logs, keep_test, rewind
from asddpg.runs.room_pairs import keep_pairs
from asddpg.runs.run_folder import RunFolder, check_unused, create_run, open_run_folder, read_training, write_json
from asddpg.runs.safe_loading import controller_argument, controller_named_in
from asddpg.runs.signals import Stopped
from asddpg.runs.training_states import TrainingStates
from asddpg.training import Parts, Training
from tasks.evaluation_pairs import stored_pairs
from tasks.options import Option

RESUME = "resume="
_RESUMED = Option("resume", str, MISSING, "Folder of the run.", None, True, "", TrainConfig)


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Begin a training or go on with one, then test."""
    paths = [argument.removeprefix(RESUME) for argument in arguments if argument.startswith(RESUME)]
    if len(paths) > 1:
        raise UserError(f"one run at a time can be resumed, not {len(paths)}")
    if paths:
        others = [argument for argument in arguments if not argument.startswith(RESUME)]
        resume(read_value(_RESUMED, paths[0]), others)
    else:
        begin(arguments)


def begin(arguments: Sequence[str]) -> None:
    """A training from its beginning."""
    config = train_config(arguments)
    check_device(config.device)
    check_unused(config.run_dir)
    parts = _make(config)
    note_omitted(config.task.name)
    provenance = current_versions(parts.robots.envs[0])
    folder = create_run(config)
    with RunLock(folder.path) as lock:
        folder.write_config(config, provenance)
        keep_pairs(folder, config.task)
        print_line(f"training {config.agent.name} on {config.task.name}, {config.total_steps} steps, in {folder.path}")
        training = Training(parts, folder, lock, recording_provenance(config, provenance))
        _run(training, parts, folder, provenance)


def resume(path: str, arguments: Sequence[str]) -> None:
    """Resume a training from its last training state; from its beginning, if it was stopped before the first."""
    folder = open_run_folder(path)
    stored, provenance = read_training(folder.config, controller_named_in(arguments))
    config = resumed_config(arguments, stored)
    check_device(config.device)
    if folder.resources.exists() and config.total_steps == stored.total_steps:
        raise UserError(f"the training in {path} is complete; total_steps= above {stored.total_steps} prolongs it")
    with RunLock(folder.path) as lock:
        states = TrainingStates(folder.training_states)
        state, damaged = states.newest(lambda each: check_logs(folder.path, each["files"]))
        if state is None:
            _check_not_begun(folder, stored)
        for sentence in damaged:
            print_line(f"note: {sentence}; the one before it is used")
        parts = _make(config)
        step = state["step"] if state else 0
        provenance, notes = update_provenance(stored, provenance, config, current_versions(parts.robots.envs[0]), step)
        for note in notes:
            print_line(f"note: {note}")
        # Before anything is changed: this checks that the state fits.
        training = Training(parts, folder, lock, recording_provenance(config, provenance), state)
        if config.total_steps != stored.total_steps:
            keep_test(folder, stored.total_steps)
        rewind(folder, state)
        folder.write_config(config, provenance)
        print_line(f"resuming {path} at step {step} of {config.total_steps}")
        if state is not None:
            state.clear()  # the replay buffer would be held twice to the end
        _run(training, parts, folder, provenance)


def _make(config: TrainConfig) -> Parts:
    robots = make_training_robots(config, count_driving_threads())
    first = robots.envs[0]
    agent = make_agent(config, first)
    cameras = make_cameras(config.record, first)
    live = make_live(config, first, cameras) if config.live else None
    return Parts(config, robots, agent, cameras, live)


def _run(training: Training, parts: Parts, folder: RunFolder, provenance: dict[str, str]) -> None:
    """Train and test; print how to resume where it is stopped."""
    again = f"{python()} -m asddpg.train {RESUME}{shlex.quote(str(folder.path))}{controller_argument(parts.config)}"
    try:
        with ExitStack() as closing:
            closing.callback(parts.robots.close)
            if parts.live is not None:
                closing.callback(parts.live.close)
                print_line(how_to_watch(parts.live.port))
            training.run()
        _finish(parts, folder, provenance, training.seconds)
    except Stopped as stopped:
        print_line(f"stopped after step {training.step}; to resume: {again}", ERR)
        sys.exit(stopped.status)
    except (KeyboardInterrupt, OSError, SystemExit) as error:
        print_line(f"the training can resume from its last training state: {again}", ERR)
        if isinstance(error, OSError):
            error.filename = error.filename or str(folder.path)  # writing to an open file names none
        raise


def _check_not_begun(folder: RunFolder, config: TrainConfig) -> None:
    """Refuse to restart a run that has lost its training states: what it holds would be lost."""
    step = _last_step(folder)
    if folder.resources.exists() or 0 < config.checkpoint_every <= step:
        raise UserError(
            f"the run {folder.path} has reached step {step}, and there is no training state in "
            f"{folder.training_states} to resume from; nothing has been changed"
        )


def _last_step(folder: RunFolder) -> int:
    """Of what is logged; 0 where nothing is, or nothing that can be read, as after a power cut."""
    try:
        rows = read_rows(folder.metrics)
        return int(rows[-1]["step"]) if rows else 0
    except (csv.Error, ValueError, TypeError, KeyError):
        return 0


def _finish(parts: Parts, folder: RunFolder, provenance: dict[str, str], seconds: float) -> None:
    config = parts.config
    tested = test(config, folder, parts.robots.envs[0], parts.agent) if config.test_episodes else {}
    if tested:
        contents = {name: result.as_dict() for name, result in tested.items()}
        write_json(folder.test, {"task": config.task.name, "set": "test", "driver": "actor", **contents, **provenance})
    peak = peak_memory()
    memory = {} if peak is None else {"peak_memory_mb": round(peak, 1)}
    write_json(folder.resources, {"training_seconds": round(seconds, 1), **memory})
    if tested:
        print_line(f"actor alone on {tested['last'].episodes} stored test pairs:\n{table(tested)}")
    print_line(f"{config.total_steps / seconds:.0f} steps/s" + ("" if peak is None else f", peak memory {peak:.0f} MB"))
    arguments = f"run={shlex.quote(str(folder.path))}{controller_argument(config)}"
    print_line(f"the run is in {folder.path}; evaluate it: {python()} -m asddpg.evaluate {arguments}")


def test(
    config: TrainConfig, folder: RunFolder, environment: gymnasium.Env, agent: AsDDPG
) -> dict[str, EvaluationResult]:
    """Figures of the actor alone on the stored test set, for the checkpoints last and best."""
    task = config.task
    navigation_env(environment).set_safety_margin(0.0)  # it was for learning
    pairs = stored_pairs(task.name, "test", task.goal_radius, config.test_episodes, task.robot)
    result = {}
    for name in ("last", "best"):
        weights_file.load_into(folder.checkpoint(name), agent.networks)
        result[name] = evaluate(environment, actor_alone(agent), pairs, config.task.control_timestep)
    return result


if __name__ == "__main__":
    run(main, help_text(__doc__, TrainConfig, GROUPS))
