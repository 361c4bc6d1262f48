"""The tasks as Gymnasium environments."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from tasks import constants
from tasks.errors import TaskError
from tasks.generator_state import generator_state, restored_generator
from tasks.graphics.rendering import OffscreenRenderer
from tasks.gymnasium_api.flat_observation import Float32Array, ScanStack
from tasks.navigation import GOAL_BOUND, VELOCITY_BOUNDS, NavigationConfig
from tasks.physics import FloatArray, Pose
from tasks.registry import ALL_TASKS, load
from tasks.rewards import Outcome, Reward, dense_part
from tasks.room_geometry.obstacles import Obstacles


class NavigationEnv(gymnasium.Env[Any, Any]):
    """A task behind Gymnasium's API; actions in [−1, 1], as its checker recommends for a raw environment.

    `gymnasium.make` puts `PhysicalActions` around it, whose Box is in m/s and rad/s.

    `info` holds at every step `pose` (x, y, yaw; m, rad), `distance` to the goal (m), `reward_terms` by name,
    `dense_reward` (the part that γ_p scales), `pushed` (movable things touched in the step), at the end `outcome`, and
    at the beginning `start` (x, y, yaw) and `goal` (x, y), with which `reset` begins the same episode again.
    """

    metadata = {  # noqa: RUF012
        "render_modes": ["rgb_array"],
        "render_fps": round(1 / constants.CONTROL_TIMESTEP),
    }

    def __init__(
        self,
        task: str,
        reward: str | Reward | None = None,
        config: NavigationConfig | None = None,
        num_scans: int = constants.NUM_SCANS,
        render_mode: str | None = None,
        camera: str = "chase",
        width: int = 480,
        height: int = 360,
    ) -> None:
        """Load a task.

        Args:
            task: one of tasks.ALL_TASKS.
            reward: `dense`, `sparse` or a Reward; None takes the task's default.
            config: constants of the task; None takes the paper's.
            num_scans: scans stacked in the observation.
            render_mode: None or `rgb_array`.
            camera: `chase`, `top`, `onboard`, or `free` for the whole scene.
            width: of a rendered picture, pixels.
            height: of a rendered picture, pixels.
        """
        if render_mode not in (None, "rgb_array"):
            raise TaskError(f"there is no render mode {render_mode!r}; there is rgb_array")
        self._task_name = task
        self._env = load(task, random=0, reward=reward, config=config)
        self._physics = self._env.physics
        self._task = self._env.task
        self._stack = ScanStack(num_scans, self._physics.num_beams)
        self.render_mode = render_mode
        self._picture = (camera, width, height)
        self._renderer: OffscreenRenderer | None = None
        self._begun = False
        limits = self._task.action_spec(self._physics)
        self.physical_action_space = spaces.Box(
            limits.minimum.astype(np.float32), limits.maximum.astype(np.float32), dtype=np.float32
        )
        self._middle = (limits.maximum + limits.minimum) / 2
        self._half_range = (limits.maximum - limits.minimum) / 2
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = self._observation_space()

    def _observation_space(self) -> spaces.Box:
        scans = np.full(self.scan_shape[0] * self.scan_shape[1], 0.5)
        high = np.concatenate([scans, VELOCITY_BOUNDS, [GOAL_BOUND, GOAL_BOUND]]).astype(np.float32)
        return spaces.Box(-high, high, dtype=np.float32)

    @property
    def scan_shape(self) -> tuple[int, int]:
        """Scans and beams at the head of the observation."""
        return self._stack.num_scans, self._stack.num_beams

    @cached_property
    def obstacles(self) -> Obstacles:
        """Obstacles of the room, computed once."""
        return Obstacles.from_model(self._physics.model.ptr)

    @property
    def physics(self) -> Any:
        """The scene's Physics, for reading."""
        return self._physics

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32Array, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: of the starts and goals to come; None continues the present stream.
            options: `start` (x, y, yaw) and `goal` (x, y), metres and radians, for this episode alone; a goal alone
                starts at the origin.
        """
        super().reset(seed=seed)
        self._task.rng = self.np_random
        if seed is not None or not self._begun:
            self._task.laser.rng = self.np_random.spawn(1)[0]
        if options:
            self._set_next_pair(options)
        time_step = self._env.reset()
        self._begun = True
        return self._stack.reset(time_step.observation), self._info()

    def _set_next_pair(self, options: dict[str, Any]) -> None:
        try:
            rest = dict(options)
            goal_x, goal_y = (float(value) for value in rest.pop("goal"))
            x, y, yaw = (float(value) for value in rest.pop("start", (0.0, 0.0, 0.0)))
            if rest or not np.all(np.abs([goal_x, goal_y, x, y, yaw]) < GOAL_BOUND / 2):
                raise ValueError
        except (KeyError, TypeError, ValueError) as error:
            valid = f"goal (x, y) and, if not at the origin, start (x, y, yaw), all below {GOAL_BOUND / 2:g}"
            raise TaskError(f"reset options are {valid}, not {options}") from error
        self._task.next_pair = Pose(x, y, yaw), (goal_x, goal_y)

    def step(self, action: FloatArray) -> tuple[Float32Array, float, bool, bool, dict[str, Any]]:
        """Drive for one control step; `action` (2,) in [−1, 1]."""
        return self.step_physical(self._middle + self._half_range * np.asarray(action, dtype=np.float64))

    def step_physical(self, command: FloatArray) -> tuple[Float32Array, float, bool, bool, dict[str, Any]]:
        """Drive for one control step; `command` is (v, ω) in m/s and rad/s."""
        if not self._begun or self._task.outcome is not Outcome.RUNNING:
            raise gymnasium.error.ResetNeeded("no episode is in progress: call reset() before step()")
        if np.shape(command) != (2,):
            raise TaskError(f"an action is two numbers, for v and for ω, not of shape {np.shape(command)}")
        time_step = self._env.step(command)
        terminated = time_step.last() and time_step.discount == 0.0
        truncated = time_step.last() and not terminated
        return self._stack.push(time_step.observation), float(time_step.reward), terminated, truncated, self._info()

    def state(self) -> dict[str, Any]:
        """Everything that the steps and episodes to come depend on: plain values and arrays under string keys.

        It may be taken at any time, and restored into another environment of the same arguments and in another process.
        """
        return {
            "task_name": self._task_name,
            "physics": self._physics.full_state(),
            "task": self._task.state(),
            "observation": self._stack.state(),
            "rng": generator_state(self.np_random),
            "seed": self.np_random_seed,
            "begun": self._begun,
            "over": self._env._reset_next_step,  # dm_control names no reading of it
            "count": self._env._step_count,
        }

    def load_state(self, state: Mapping[str, Any]) -> tuple[Float32Array, dict[str, Any]]:
        """Restore what state() returned: what follows is equal to the last bit.

        Returns:
            The observation and the `info` of that instant, as reset() or step() gave them; before the first reset
            zeros and {}.

        Raises:
            TaskError: it is the state of another task, or of other numbers of beams or scans.
        """
        if state["task_name"] != self._task_name:
            raise TaskError(f"the state is of {state['task_name']}, and the environment of {self._task_name}")
        self._stack.load_state(state["observation"])
        self._physics.load_full_state(state["physics"])
        self._task.load_state(state["task"], self._physics)
        self.np_random = self._task.rng = restored_generator(state["rng"])
        self._np_random_seed = state["seed"]
        self._begun = state["begun"]
        self._env._reset_next_step, self._env._step_count = state["over"], state["count"]
        return self._stack.state(), self._info() if self._begun else {}

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy.deepcopy: a copy opens a renderer of its own when it first draws."""
        _ = self.np_random  # Gymnasium seeds it when first read: the copy must not seed itself otherwise
        return self.__dict__ | {"_renderer": None}

    def set_goal(self, x: float, y: float) -> Float32Array:
        """Give the episode in progress another goal, metres, world frame.

        The next step is rewarded for progress towards the new goal.

        Returns:
            The present observation, with that goal.

        Raises:
            TaskError: no episode is in progress, or the goal lies outside the room or in an obstacle.
        """
        if not self._begun or self._task.outcome is not Outcome.RUNNING:
            raise TaskError("no episode is in progress whose goal could be moved")
        low, high = self.obstacles.low, self.obstacles.high
        if not (low[0] < x < high[0] and low[1] < y < high[1]):
            bounds = f"x from {low[0]:g} to {high[0]:g} m and y from {low[1]:g} to {high[1]:g} m"
            raise TaskError(f"a goal must lie in the room, {bounds}, not at ({x:g}, {y:g})")
        if not self.obstacles.clearance((x, y)) > 0.0:
            raise TaskError(f"a goal must lie on free floor; at ({x:g}, {y:g}) there is an obstacle")
        self._task.move_goal(self._physics, (x, y))
        return self._stack.replace_goal(self._task.readings.goal_in_robot_frame)

    def _info(self) -> dict[str, Any]:
        task = self._task
        terms = task.reward_terms
        info = {
            "pose": task.readings.pose,
            "distance": task.readings.goal_distance,
            "pushed": self._physics.num_pushed(),
            "reward_terms": terms,
            "dense_reward": dense_part(terms) if terms else 0.0,
        }
        if not terms:  # at the beginning
            info |= {"start": task.start, "goal": self._physics.goal()}
        if task.outcome is not Outcome.RUNNING:
            info["outcome"] = str(task.outcome)
        return info

    def render(self) -> Any:
        """The scene as uint8 (height, width, 3); None without a render mode."""
        if self.render_mode is None:
            return None
        camera, width, height = self._picture
        if self._renderer is None:
            self._renderer = OffscreenRenderer(self._physics.model.ptr, width, height)
        return self._renderer.render(self._physics.data.ptr, camera)

    def close(self) -> None:
        """Free the renderer; may be called again."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


class PhysicalActions(gymnasium.Wrapper[Any, Any, Any, Any], gymnasium.utils.RecordConstructorArgs):
    """Actions in physical units: v in m/s and ω in rad/s."""

    def __init__(self, env: NavigationEnv) -> None:
        gymnasium.utils.RecordConstructorArgs.__init__(self)
        super().__init__(env)
        self.action_space = env.physical_action_space
        self._step = env.step_physical

    def step(self, action: FloatArray) -> tuple[Float32Array, float, bool, bool, dict[str, Any]]:
        """Drive for one control step; `action` is (v, ω) in m/s and rad/s."""
        return self._step(action)


def gymnasium_id(task_name: str) -> str:
    """`nav_complex` → `asddpg/NavComplex-v0`."""
    return f"asddpg/{''.join(part.capitalize() for part in task_name.split('_'))}-v0"


def register() -> None:
    """Register every task with Gymnasium."""
    physical = gymnasium.envs.registration.WrapperSpec("PhysicalActions", f"{__name__}:PhysicalActions", kwargs={})
    for task_name in ALL_TASKS:
        gymnasium.register(
            gymnasium_id(task_name),
            entry_point=f"{__name__}:NavigationEnv",
            kwargs={"task": task_name},
            additional_wrappers=(physical,),
            # The environment checks both itself; the wrappers would cost a tenth of a step.
            disable_env_checker=True,
            order_enforce=False,
        )
