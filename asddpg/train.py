"""Train: `python -m asddpg.train task=nav_complex agent=asddpg reward=sparse network=fc3x256 seed=0`.

A training that was stopped goes on with `python -m asddpg.train resume=<run_dir>`; total_steps= may be raised with it.
"""

import csv
import dataclasses
import platform
import resource
import shlex
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from importlib import metadata

import gymnasium

from asddpg.algorithm.agent import AsDDPG
from asddpg.build import check_device, make_agent, make_cameras, make_environment, make_live, prepare_torch, watched
from asddpg.command_line import GROUPS, option_names, resumed_config, train_config
from asddpg.config import TrainConfig
from asddpg.episodes.drivers import actor_alone
from asddpg.episodes.evaluation import Figures, evaluate, table
from asddpg.errors import UserError
from asddpg.observers.metrics_log import rows_of
from asddpg.program import python, run
from asddpg.recording.how_to_open import how_to_watch
from asddpg.recording.recorder import Provenance
from asddpg.runs import weights_file
from asddpg.runs.append_only_logs import check as check_files
from asddpg.runs.checkpoints import TrainingStates
from asddpg.runs.lock import RunLock
from asddpg.runs.rewind import set_end_aside, take_back
from asddpg.runs.run_folder import (
    PROLONGED,
    RESUMED,
    RunFolder,
    config_text,
    new_run_folder,
    open_run_folder,
    read_training,
    write_json,
    write_text,
)
from asddpg.runs.safe_loading import controller_named_in, naming
from asddpg.runs.signals import Stopped
from asddpg.training import Parts, Training
from tasks.evaluation_pairs import stored_pairs
from tasks.scene.loading import model_hash

RESUME = "resume="
PACKAGES = ("asddpg", "mujoco", "dm-control", "torch", "numpy", "gymnasium")


def main(words: Sequence[str]) -> None:
    """Begin a training or go on with one, then test."""
    to_resume = [word for word in words if word.startswith(RESUME)]
    if len(to_resume) > 1:
        raise UserError(f"one run at a time can be resumed, not {len(to_resume)}")
    if to_resume:
        resume(to_resume[0].removeprefix(RESUME), [word for word in words if word not in to_resume])
    else:
        begin(words)


def begin(words: Sequence[str]) -> None:
    """A training from its beginning."""
    config = train_config(words)
    check_device(config.device)
    folder = new_run_folder(config)
    parts = _make(config)
    made_with = made_now(parts.environment)
    folder.create()
    settings = config_text(dataclasses.asdict(config), made_with)
    with RunLock(folder.path) as lock:
        write_text(folder.config, settings)
        print(f"training {config.agent.name} on {config.task.name}, {config.total_steps} steps, in {folder.path}")
        training = Training(parts, folder, lock, provenance_of(config, settings, made_with))
        _run(training, parts, folder, made_with)


def resume(path: str, words: Sequence[str]) -> None:
    """A training from its last checkpoint; from its beginning, if it was stopped before the first."""
    folder = open_run_folder(path)
    stored, made_with = read_training(folder.config, controller_named_in(words))
    config = resumed_config(words, stored)
    check_device(config.device)
    if folder.resources.exists() and config.total_steps == stored.total_steps:
        raise UserError(
            f"the training in {path} has come to its end; total_steps= above {stored.total_steps} prolongs it"
        )
    with RunLock(folder.path) as lock:
        states = TrainingStates(folder.training_states)
        state, damaged = states.newest(lambda each: check_files(folder.path, each["files"]))
        if state is None:
            _check_not_begun(folder, stored)
        for sentence in damaged:
            print(f"note: {sentence}; the one before it is taken")
        parts = _make(config)
        step = state["step"] if state else 0
        made_with = _made_further(stored, made_with, config, made_now(parts.environment), step)
        settings = config_text(dataclasses.asdict(config), made_with)
        # First of all, and before anything is changed: it sees whether the checkpoint fits.
        training = Training(parts, folder, lock, provenance_of(config, settings, made_with), state)
        if config.total_steps != stored.total_steps:
            set_end_aside(folder, stored.total_steps)
        take_back(folder, state)
        write_text(folder.config, settings)
        print(f"going on with {path} at step {step} of {config.total_steps}")
        if state is not None:
            state.clear()  # the replay buffer would be held twice to the end
        _run(training, parts, folder, made_with)


def _made_further(
    stored: TrainConfig, made_with: dict[str, str], config: TrainConfig, now: dict[str, str], step: int
) -> dict[str, str]:
    """What a run that goes on was made with: what it began with, and what has changed since."""
    changes = [f"{name} {value}" for name, value in now.items() if made_with.get(name) != value]
    if changes:
        made_with = _noted(made_with, RESUMED, f"at step {step} with {', '.join(changes)}")
        print(f"note: it goes on with {', '.join(changes)}, and so not as the unbroken one would have")
    if config.total_steps != stored.total_steps:
        made_with = _noted(made_with, PROLONGED, f"from {stored.total_steps} to {config.total_steps} at step {step}")
        print("note: what changes over a training (noise, withdrawal, annealing) spans the new length from here on")
    return made_with


