"""Train: `python -m asddpg.train task=nav_complex agent=asddpg reward=sparse network=fc3x256 seed=0`."""

import csv
import dataclasses
import platform
import resource
import sys
import time
from collections.abc import Sequence
from importlib import metadata

import gymnasium
import numpy as np

from asddpg import checkpoint
from asddpg.agent import AsDDPG
from asddpg.build import check_device, make_agent, make_cameras, make_environment, prepare_torch
from asddpg.compose import GROUPS, option_names, train_config
from asddpg.config import TrainConfig
from asddpg.drivers import actor_alone
from asddpg.evaluation import Figures, evaluate, table
from asddpg.loop import run_episode
from asddpg.observers.metrics_log import MetricsLog
from asddpg.observers.progress import ProgressBar
from asddpg.observers.step_log import StepLog
from asddpg.program import python, run
from asddpg.recording.cameras import Cameras
from asddpg.recording.how_to_open import how_to_watch
from asddpg.recording.live import LiveView
from asddpg.recording.recorder import Provenance, Recorder, Selection, each
from asddpg.run_folder import RunFolder, config_text, new_run_folder, write_json
from asddpg.streams import stream
from asddpg.types import Observer
from tasks.fresh_pairs import stored_pairs
from tasks.gymnasium_adapter import NavigationEnv
from tasks.scenes import model_hash

PACKAGES = ("asddpg", "mujoco", "dm-control", "torch", "numpy", "gymnasium")


def main(words: Sequence[str]) -> None:
    """Compose, train, test, say where the run lies."""
    config = train_config(words)
    check_device(config.device)
    folder = new_run_folder(config)
    prepare_torch()
    environment = make_environment(config.task, config.reward)
    agent = make_agent(config, environment)
    cameras = make_cameras(config.record, watched(environment))
    made_with = versions() | {"model_hash": hash_of(environment)}
    live = LiveView(watched(environment), config.port, config.speed) if config.live else None
    folder.create()
    settings = config_text(dataclasses.asdict(config), made_with)
    folder.config.write_text(settings, encoding="utf-8")
    print(f"training {config.agent.name} on {config.task.name}, {config.total_steps} steps, in {folder.path}")
    if live is not None:
        print(how_to_watch(live.port))
    begun = time.perf_counter()
    try:
        provenance = provenance_of(config, settings, made_with)
        Training(config, folder, environment, agent, provenance, cameras, live).run()
    except KeyboardInterrupt:
        print(f"the run so far, with its last checkpoint, lies in {folder.path}", file=sys.stderr)
        raise
    finally:
        if live is not None:
            live.close()
    seconds = time.perf_counter() - begun
    if config.test_episodes:
        tested = test(config, folder, environment, agent)
        contents = {name: figures.as_dict() for name, figures in tested.items()}
        write_json(folder.test, {"task": config.task.name, "set": "test", "driver": "actor", **contents, **made_with})
        print(f"actor alone on {config.test_episodes} stored test pairs:\n{table(tested)}")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024  # kB on Linux
    write_json(folder.resources, {"training_seconds": round(seconds, 1), "peak_memory_mb": round(peak, 1)})
    print(f"{config.total_steps / seconds:.0f} steps/s, peak memory {peak:.0f} MB")
    print(f"the run lies in {folder.path}; evaluate it: {python()} -m asddpg.evaluate run={folder.path}")


