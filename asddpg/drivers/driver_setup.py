"""Opens what run= or agent= names and makes its driver and its environment, for evaluate and play."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import gymnasium

from asddpg.algorithm.agent import AsDDPG
from asddpg.atomic_write import claim_folder
from asddpg.build import (
    check_device,
    controller_for,
    make_agent,
    make_environment,
    navigation_env,
    note_omitted,
)
from asddpg.command_line import BASELINES, train_config
from asddpg.config import ControllerConfig, DrivingConfig, PlayConfig, RecordEvaluationConfig, TaskConfig, TrainConfig
from asddpg.drivers.baselines import PRESET_SPEED, MakeRobot, lead_by_waypoints, make_baseline
from asddpg.drivers.other_laser import with_other_laser
from asddpg.drivers.simulated_robot import with_room_map
from asddpg.episodes.drivers import FixedDriver, actor_alone, controller_alone, with_values
from asddpg.episodes.protocols import Agent
from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.planning.navigation_view import PlanningDriver
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.recorder import Recorder, Selection, every_nth
from asddpg.recording.samples import ReadNavigation
from asddpg.runs import weights_file
from asddpg.runs.loading import open_trained
from asddpg.runs.provenance import current_versions, environment_hash, recording_provenance
from asddpg.runs.state_files import file_digest
from tasks import ALL_TASKS
from tasks.navigation import SPEEDS, with_robot
from tasks.registry import find_task
from tasks.robots.names import full_robot_name
from tasks.rooms.reading import full_name, is_room


@dataclass(frozen=True)
class Setting:
    """What a program changes of the task, and of what the robot knows.

    Attributes:
        prepare_task: changes the task's options in place.
        make_robot: what a planner or a driver of one's own reads.
    """

    prepare_task: Callable[[TaskConfig], None] = lambda _: None
    make_robot: MakeRobot = with_room_map


_EVALUATION = Setting()


@dataclass(frozen=True)
class DriverSetup:
    """A driver and its environment."""

    title: str
    config: TrainConfig  # of the training, or the defaults for a baseline
    environment: gymnasium.Env
    drivers: Mapping[str, Agent]  # of a run, those that driver= may be; of a baseline, itself
    name: str  # of the chosen driver
    out: Path  # folder for its results and recordings
    checkpoint: Mapping[str, str]  # names of the weights, for recordings
    step: int = 0  # of training, at which the weights were saved

    def recorder(
        self,
        record: RecordEvaluationConfig,
        folder_name: str,
        pairs: str,
        log: Callable[[str], None],
        cameras: Cameras | None = None,
        read_navigation: ReadNavigation | None = None,
    ) -> Recorder:
        """A recorder of episodes along these pairs, with pictures and plans, into a folder of its own."""
        folder = self.out / folder_name
        owns_folder = is_recorded(record)
        folder = claim_folder(folder) if owns_folder else folder
        versions = current_versions(self.environment)
        provenance = recording_provenance(self.config, versions, driver=self.name, pairs=pairs, **self.checkpoint)
        # Outcomes alone select all episodes that end so.
        regularly = every_nth(record.every or (1 if record.outcomes and not record.only else 0))
        selection = Selection(lambda number: regularly(number) or number in record.only, record.outcomes)
        environment = navigation_env(self.environment)
        return Recorder(
            folder,
            environment,
            provenance,
            selection,
            log,
            first_step=self.step,
            cameras=cameras,
            owns_folder=owns_folder,
            read_navigation=read_navigation,
        )

    @property
    def plans(self) -> bool:
        """Whether a driver has a global planner, whose map and path can be shown."""
        return any(isinstance(driver, PlanningDriver) for driver in self.drivers.values())


def set_up_driver(config: DrivingConfig, verb: str, seed: int, setting: Setting = _EVALUATION) -> DriverSetup:
    """Open a run or a baseline, and make its driver.

    Args:
        config: of the program.
        verb: of the program, for its errors.
        seed: of the random driver.
        setting: of the program.

    Raises:
        UserError: there is no such run or baseline, or options contradict one another.
    """
    check_device(config.device)
    if config.task is not None:
        find_task(config.task)
        config = replace(config, task=full_name(config.task) if is_room(config.task) else config.task)
    if config.agent == "waypoints" and config.run is not None:
        setup = _lead_run(config, config.run, setting)
    elif config.agent is not None:
        setup = _open_baseline(config, seed, setting)
    elif config.run is not None:
        setup = _open_run(config, config.run, setting)
    else:
        what = f"run=<run_dir> or run=pretrained:<name>, or agent={'|'.join(BASELINES)} with task="
        raise UserError(f"{verb} what? {what}")
    note_omitted(setup.config.task.name)
    if config.out is not None:
        setup = replace(setup, out=Path(config.out))
        setup.out.mkdir(parents=True, exist_ok=True)
    if (verb == "evaluate" or is_recorded(config.record)) and not os.access(setup.out, os.W_OK):
        raise UserError(f"the folder {setup.out} cannot be written; out=<folder> puts results and recordings elsewhere")
    return setup


def is_recorded(record: RecordEvaluationConfig) -> bool:
    """Whether any episode may be recorded."""
    return bool(record.every or record.only or record.outcomes)


def _open_run(config: DrivingConfig, run: str, setting: Setting) -> DriverSetup:
    own = "a run brings its own controller; controller.* is for agent=controller"
    if config.controller.gains != ControllerConfig().gains:
        raise UserError(own)
    opened = open_trained(run, config.checkpoint, config.controller.type)
    trained = opened.config
    if config.controller.type not in (ControllerConfig.type, trained.controller.type):
        raise UserError(own)
    trained.device, trained.safety_margin = config.device, 0.0  # the margin is for learning
    is_other_scene = config.task not in (None, trained.task.name)
    trained.task.name = config.task or trained.task.name
    own_task = trained.task
    if config.robot is not None:
        is_other_scene |= full_robot_name(config.robot) != own_task.robot
        trained.task = with_robot(own_task, config.robot)
    setting.prepare_task(trained.task)
    environment = make_environment(trained.task, trained.reward)
    # Of a robot that is slower than the run's own, the environment cuts the policy's actions.
    is_slower = any(getattr(trained.task, speed) != getattr(own_task, speed) for speed in SPEEDS)
    own_environment = make_environment(own_task, trained.reward) if is_slower else environment
    agent = make_agent(trained, own_environment, opened.weights)
    step, digest = _load(opened.weights, agent)
    drivers = {
        "actor": actor_alone(agent),
        "controller": controller_alone(controller_for(environment, trained.controller)),
    }
    if agent.controller is not None and (is_recorded(config.record) or isinstance(config, PlayConfig)):
        drivers = {name: with_values(driver, agent.switch_values) for name, driver in drivers.items()}
    if agent.controller is not None:
        drivers["switch"] = FixedDriver(agent.decide_greedily)
    if config.driver not in drivers:
        raise UserError("driver=switch needs a run with a controller, and this one is DDPG; driver=actor works")
    if not is_other_scene and environment_hash(environment) != opened.provenance.get("model_hash"):
        print_line("note: the scene's model is not the one this run was trained on")
    task, laser = trained.task, config.laser.apply(trained.task.laser)
    is_other_laser = laser != task.laser
    if is_other_laser:
        lasers = task.num_scans, task.laser, laser
        drivers = {name: with_other_laser(driver, *lasers) for name, driver in drivers.items()}
        task.laser = laser
        environment = make_environment(task, trained.reward)
    return DriverSetup(
        title=f"{opened.title} (step {step}), driver {config.driver}{', another laser' if is_other_laser else ''}",
        config=trained,
        environment=environment,
        drivers=drivers,
        name=config.driver,
        out=opened.out,
        checkpoint={"checkpoint": f"{opened.title}, step {step}", "weights_sha256": digest[:16]},
        step=step,
    )


def _load(weights: Path, agent: AsDDPG) -> tuple[int, str]:
    """Load weights; their training step and the digest of their file, which a training may replace meanwhile."""
    digest = file_digest(weights) if weights.is_file() else ""
    step = weights_file.load_into(weights, agent.networks)
    return (step, digest) if file_digest(weights) == digest else _load(weights, agent)


def _lead_run(config: DrivingConfig, run: str, setting: Setting) -> DriverSetup:
    """A run whose drivers get a planner's waypoints as their goals."""
    setup = _open_run(config, run, setting)
    robot = setting.make_robot(navigation_env(setup.environment))
    drivers = {name: lead_by_waypoints(driver, robot, config.planner) for name, driver in setup.drivers.items()}
    return replace(setup, title=f"{setup.title}, led by waypoints", drivers=drivers)


