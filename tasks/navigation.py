"""Drive to a goal without touching anything: the task of the paper."""

import math
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import dm_env
import numpy as np
from dm_control.rl import control
from dm_env import specs

from tasks import constants
from tasks.errors import TaskError
from tasks.generator_state import RandomSource, make_generator
from tasks.laser import Laser, LaserConfig
from tasks.options import NOT_NEGATIVE, POSITIVE, Range, between, build_options, check_options, option
from tasks.physics import FloatArray, Physics, Pose, Readings
from tasks.rewards import Outcome, Reward
from tasks.robots.names import PIONEER, ROBOTS, full_robot_name
from tasks.robots.opening import open_robot
from tasks.room_geometry.start_goal import PairRule
from tasks.rooms.changing_room import MIXTURE, ChangingRoom
from tasks.variation import NO_VARIATION, Variation, VariationConfig, VariedBody

# Bounds of the observation, wide enough for anything the robot does. The wheels' limit gives 1.2 m/s and 7.3 rad/s.
VELOCITY_BOUNDS = np.array([3.0, 15.0])  # m/s, rad/s
GOAL_BOUND = 50.0  # m


def _is_control_timestep(seconds: float) -> bool:
    steps = seconds / constants.PHYSICS_TIMESTEP
    return 0.01 <= seconds <= 2.0 and abs(steps - round(steps)) < 1e-8


CONTROL_TIMESTEPS = Range(_is_control_timestep, "from 0.01 to 2 s and a multiple of the physics step, 5 ms")
GOAL_RADII = Range(lambda radius: radius == 0.0 or 0.1 <= radius <= 2.0, "0, or from 0.1 to 2 m")
_MAX_STARTS = 100
AnyConfig = TypeVar("AnyConfig", bound="NavigationConfig")
SPEEDS = ("max_linear_velocity", "max_angular_velocity")
FOLLOW = 0.0  # a largest speed that is the robot's
UP_TO_THE_ROBOTS = Range(lambda value: value >= 0.0, "above 0 and up to the robot's limit; 0 takes that of the robot")


@dataclass
class NavigationConfig:
    """Every constant of the task; the defaults are the paper's."""

    control_timestep: float = option(constants.CONTROL_TIMESTEP, "Seconds between two commands.", CONTROL_TIMESTEPS)
    goal_radius: float = option(
        constants.GOAL_RADIUS, "Metres from the goal that count as reached; 0 ends no episode there.", GOAL_RADII
    )
    time_limit_steps: int = option(constants.TIME_LIMIT_STEPS, "Control steps until an episode times out.", POSITIVE)
    min_linear_velocity: float = option(
        0.0, "Smallest forward speed, m/s; task= sets 0.05 but in nav_office.", NOT_NEGATIVE
    )
    max_linear_velocity: float = option(FOLLOW, "Largest forward speed, m/s; of the Pioneer 0.5.", UP_TO_THE_ROBOTS)
    max_angular_velocity: float = option(FOLLOW, "Largest turn rate, rad/s; of the Pioneer π/3.", UP_TO_THE_ROBOTS)
    robot: str = option(PIONEER, f"The robot: {ROBOTS}. robot= sets it, and its limits.")
    goal_range: float = option(
        GOAL_BOUND, "Metres; a goal farther away is observed at this distance.", between(0.5, GOAL_BOUND, " m")
    )
    rooms: list[str] = option(
        [*MIXTURE],
        "Of task=nav_anywhere: generators and tasks, each as likely as it is named.",
    )
    laser: LaserConfig = field(default_factory=LaserConfig)
    variation: VariationConfig = field(default_factory=VariationConfig)

    def __post_init__(self) -> None:
        """TaskError where a value is out of range."""
        self.laser = build_options(LaserConfig, "laser", self.laser)
        self.variation = build_options(VariationConfig, "variation", self.variation)
        check_options(self)
        self._limit_speeds()
        if not self.min_linear_velocity < self.max_linear_velocity:
            limit = f"below max_linear_velocity, {self.max_linear_velocity}"
            raise TaskError(f"min_linear_velocity must be {limit}, not {self.min_linear_velocity}")

    def _limit_speeds(self) -> None:
        """Hold the largest speeds against the robot's limits, and take those of the robot in place of FOLLOW."""
        self.robot = full_robot_name(self.robot)
        limits = open_robot(self.robot)
        for name, unit, own, usual, bound in zip(
            SPEEDS, ("m/s", "rad/s"), limits.robot, limits.task, VELOCITY_BOUNDS, strict=True
        ):
            most = min(own, float(bound))  # an observation holds no more
            value = getattr(self, name)
            if value > most + 1e-9:
                limit = f"above 0 and up to the robot's {math.floor(most * 1000) / 1000} {unit}"
                raise TaskError(f"{name} must be {limit}, not {value}")
            setattr(self, name, value or usual)