class Training:
    """Episodes until the steps are used up, validation and snapshot now and then, checkpoints `last` and `best`."""

    def __init__(
        self,
        config: TrainConfig,
        folder: RunFolder,
        environment: gymnasium.Env,
        agent: AsDDPG,
        provenance: Provenance,
        cameras: Cameras | None,
        live: LiveView | None,
    ) -> None:
        self._config, self._folder = config, folder
        self._provenance, self._cameras, self._live = provenance, cameras, live
        self._environment, self._agent = environment, agent
        # A second one: validating must not disturb the episode in progress or the stream of its goals.
        self._validation_environment = make_environment(config.task, config.reward)
        self._best = (-1.0, -np.inf)

    def run(self) -> None:
        """Train."""
        from torch.utils.tensorboard import SummaryWriter  # slow to import: not for those who only ask for help

        config = self._config
        self._environment.reset(seed=int(stream(config.seed, "start_goal").integers(2**31)))
        self._tensorboard = SummaryWriter(str(self._folder.tensorboard))
        log = MetricsLog(self._folder.metrics, self._folder.timing, self._tensorboard)
        step_log = StepLog(self._folder.steps)
        self._bar = ProgressBar(config.total_steps)
        recorder = self._recorder()
        observers: list[Observer] = [log, step_log, self._bar, recorder]
        if self._live is not None:
            observers.append(self._live)
        steps, validated = 0, 0
        try:
            while steps < config.total_steps:
                rest = config.total_steps - steps
                episode = run_episode(self._environment, self._agent, observers, max_steps=rest)
                steps += episode.steps
                every = config.validation.every
                if every and steps // every > validated:
                    validated = steps // every
                    self._validate(steps)
        finally:
            recorder.close()
            self._bar.close()
            log.close()
            self._tensorboard.close()
            if steps:
                checkpoint.save(self._folder.checkpoint("last"), self._agent, steps)
            step_log.close()
        if not self._folder.checkpoint("best").exists():
            checkpoint.save(self._folder.checkpoint("best"), self._agent, steps)

    def _recorder(self) -> Recorder:
        wanted = self._config.record
        selection = Selection(each(wanted.every), keep=wanted.keep)
        environment = watched(self._environment)
        folder = self._folder.episodes
        return Recorder(folder, environment, self._provenance, selection, self._bar.say, cameras=self._cameras)

    def _validate(self, steps: int) -> None:
        config = self._config
        pairs = stored_pairs(config.task.name, "validation", config.task.goal_radius)[: config.validation.episodes]
        figures = evaluate(self._validation_environment, actor_alone(self._agent), pairs, config.task.control_timestep)
        reach, crash, metric = (figures.reach_rate.value, figures.crash_rate.value, figures.metric.value)
        assert reach is not None
        assert crash is not None
        assert metric is not None
        self._write_validation(steps, reach, crash, metric)
        self._bar.say(
            f"step {steps}: actor alone reaches {reach:.2f}, crashes {crash:.2f} ({len(pairs)} validation pairs)"
        )
        checkpoint.save(self._folder.checkpoint("last"), self._agent, steps)
        if config.validation.snapshots:
            checkpoint.save_snapshot(self._folder.snapshot(steps), self._agent, steps)
        if (reach, metric) > self._best:
            self._best = (reach, metric)
            checkpoint.save(self._folder.checkpoint("best"), self._agent, steps)

    def _write_validation(self, steps: int, reach: float, crash: float, metric: float) -> None:
        row = {"step": steps, "reach_rate": reach, "crash_rate": crash, "metric": metric}
        is_new = not self._folder.validation.exists()
        with self._folder.validation.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, row)
            if is_new:
                writer.writeheader()
            writer.writerow(row)
        for name in ("reach_rate", "crash_rate", "metric"):
            self._tensorboard.add_scalar(f"validation/{name}", row[name], steps)


def test(config: TrainConfig, folder: RunFolder, environment: gymnasium.Env, agent: AsDDPG) -> dict[str, Figures]:
    """Figures of the actor alone on the stored test set, for the checkpoints last and best."""
    pairs = stored_pairs(config.task.name, "test", config.task.goal_radius)[: config.test_episodes]
    figures = {}
    for name in ("last", "best"):
        checkpoint.load(folder.checkpoint(name), agent)
        figures[name] = evaluate(environment, actor_alone(agent), pairs, config.task.control_timestep)
    return figures


def versions() -> dict[str, str]:
    """Versions of what makes a result."""
    return {"python": platform.python_version(), **{name: metadata.version(name) for name in PACKAGES}}


def provenance_of(config: TrainConfig, settings: str, made_with: dict[str, str], **more: str) -> Provenance:
    """What a recording made with a configuration, as YAML, is of."""
    facts = {"task": config.task.name, "agent": config.agent.name, "seed": str(config.seed)}
    return Provenance(settings, {**facts, **more, **made_with})


def watched(environment: gymnasium.Env) -> NavigationEnv:
    """The environment below its wrappers, for observers to read."""
    inner = environment.unwrapped
    assert isinstance(inner, NavigationEnv)
    return inner


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