def _open_baseline(config: DrivingConfig, seed: int, setting: Setting) -> DriverSetup:
    assert config.agent is not None
    if config.agent not in BASELINES and ":" not in config.agent:
        raise UserError(
            f"there is no baseline {config.agent!r}; there are {', '.join(BASELINES)}, or your own as "
            "package.module:Factory; a trained agent is run="
        )
    if config.run is not None or config.task is None:
        raise UserError(f"agent={config.agent} needs task= and no run=, such as task={ALL_TASKS[-1]}")
    if (config.driver, config.checkpoint) != ("actor", "last"):
        raise UserError("driver= and checkpoint= belong to run=; a baseline has neither")
    defaults = train_config([f"task={config.task}", *([f"robot={config.robot}"] if config.robot else [])])
    if config.agent not in PRESET_SPEED:
        defaults.task.min_linear_velocity = 0.0  # a preset's least speed is for policies: who plans may stop and turn
    setting.prepare_task(defaults.task)
    defaults.task.laser = config.laser.apply(defaults.task.laser)
    environment = make_environment(defaults.task, defaults.reward)
    return DriverSetup(
        title=f"{config.agent} on {config.task}",
        config=defaults,
        environment=environment,
        drivers={config.agent: make_baseline(config, environment, seed, setting.make_robot)},
        name=config.agent,
        out=Path(),
        checkpoint={"checkpoint": "none"},
    )
