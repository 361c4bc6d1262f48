"""Opens what run= or agent= names and makes its driver and its environment, for evaluate and play."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import gymnasium

from asddpg.build import (
    action_bounds,
    check_device,
    controller_for,
    make_agent,
    make_environment,
    navigation_env,
)
from asddpg.command_line import BASELINES, train_config
from asddpg.config import ControllerConfig, DriverConfig, RecordEvaluationConfig, TrainConfig
from asddpg.episodes.drivers import FixedDriver, actor_alone, controller_alone, random_actor
from asddpg.episodes.random_streams import stream
from asddpg.errors import UserError
from asddpg.messages import say
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.recorder import Recorder, Selection, every_nth
from asddpg.runs import weights_file
from asddpg.runs.loading import open_trained
from asddpg.runs.provenance import current_versions, environment_hash, recording_provenance
from asddpg.runs.state_files import file_digest
from tasks import ALL_TASKS


@dataclass(frozen=True)
class DriverSetup:
    """A driver and its environment."""

    title: str
    config: TrainConfig  # of the training, or the defaults for a baseline
    environment: gymnasium.Env
    drivers: Mapping[str, FixedDriver]  # of a run, those that driver= may be; of a baseline, itself
    name: str  # of the chosen driver
    evaluation: Path  # file of its metrics; recordings go into folders beside
    checkpoint: Mapping[str, str]  # names of the weights, for recordings
    step: int = 0  # of training, at which the weights were saved

    def recorder(
        self,
        record: RecordEvaluationConfig,
        folder: Path,
        pairs: str,
        log: Callable[[str], None],
        cameras: Cameras | None = None,
    ) -> Recorder:
        """A recorder of episodes along these pairs into a folder, with the pictures of cameras."""
        versions = current_versions(self.environment)
        provenance = recording_provenance(self.config, versions, driver=self.name, pairs=pairs, **self.checkpoint)
        # Outcomes alone select all episodes that end so.
        regularly = every_nth(record.every or (1 if record.outcomes and not record.only else 0))
        selection = Selection(lambda number: regularly(number) or number in record.only, record.outcomes)
        environment = navigation_env(self.environment)
        return Recorder(
            folder, environment, provenance, selection, log, first_step=self.step, counts_steps=False, cameras=cameras
        )


def set_up_driver(config: DriverConfig, verb: str, seed: int) -> DriverSetup:
    """Open a run or a baseline, and make its driver.

    Args:
        config: of the program.
        verb: of the program, for its errors.
        seed: of the random driver.

    Raises:
        UserError: there is no such run or baseline, or options contradict one another.
    """
    check_device(config.device)
    if config.task is not None and config.task not in ALL_TASKS:
        raise UserError(f"there is no task {config.task!r}; there are {', '.join(ALL_TASKS)}")
    if config.agent is not None:
        return _open_baseline(config, seed)
    if config.run is not None:
        return _open_run(config, config.run)
    raise UserError(f"{verb} what? run=<run_dir> or run=pretrained:<name>, or agent={'|'.join(BASELINES)} with task=")


def _open_run(config: DriverConfig, run: str) -> DriverSetup:
    own = "a run brings its own controller; controller.* is for agent=controller"
    if config.controller.gains != ControllerConfig().gains:
        raise UserError(own)
    opened = open_trained(run, config.checkpoint, config.controller.type)
    trained = opened.config
    if config.controller.type not in (ControllerConfig.type, trained.controller.type):
        raise UserError(own)
    trained.device = config.device
    is_other_task = config.task not in (None, trained.task.name)
    trained.task.name = config.task or trained.task.name
    environment = make_environment(trained.task, trained.reward)
    agent = make_agent(trained, environment, opened.weights)
    step = weights_file.load_into(opened.weights, agent.networks)
    drivers = {
        "actor": actor_alone(agent),
        "controller": controller_alone(controller_for(environment, trained.controller)),
    }
    if agent.controller is not None:
        drivers["switch"] = FixedDriver(agent.decide_greedily)
    if config.driver not in drivers:
        raise UserError("driver=switch needs a run with a controller, and this one is DDPG; driver=actor works")
    if not is_other_task and environment_hash(environment) != opened.provenance.get("model_hash"):
        say("note: the scene's model is not the one this run was trained on")
    return DriverSetup(
        title=f"{opened.title} (step {step}), driver {config.driver}",
        config=trained,
        environment=environment,
        drivers=drivers,
        name=config.driver,
        evaluation=opened.evaluation,
        checkpoint={"checkpoint": f"{opened.title}, step {step}", "weights_sha256": file_digest(opened.weights)[:16]},
        step=step,
    )


def _open_baseline(config: DriverConfig, seed: int) -> DriverSetup:
    if config.agent not in BASELINES:
        raise UserError(
            f"there is no baseline {config.agent!r}; there are {', '.join(BASELINES)}; a trained agent is run="
        )
    if config.run is not None or config.task is None:
        raise UserError(f"agent={config.agent} needs task= and no run=, such as task={ALL_TASKS[-1]}")
    if (config.driver, config.checkpoint) != ("actor", "last"):
        raise UserError("driver= and checkpoint= belong to run=; a baseline has neither")
    defaults = train_config([f"task={config.task}"])
    environment = make_environment(defaults.task, defaults.reward)
    if config.agent == "controller":
        driver = controller_alone(controller_for(environment, config.controller))
    else:
        driver = random_actor(*action_bounds(environment), stream(seed, "exploration"))
    return DriverSetup(
        title=f"{config.agent} on {config.task}",
        config=defaults,
        environment=environment,
        drivers={config.agent: driver},
        name=config.agent,
        evaluation=Path("evaluation.json"),
        checkpoint={"checkpoint": "none"},
    )
