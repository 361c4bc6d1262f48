"""Drive to a goal without touching anything: the task of the paper."""

from collections.abc import Mapping
from dataclasses import dataclass

import dm_env
import numpy as np
from dm_control.rl import control
from dm_env import specs

from tasks import constants, goals
from tasks.obstacles import Obstacles
from tasks.outcomes import Outcome
from tasks.physics import FloatArray, Physics, Pose
from tasks.rewards import Reward

# Bounds of the observation, wide enough for anything the robot does. The wheels' limit gives 1.2 m/s and 7.3 rad/s.
VELOCITY_BOUNDS = np.array([3.0, 15.0])  # m/s, rad/s
GOAL_BOUND = 50.0  # m


@dataclass
class NavigationConfig:
    """Every constant of the task; the defaults are the paper's."""

    # Seconds between two commands.
    control_timestep: float = constants.CONTROL_TIMESTEP
    # Metres between base and goal at which the goal counts as reached.
    goal_radius: float = constants.GOAL_RADIUS
    # Steps after which an episode is broken off; a limit of time, not an end (discount 1).
    time_limit_steps: int = constants.TIME_LIMIT_STEPS
    # m/s, the largest forward speed commanded; the smallest is 0.
    max_linear_velocity: float = constants.MAX_LINEAR_VELOCITY
    # rad/s, the largest turn rate commanded, either way.
    max_angular_velocity: float = constants.MAX_ANGULAR_VELOCITY


class Navigation(control.Task):  # type: ignore[misc]  # dm_control has no types
    """Observation, reward and end of an episode.

    Commands are (v, ω) in m/s and rad/s. The task does not know who chose them.
    """

    def __init__(
        self, config: NavigationConfig, reward: Reward, rng: np.random.Generator, held_out: FloatArray
    ) -> None:
        """Make the task.

        Args:
            config: its constants.
            reward: what a step earns.
            rng: where starts and goals are drawn from.
            held_out: (n, 2) metres, goals of the stored evaluation sets, which no drawn goal comes near.
        """
        self.config = config
        self.reward = reward
        self.rng = rng
        self._held_out = held_out
        self._obstacles: Obstacles | None = None
        self._next_pair: tuple[Pose, tuple[float, float]] | None = None
        self._reset_episode(np.inf)

    def _reset_episode(self, distance: float) -> None:
        self.outcome = Outcome.RUNNING
        self.reward_terms: Mapping[str, float] = {}
        self._distance = distance
        self._steps = 0

    # Episode ------------------------------------------------------------------------------------------------------

    def set_next_pair(self, start: Pose, goal: tuple[float, float]) -> None:
        """Let the next episode, and only that one, begin at `start` with `goal`."""
        self._next_pair = (start, goal)

    def initialize_episode(self, physics: Physics) -> None:
        """Put robot and goal in their places."""
        start, goal = self._next_pair or self._draw_pair(physics)
        self._next_pair = None
        physics.set_pose(start)
        physics.set_goal(*goal)
        self._reset_episode(physics.goal_distance())

    def _draw_pair(self, physics: Physics) -> tuple[Pose, tuple[float, float]]:
        if self._obstacles is None:
            self._obstacles = Obstacles.from_model(physics.model.ptr)
        x, y = goals.draw_goal(self.rng, self._obstacles, self._held_out).tolist()
        return Pose(0.0, 0.0, 0.0), (x, y)

    # Step ---------------------------------------------------------------------------------------------------------

    def before_step(self, action: FloatArray, physics: Physics) -> None:
        """Command the wheels; a command out of bounds is clipped to them."""
        limits = self.config
        linear, angular = float(action[0]), float(action[1])
        physics.set_velocity_command(
            min(max(linear, 0.0), limits.max_linear_velocity),
            min(max(angular, -limits.max_angular_velocity), limits.max_angular_velocity),
        )

    def after_step(self, physics: Physics) -> None:
        """Judge the step: outcome and reward terms."""
        self._steps += 1
        distance = physics.goal_distance()
        if physics.crashed():
            self.outcome = Outcome.CRASHED
        elif distance <= self.config.goal_radius:
            self.outcome = Outcome.REACHED
        elif self._steps >= self.config.time_limit_steps:
            self.outcome = Outcome.TIMEOUT
        self.reward_terms = self.reward.terms(self.outcome, self._distance, distance)
        self._distance = distance

    def get_reward(self, physics: Physics) -> float:
        """Sum of the reward terms."""
        return sum(self.reward_terms.values())

    def get_termination(self, physics: Physics) -> float | None:
        """Discount at the end of an episode: 0 where it ended, 1 where only time was up, None while it goes on.

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
            "ranges": physics.ranges(),
            "velocity": np.array(physics.velocity()),
            "goal": np.array(physics.goal_in_robot_frame()),
        }

    def observation_spec(self, physics: Physics) -> dict[str, specs.BoundedArray]:
        """Bounds of each observation."""
        beams = (physics.num_beams,)
        return {
            "ranges": specs.BoundedArray(beams, np.float64, constants.MIN_RANGE, constants.MAX_RANGE, "ranges"),
            "velocity": specs.BoundedArray((2,), np.float64, -VELOCITY_BOUNDS, VELOCITY_BOUNDS, "velocity"),
            "goal": specs.BoundedArray((2,), np.float64, -GOAL_BOUND, GOAL_BOUND, "goal"),
        }

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        """(v, ω) in m/s and rad/s."""
        limits = self.config
        return specs.BoundedArray(
            shape=(2,),
            dtype=np.float64,
            minimum=[0.0, -limits.max_angular_velocity],
            maximum=[limits.max_linear_velocity, limits.max_angular_velocity],
            name="velocity_command",
        )

    def step_spec(self, physics: Physics) -> dm_env.TimeStep:
        """Unused by this project; dm_control asks tasks for it."""
        raise NotImplementedError