def _noted(made_with: dict[str, str], name: str, what: str) -> dict[str, str]:
    before = made_with.get(name, "")
    return made_with | {name: before if what in before else f"{before}; {what}".removeprefix("; ")}


def _make(config: TrainConfig) -> Parts:
    prepare_torch()
    environment = make_environment(config.task, config.reward)
    agent = make_agent(config, environment)
    cameras = make_cameras(config.record, watched(environment))
    live = make_live(config, watched(environment), cameras) if config.live else None
    return Parts(config, environment, agent, cameras, live)


def _run(training: Training, parts: Parts, folder: RunFolder, made_with: dict[str, str]) -> None:
    """Train, test, and say how to go on where it is stopped."""
    again = f"{python()} -m asddpg.train {RESUME}{shlex.quote(str(folder.path))}{naming(parts.config)}"
    try:
        with ExitStack() as closing:
            if parts.live is not None:
                closing.callback(parts.live.close)
                print(how_to_watch(parts.live.port))
            training.run()
        _finish(parts, folder, made_with, training.seconds)
    except Stopped as stopped:
        print(f"stopped after step {training.step}; to go on: {again}", file=sys.stderr)
        sys.exit(stopped.status)
    except (KeyboardInterrupt, OSError, SystemExit) as error:
        print(f"the training can go on from its last checkpoint: {again}", file=sys.stderr)
        if isinstance(error, OSError):
            error.filename = error.filename or str(folder.path)  # writing to an open file names none
        raise


def _check_not_begun(folder: RunFolder, config: TrainConfig) -> None:
    """Without a checkpoint a run begins anew, but only where there never was one: what it holds would be lost."""
    step = _last_step(folder)
    if folder.resources.exists() or 0 < config.checkpoint_every <= step:
        raise UserError(
            f"the run {folder.path} has come to step {step}, and there is no checkpoint in {folder.training_states} "
            "to go on from; nothing has been changed"
        )


def _last_step(folder: RunFolder) -> int:
    """Of what is logged; 0 where nothing is, or nothing that can be read, as after a power cut."""
    try:
        rows = rows_of(folder.metrics)
        return int(rows[-1]["step"]) if rows else 0
    except (csv.Error, ValueError, TypeError, KeyError):
        return 0


def _finish(parts: Parts, folder: RunFolder, made_with: dict[str, str], seconds: float) -> None:
    config = parts.config
    if config.test_episodes:
        tested = test(config, folder, parts.environment, parts.agent)
        contents = {name: figures.as_dict() for name, figures in tested.items()}
        write_json(folder.test, {"task": config.task.name, "set": "test", "driver": "actor", **contents, **made_with})
        print(f"actor alone on {config.test_episodes} stored test pairs:\n{table(tested)}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # kB on Linux
    write_json(folder.resources, {"training_seconds": round(seconds, 1), "peak_memory_mb": round(peak, 1)})
    print(f"{config.total_steps / seconds:.0f} steps/s, peak memory {peak:.0f} MB")
    where = shlex.quote(str(folder.path))
    print(f"the run lies in {folder.path}; evaluate it: {python()} -m asddpg.evaluate run={where}{naming(config)}")


def test(config: TrainConfig, folder: RunFolder, environment: gymnasium.Env, agent: AsDDPG) -> dict[str, Figures]:
    """Figures of the actor alone on the stored test set, for the checkpoints last and best."""
    pairs = stored_pairs(config.task.name, "test", config.task.goal_radius)[: config.test_episodes]
    figures = {}
    for name in ("last", "best"):
        weights_file.load(folder.checkpoint(name), agent)
        figures[name] = evaluate(environment, actor_alone(agent), pairs, config.task.control_timestep)
    return figures


def versions() -> dict[str, str]:
    """Versions of what makes a result."""
    return {"python": platform.python_version(), **{name: metadata.version(name) for name in PACKAGES}}


def made_now(environment: gymnasium.Env) -> dict[str, str]:
    """What a run is made with that begins, or goes on, now: versions, and the hash of its scene."""
    return versions() | {"model_hash": hash_of(environment)}


def provenance_of(config: TrainConfig, settings: str, made_with: dict[str, str], **more: str) -> Provenance:
    """What a recording made with a configuration, as YAML, is of."""
    facts = {"task": config.task.name, "agent": config.agent.name, "seed": str(config.seed)}
    return Provenance(settings, {**facts, **more, **made_with})


def hash_of(environment: gymnasium.Env) -> str:
    """Hash of an environment's compiled scene."""
    return model_hash(environment.get_wrapper_attr("physics").model.ptr)


def usage() -> str:
    """What --help prints."""
    from omegaconf import OmegaConf

    groups = "\n".join(f"  {name}={'|'.join(choices)}" for name, choices in GROUPS.items())
    config = OmegaConf.structured(TrainConfig)
    options = "\n".join(f"  {name}={OmegaConf.select(config, name)}" for name in option_names(config))
    return f"{__doc__}\n\nOne of several:\n{groups}\n\nOptions and their defaults:\n{options}"


if __name__ == "__main__":
    run(main, usage())
