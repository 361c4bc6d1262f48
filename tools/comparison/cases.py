"""What is compared: drivers on tasks, each with the options that it heeds, and the name of its file."""

import re
import sys
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from asddpg.command_line import BASELINES
from asddpg.config import ControllerConfig, EvaluateConfig, PlannerConfig
from asddpg.drivers.baselines import PLANNERS, OwnDriver
from asddpg.drivers.driver_setup import DriverSetup, set_up_driver
from asddpg.errors import UserError
from asddpg.runs.loading import PREFIX, open_trained
from asddpg.runs.provenance import environment_hash
from asddpg.runs.state_files import file_digest
from tasks.evaluation_pairs import stored_pairs
from tasks.room_geometry.held_out import Pair
from tasks.rooms.reading import short_name
from tools.experiments.runs import digest

LED = "+waypoints"  # after a run: a planner leads it
SEED = 0  # of random actions
MOST_ROOMS = 1000  # of one name
_SEVERAL = re.compile(r"([a-z_]+):([0-9]{1,9})-([0-9]{1,9})")


@dataclass(frozen=True)
class Case:
    """A driver, as the user names it, on the first test pairs of a task, of a room, or of each of several rooms."""

    driver: str
    task: str
    episodes: int
    controller: ControllerConfig = field(default_factory=ControllerConfig)
    planner: PlannerConfig = field(default_factory=PlannerConfig)
    robot: str | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The options that the driver heeds; UserError where there is no such driver."""
        agent, run = _agent_and_run(self.driver)
        options: dict[str, Any] = {}
        if run is None and agent in ("controller", "waypoints"):
            options["controller"] = asdict(self.controller)
        if agent in PLANNERS:
            options["planner"] = {"map": self.planner.map} if agent == "move_base" else asdict(self.planner)
        return options

    @property
    def rooms(self) -> list[str]:
        """The task; of generated rooms such as cylinders:0-49 each one."""
        return expand_rooms(self.task)

    def set_up(self, folder: Path, room: str | None = None) -> DriverSetup:
        """Make the driver and its environment, in a room of the case's or in its first.

        Raises:
            UserError: there is no such driver, or it does not fit the task.
        """
        agent, run = _agent_and_run(self.driver)
        controller = self.controller if run is None else _controller_of_run(run, self.controller)
        config = EvaluateConfig(
            run=run,
            agent=agent,
            task=room or self.rooms[0],
            controller=controller,
            planner=self.planner,
            robot=self.robot,
            out=str(folder),
        )
        return set_up_driver(config, "evaluate", SEED)

    def pairs(self, setup: DriverSetup, room: str | None = None) -> tuple[Pair, ...]:
        """The pairs to drive in a room, or in the first."""
        task = setup.config.task
        return stored_pairs(room or self.rooms[0], "test", task.goal_radius, self.episodes, task.robot)

    def conditions(self, setup: DriverSetup) -> dict[str, Any]:
        """All that decides what the episodes are, but for the versions of the packages."""
        return {
            "driver": self.driver,
            "options": self.options,
            "weights": setup.checkpoint.get("weights_sha256", ""),
            "code": _identify_code(self.driver, setup),
            "scene": environment_hash(setup.environment),
            "task": asdict(setup.config.task),
            "reward": asdict(setup.config.reward),
            **({"rooms": self.task} if len(self.rooms) > 1 else {}),
            "episodes": self.episodes,
            "pairs": digest({"pairs": [(pair.start, pair.goal, pair.shortest_path) for pair in self.pairs(setup)]}),
        }

    def path(self, folder: Path, setup: DriverSetup) -> Path:
        """The file of its episodes; other conditions have another."""
        name = re.sub(r"[^A-Za-z0-9.]+", "_", self.driver).strip("_.")[-60:]
        return folder / f"{name}_{short_name(self.task)}_{digest(self.conditions(setup))}.json"


def expand_rooms(task: str) -> list[str]:
    """`cylinders:3-5` → cylinders:3, cylinders:4, cylinders:5; any other name alone, and more than MOST_ROOMS."""
    match = _SEVERAL.fullmatch(task)
    numbers = range(int(match[2]), int(match[3]) + 1) if match else ()
    if match is None or not 0 < len(numbers) <= MOST_ROOMS:
        return [task]
    return [f"{match[1]}:{number}" for number in numbers]


def _agent_and_run(driver: str) -> tuple[str | None, str | None]:
    """What agent= and run= of `python -m asddpg.evaluate` are for a driver; UserError where there is no such driver."""
    led = driver.removesuffix(LED)
    if driver in BASELINES:
        return driver, None
    if _is_run(driver) and not driver.startswith(PREFIX):
        return None, driver
    if led != driver and _is_run(led):
        return "waypoints", led
    if _is_run(driver):
        return None, driver
    if ":" in driver and led == driver:
        return driver, None
    raise UserError(
        f"there is no driver {driver!r}; there are {', '.join(BASELINES)}, {PREFIX}<name>, the folder of a run, either "
        f"with {LED} behind it, and your own as package.module:Factory"
    )


def _is_run(name: str) -> bool:
    return name.startswith(PREFIX) or Path(name).is_dir()


def _controller_of_run(run: str, controller: ControllerConfig) -> ControllerConfig:
    """A run brings its controller along, but one of the user's own the user names."""
    named = open_trained(run, controller=None).config.controller.type == controller.type
    return ControllerConfig(type=controller.type) if named else ControllerConfig()


def _identify_code(driver: str, setup: DriverSetup) -> str:
    """Of a user's own driver the digest of its file, and what it says of itself; else nothing."""
    own = setup.drivers[setup.name]
    if not isinstance(own, OwnDriver):
        return ""
    file = getattr(sys.modules[driver.partition(":")[0]], "__file__", None)
    return f"{file_digest(Path(file)) if file else ''} {own.identity}"