def with_robot(config: AnyConfig, robot: str) -> AnyConfig:
    """The same constants with another robot, their largest speeds cut at its limits: a policy keeps its own.

    Raises:
        TaskError: there is no such robot, or it does not obey.
    """
    limits = zip(SPEEDS, open_robot(robot).robot, strict=True)
    return replace(config, robot=robot, **{name: min(getattr(config, name), most) for name, most in limits})


def clip_goal(goal: tuple[float, float], goal_range: float) -> tuple[float, float]:
    """A goal in the robot's frame as it is observed: in its direction, no farther away than goal_range; metres."""
    x, y = goal
    share = min(1.0, goal_range / max(math.hypot(x, y), 1e-9))
    return share * x, share * y


class Navigation(control.Task):  # type: ignore[misc]  # dm_control has no types
    """Observation, reward and end of an episode.

    Commands are (v, ω) in m/s and rad/s. The task does not know which driver chose them.

    Attributes:
        readings: of base and goal at the present instant; physics is read once a step.
    """

    readings: Readings

    def __init__(
        self,
        config: NavigationConfig,
        reward: Reward,
        rng: np.random.Generator,
        held_out: FloatArray,
        rule: PairRule,
    ) -> None:
        """Make the task.

        Args:
            config: its constants.
            reward: of each step.
            rng: where starts and goals are drawn from.
            held_out: (n, 2) metres, goals of the stored evaluation sets, which no drawn goal comes near.
            rule: draws starts and goals.
        """
        self.config = config
        self.reward = reward
        self.rng = rng
        # A stream of its own: noise on the scans changes no start and no goal.
        self.laser = Laser(config.laser, config.control_timestep, rng.spawn(1)[0])
        self._held_out = held_out
        self.rule = rule
        self._next_pair: tuple[Pose, tuple[float, float]] | None = None  # None draws them
        self._next_variation: Variation | None = None
        self.variation = NO_VARIATION  # of the episode
        self._body: VariedBody | None = None
        self._has_margin = False
        self.start = Pose(0.0, 0.0, 0.0)  # of the episode, as it was set: the pose read back differs in the last bit
        self._reset_episode()

    def _reset_episode(self) -> None:
        self.outcome = Outcome.RUNNING
        self.reward_terms = self.reward.no_terms
        self._turn_rate = self._turn_change = 0.0  # of the commands, rad/s
        self._steps = 0

    # Episode ------------------------------------------------------------------------------------------------------

    def initialize_episode(self, physics: Physics) -> None:
        """Place robot and goal."""
        self.start, goal = self._next_pair or self._draw_pair(physics)
        self.vary(physics, self._next_variation or self.config.variation.draw(self.rng))
        self._next_pair = self._next_variation = None
        physics.set_pose(self.start)
        physics.set_goal(*goal)
        self.laser.begin_episode(physics, *self.variation[:3])
        self.readings = physics.readings()
        self._reset_episode()

    def set_safety_margin(self, physics: Physics, metres: float) -> None:
        """End episodes at this distance from an obstacle already, from the next one on; starts keep it too."""
        physics.set_safety_margin(metres)
        self._has_margin = metres > 0.0

    def _draw_pair(self, physics: Physics) -> tuple[Pose, tuple[float, float]]:
        """A start and a goal; where the room changes with each episode, in another one."""
        for _ in range(_MAX_STARTS):
            start, goal = self._draw_any_pair(physics)
            if not self._has_margin or physics.is_free(start):
                return start, goal
        raise TaskError(f"of {_MAX_STARTS} starts none keeps the safety margin; a smaller one is needed")

    def _draw_any_pair(self, physics: Physics) -> tuple[Pose, tuple[float, float]]:
        if isinstance(self.rule, ChangingRoom):
            return self.rule.enter_drawn(physics, self.rng)
        return self.rule.draw(self.rng, self._held_out)

    def vary(self, physics: Physics, variation: Variation) -> None:
        """Change friction and mass, at the beginning of an episode; its laser has the variation's faults too."""
        self.variation = variation
        if self._body is None:
            self._body = VariedBody(physics.model.ptr)
        self._body.apply(physics, variation.friction, variation.mass)

    @property
    def has_perfect_laser(self) -> bool:
        """Whether every episode's laser returns every range as it is, at once."""
        return self.laser.is_perfect and not self.config.variation.disturbs_laser

    def enter_room(self, physics: Physics, name: str) -> None:
        """Change the room at once; the episode in progress, if any, goes on in it.

        Raises:
            TaskError: there is no such room, or this task's room does not change.
        """
        if not isinstance(self.rule, ChangingRoom):
            raise TaskError("the room of this task does not change; task=nav_anywhere has one for each episode")
        self.rule.enter(physics, name)

    @property
    def room(self) -> str | None:
        """Name of the present room, where it changes."""
        return self.rule.name if isinstance(self.rule, ChangingRoom) else None

    @property
    def differences(self) -> dict[str, Any]:
        """Of this episode from those of a task of one room: `room`, its name, and `variation`, numbers by name."""
        room = {} if self.room is None else {"room": self.room}
        return room if self.config.variation.is_off else room | {"variation": dict(self.variation._asdict())}

    def set_next_pair(
        self, physics: Physics, start: Pose, goal: tuple[float, float], variation: Variation | None = None
    ) -> None:
        """Give the next episode, and only that one, a start and a goal in the present room, and a variation.

        Raises:
            TaskError: one of them lies outside the room or in an obstacle, or the robot would touch one at the start.
        """
        self.check_place("start", *start[:2])
        self.check_place("goal", *goal)
        if not physics.is_free(start):
            place = f"({start.x:g}, {start.y:g}, {start.yaw:g})"
            raise TaskError(f"a start must leave the robot free; at {place} it touches an obstacle")
        self._next_pair, self._next_variation = (start, goal), variation

    def drop_next_pair(self) -> None:
        """Draw the next start and goal again."""
        self._next_pair = self._next_variation = None

    def prepare_state(self, state: Mapping[str, Any], physics: Physics) -> None:
        """Change the scene to that of a state(), before physics gets its own."""
        if "room" in state:
            self.enter_room(physics, state["room"])
        self.vary(physics, Variation.from_mapping(state.get("variation", {})))

    def move_goal(self, physics: Physics, goal: tuple[float, float]) -> None:
        """Change the goal of the episode in progress; the next step's progress is measured towards it.

        Raises:
            TaskError: the goal lies outside the room or in an obstacle.
        """
        self.check_place("goal", *goal)
        physics.set_goal(*goal)
        self.readings = physics.readings()

    def check_place(self, kind: str, x: float, y: float) -> None:
        """TaskError where a place, m, lies out of the room or in an obstacle; `kind` is its name, such as goal."""
        room = self.rule.obstacles
        (left, bottom), (right, top) = room.low, room.high
        if not (left < x < right and bottom < y < top):
            bounds = f"x from {left:g} to {right:g} m and y from {bottom:g} to {top:g} m"
            raise TaskError(f"a {kind} must lie in the room, {bounds}, not at ({x:g}, {y:g})")
        if not room.clearance((x, y)) > 0.0:
            raise TaskError(f"a {kind} must lie on free floor; at ({x:g}, {y:g}) there is an obstacle")

    # State ----------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """Everything but physics and `rng` that the next steps depend on: plain values and arrays."""
        return {
            "start": list(self.start),
            "next_pair": self._next_pair and [list(part) for part in self._next_pair],
            "outcome": str(self.outcome),
            "reward_terms": dict(self.reward_terms),
            "steps": self._steps,
            "turn_rate": self._turn_rate,
            "laser": self.laser.state(),
            **self.differences,
        }

    def load_state(self, state: Mapping[str, Any], physics: Physics) -> None:
        """Restore what state() returned; `physics` has its own already."""
        self.readings = physics.readings()
        self.start = Pose(*state["start"])
        pair = state["next_pair"]
        self._next_pair = (Pose(*pair[0]), (pair[1][0], pair[1][1])) if pair else None
        self.outcome = Outcome(state["outcome"])
        self.reward_terms = dict(state["reward_terms"])
        self._steps = state["steps"]
        self._turn_rate = state.get("turn_rate", 0.0)
        self.laser.load_state(state["laser"], *self.variation[:3])

    # Step ---------------------------------------------------------------------------------------------------------

    def before_step(self, action: FloatArray, physics: Physics) -> None:
        """Command the wheels; a command out of bounds is clipped to them.

        Raises:
            TaskError: it is not two numbers.
        """
        limits = self.config
        try:
            linear, angular = map(float, action)
        except (TypeError, ValueError) as error:
            raise TaskError(f"an action is two numbers, for v and for ω, not {reprlib.repr(action)}") from error
        turn_rate = min(max(angular, -limits.max_angular_velocity), limits.max_angular_velocity)
        self._turn_rate, self._turn_change = turn_rate, turn_rate - self._turn_rate
        physics.set_velocity_command(
            min(max(linear, limits.min_linear_velocity), limits.max_linear_velocity), turn_rate
        )

    def after_step(self, physics: Physics) -> None:
        """Judge the step: outcome and reward terms."""
        self._steps += 1
        previous_distance, self.readings = self.readings.goal_distance, physics.readings()
        distance = self.readings.goal_distance
        if physics.crashed():
            self.outcome = Outcome.CRASHED
        elif distance <= self.config.goal_radius:
            self.outcome = Outcome.REACHED
        elif self._steps >= self.config.time_limit_steps:
            self.outcome = Outcome.TIMEOUT
        self.reward_terms = self.reward.terms(self.outcome, previous_distance, distance, self._turn_change)

    def get_reward(self, physics: Physics) -> float:
        """Sum of the reward terms."""
        return sum(self.reward_terms.values())

    def get_termination(self, physics: Physics) -> float | None:
        """Discount at the end of an episode: 0 at a terminal state, 1 at the time limit, None while it goes on.

        The time limit is judged here and not by control.Environment, whose own would turn a crash in the last step
        into a time-out.
        """
        if self.outcome is Outcome.RUNNING:
            return None
        return 1.0 if self.outcome is Outcome.TIMEOUT else 0.0

    # Observation --------------------------------------------------------------------------------------------------

    def get_observation(self, physics: Physics) -> dict[str, FloatArray]:
        """Scan (num_beams,) m, velocity (2,) m/s and rad/s, goal in the robot frame (2,) m; all float64."""
        return {
            "ranges": self.laser.ranges(physics),
            "velocity": np.array(self.readings.velocity),
            "goal": np.array(self.observed_goal()),
        }

    def observed_goal(self) -> tuple[float, float]:
        """The goal in the robot's frame, metres, no farther away than goal_range."""
        return clip_goal(self.readings.goal_in_robot_frame, self.config.goal_range)

    def observation_spec(self, physics: Physics) -> dict[str, specs.BoundedArray]:
        """Bounds of each observation."""
        beams = (self.config.laser.num_beams,)
        return {
            "ranges": specs.BoundedArray(beams, np.float64, physics.min_range, physics.max_range, "ranges"),
            "velocity": specs.BoundedArray((2,), np.float64, -VELOCITY_BOUNDS, VELOCITY_BOUNDS, "velocity"),
            "goal": specs.BoundedArray((2,), np.float64, -GOAL_BOUND, GOAL_BOUND, "goal"),
        }

    @property
    def random(self) -> np.random.Generator:
        """`rng`, as dm_control's wrappers call it; setting it seeds the laser's noise too."""
        return self.rng

    @random.setter
    def random(self, source: RandomSource) -> None:
        self.rng = make_generator(source)
        self.laser.rng = self.rng.spawn(1)[0]

    _random = random  # by this name Shimmy's environments are seeded
    visualize_reward = False  # dm_control's suite has it; the scene shows the goal, and no reward

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        """(v, ω) in m/s and rad/s."""
        limits = self.config
        return specs.BoundedArray(
            shape=(2,),
            dtype=np.float64,
            minimum=[limits.min_linear_velocity, -limits.max_angular_velocity],
            maximum=[limits.max_linear_velocity, limits.max_angular_velocity],
            name="velocity_command",
        )

    def step_spec(self, physics: Physics) -> dm_env.TimeStep:
        """Unused here; dm_control declares it abstract."""
        raise NotImplementedError
