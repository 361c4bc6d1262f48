"""The tasks as Gymnasium environments."""

import reprlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from tasks import constants
from tasks.errors import TaskError
from tasks.generator_state import generator_state, restored_generator
from tasks.graphics.rendering import OffscreenRenderer, check_picture
from tasks.gymnasium_api.flat_observation import SCANS, Float32Array, ScanStack
from tasks.navigation import GOAL_BOUND, VELOCITY_BOUNDS, Navigation, NavigationConfig
from tasks.options import Range, argument, check_options
from tasks.physics import FloatArray, Pose
from tasks.registry import ALL_TASKS, load
from tasks.rewards import Outcome, Reward, dense_part
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.reading import ROOMS, is_room
from tasks.scene.loading import model_hash
from tasks.variation import Variation

RENDER_MODES = Range(lambda mode: mode == "rgb_array", "rgb_array or None")


@dataclass
class EnvironmentOptions:
    """Arguments of NavigationEnv beside the task's."""

    num_scans: int = argument("Scans stacked in the observation.", values=SCANS)
    render_mode: str | None = argument("None or rgb_array.", values=RENDER_MODES)
    camera: str = argument("Of the scene, or free for the whole of it.")
    width: int = argument("Of a rendered picture, px.")
    height: int = argument("Of a rendered picture, px.")


class NavigationEnv(gymnasium.Env[Any, Any]):
    """A task behind Gymnasium's API; an action is v in m/s and ω in rad/s.

    `info` holds, after reset() too, `pose` (x, y, yaw; m, rad), `distance` to the goal (m), `pushed` (movable things
    touched in the step), `reward_terms` by name, `dense_reward` (the part that γ_p scales), `start` (x, y, yaw) and
    `goal` (x, y), of task=nav_anywhere `room`, its name, of episodes that vary `variation`, numbers by name, with all
    of which `reset` begins the same episode again, `outcome` (`running` until the end), `is_success`.

    Attributes:
        physics: the scene's Physics, for reading.
        task: the dm_control task, for reading.
        scene_hash: of the compiled scene; of a room that changes, of its empty slots.
    """

    metadata = {  # noqa: RUF012
        "render_modes": ["rgb_array"],
        "render_fps": round(1 / constants.CONTROL_TIMESTEP),
    }

    def __init__(
        self,
        task: str,
        reward: str | Reward | Mapping[str, Any] | None = None,
        config: NavigationConfig | Mapping[str, Any] | None = None,
        num_scans: int = constants.NUM_SCANS,
        render_mode: str | None = None,
        camera: str = "chase",
        width: int = 480,
        height: int = 360,
    ) -> None:
        """Load a task.

        Args:
            task: one of tasks.ALL_TASKS, or a room: a file, or a generated one such as cylinders:17.
            reward: `dense`, `sparse` or a Reward; None takes the task's default.
            config: constants of the task; None takes the paper's. Mappings, as a spec's JSON holds them, do too.
            num_scans: scans stacked in the observation.
            render_mode: None or `rgb_array`.
            camera: `chase`, `top`, `onboard`, or `free` for the whole scene.
            width: of a rendered picture, pixels.
            height: of a rendered picture, pixels.

        Raises:
            TaskError: an argument is out of range.
        """
        options = EnvironmentOptions(num_scans, render_mode, camera, width, height)
        check_options(options)
        self._task_name = task
        self._env = load(task, random=0, reward=reward, config=config)
        self.physics: Any = self._env.physics
        self.task: Navigation = self._env.task
        self.scene_hash = model_hash(self.physics.model.ptr)  # before an episode changes it
        self._stack = ScanStack(options.num_scans, self.task.config.laser.num_beams, self.physics.max_range)
        self.render_mode = render_mode
        self._picture = (options.camera, options.width, options.height)
        check_picture(self.physics.model.ptr, *self._picture)
        self._renderer: OffscreenRenderer | None = None
        self._begun = False
        limits = self.task.action_spec(self.physics)
        self.action_space = spaces.Box(limits.minimum.astype(np.float32), limits.maximum.astype(np.float32))
        scans = np.full(self.scan_shape[0] * self.scan_shape[1], 0.5)
        high = np.concatenate([scans, VELOCITY_BOUNDS, [GOAL_BOUND, GOAL_BOUND]]).astype(np.float32)
        self.observation_space = spaces.Box(-high, high)

    @property
    def obstacles(self) -> Obstacles:
        """Of the room; of one that changes, the present one's."""
        return self.task.rule.obstacles

    @property
    def scan_shape(self) -> tuple[int, int]:
        """Scans and beams at the head of the observation."""
        return self._stack.num_scans, self._stack.num_beams

    @property
    def scan_latency(self) -> float:
        """Seconds from a scan to the end of the step that returns it."""
        return float(self.task.laser.latency)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32Array, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: of the starts and goals to come; None continues the present stream.
            options: `start` (x, y, yaw) and `goal` (x, y), metres and radians, for this episode alone; a goal alone
                starts at the origin. With them `room` and `variation`, as `info` has them; without, a room that
                changes stays the present one.
        """
        room = self.task.room
        if options is not None and options != {}:
            self._set_next_pair(options)
        try:
            super().reset(seed=seed)
        except gymnasium.error.Error:  # an invalid seed
            self.task.drop_next_pair()
            self._return_to_room(room)
            raise
        self.task.rng = self.np_random
        if seed is not None or not self._begun:
            self.task.laser.rng = self.np_random.spawn(1)[0]
        time_step = self._env.reset()
        self._begun = True
        return self._stack.reset(time_step.observation), self._info()

    def _set_next_pair(self, options: dict[str, Any]) -> None:
        if not isinstance(options, Mapping) or not {"goal"} <= set(options) <= {"goal", "start", "room", "variation"}:
            valid = (
                "goal (x, y) and, if not at the origin, start (x, y, yaw), metres and radians, and room and variation "
                "as info gives them"
            )
            raise TaskError(f"reset options are {valid}, not {reprlib.repr(options)}")
        x, y = _to_numbers("the goal", options["goal"], 2)
        start = Pose(*_to_numbers("the start", options.get("start", (0.0, 0.0, 0.0)), 3))
        variation = Variation.from_mapping(options["variation"]) if "variation" in options else None
        room = self.task.room
        try:
            if "room" in options:
                self.task.enter_room(self.physics, options["room"])
            self.task.set_next_pair(self.physics, start, (x, y), variation)
        except TaskError:
            self._return_to_room(room)
            raise

    def _return_to_room(self, room: str | None) -> None:
        """Leave the room that the next episode was to have: the present one goes on."""
        if room and room != self.task.room:
            self.task.enter_room(self.physics, room)

    def step(self, action: FloatArray) -> tuple[Float32Array, float, bool, bool, dict[str, Any]]:
        """Drive for one control step; `action` is (v, ω) in m/s and rad/s, cut at the bounds of the task."""
        if not self._begun or self.task.outcome is not Outcome.RUNNING:
            raise gymnasium.error.ResetNeeded("no episode is in progress: call reset() before step()")
        time_step = self._env.step(action)
        terminated = time_step.last() and time_step.discount == 0.0
        truncated = time_step.last() and not terminated
        return self._stack.push(time_step.observation), float(time_step.reward), terminated, truncated, self._info()

    def state(self) -> dict[str, Any]:
        """Everything that the steps and episodes to come depend on: plain values and arrays under string keys.

        It may be taken at any time, and restored into another environment of the same arguments and in another process.
        """
        return {
            "task_name": self._task_name,
            "physics": self.physics.full_state(),
            "task": self.task.state(),
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
        self.task.prepare_state(state["task"], self.physics)
        self.physics.load_full_state(state["physics"])
        self.task.load_state(state["task"], self.physics)
        self.np_random = self.task.rng = restored_generator(state["rng"])
        self._np_random_seed = state["seed"]
        self._begun = state["begun"]
        self._env._reset_next_step, self._env._step_count = state["over"], state["count"]
        return self._stack.state(), self._info() if self._begun else {}

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy.deepcopy: a copy opens a renderer of its own when it first draws."""
        _ = self.np_random  # Gymnasium seeds it when first read: the copy must not seed itself otherwise
        return self.__dict__ | {"_renderer": None}

    def set_safety_margin(self, metres: float) -> None:
        """End episodes at this distance from an obstacle already, from the next one on: for learning, not for tests."""
        self.task.set_safety_margin(self.physics, metres)

    def set_goal(self, x: float, y: float) -> Float32Array:
        """Give the episode in progress another goal, metres, world frame.

        The next step is rewarded for progress towards the new goal.

        Returns:
            The present observation, with that goal.

        Raises:
            TaskError: no episode is in progress, or the goal lies outside the room or in an obstacle.
        """
        if not self._begun or self.task.outcome is not Outcome.RUNNING:
            raise TaskError("no episode is in progress whose goal could be moved")
        x, y = _to_numbers("the goal", (x, y), 2)
        self.task.move_goal(self.physics, (x, y))
        return self._stack.replace_goal(self.task.observed_goal())

    def _info(self) -> dict[str, Any]:
        task = self.task
        terms = task.reward_terms
        return {
            "pose": task.readings.pose,
            "distance": task.readings.goal_distance,
            "pushed": self.physics.num_pushed(),
            "reward_terms": terms,
            "dense_reward": dense_part(terms),
            "start": task.start,
            "goal": task.readings.goal,
            "outcome": str(task.outcome),
            "is_success": task.outcome is Outcome.REACHED,
            **task.differences,
        }

    def render(self) -> Any:
        """The scene as uint8 (height, width, 3); None without a render mode."""
        if self.render_mode is None:
            return None
        camera, width, height = self._picture
        if self._renderer is None:
            self._renderer = OffscreenRenderer(self.physics.model.ptr, width, height)
        return self._renderer.render(self.physics.data.ptr, camera)

    def close(self) -> None:
        """Free the renderer; may be called again."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


OWN_ROOM_ID = "asddpg/Nav-v0"


def room_env(scene: str = "", **arguments: Any) -> NavigationEnv:
    """The environment of a room: `gymnasium.make("asddpg/Nav-v0", scene=PATH)`; TaskError without a scene."""
    return NavigationEnv(check_scene(scene), **arguments)


def check_scene(scene: str) -> str:
    """The name of a room; TaskError where it is no such name."""
    if not isinstance(scene, str) or not is_room(scene):
        raise TaskError(f"{OWN_ROOM_ID} needs scene=, {ROOMS}, not {reprlib.repr(scene)}")
    return scene


def id_and_scene(task_name: str) -> tuple[str, dict[str, Any]]:
    """What gymnasium.make takes for a task, its id, or for a room, the id of all of them and its scene."""
    if is_room(task_name):
        return OWN_ROOM_ID, {"scene": task_name}
    return gymnasium_id(task_name), {}


def gymnasium_id(task_name: str) -> str:
    """`nav_complex` → `asddpg/NavComplex-v0`."""
    return f"asddpg/{''.join(part.capitalize() for part in task_name.split('_'))}-v0"


def register() -> None:
    """Register every task with Gymnasium, once."""
    for task_name in ALL_TASKS:
        if gymnasium_id(task_name) not in gymnasium.registry:
            gymnasium.register(
                gymnasium_id(task_name),
                entry_point=f"{__name__}:NavigationEnv",
                vector_entry_point="tasks.gymnasium_api.navigation_vector_env:NavigationVectorEnv",
                kwargs={"task": task_name},
                # The environment checks both itself; the wrappers would cost a tenth of a step.
                disable_env_checker=True,
                order_enforce=False,
            )
    if OWN_ROOM_ID not in gymnasium.registry:
        gymnasium.register(
            OWN_ROOM_ID,
            entry_point=f"{__name__}:room_env",
            vector_entry_point="tasks.gymnasium_api.navigation_vector_env:room_vector_env",
            disable_env_checker=True,
            order_enforce=False,
        )


def _to_numbers(name: str, values: Any, count: int) -> list[float]:
    try:
        array = np.asarray(values)
    except ValueError:  # nested lists
        array = np.empty(0)
    if array.shape != (count,) or array.dtype.kind not in "iuf" or not np.isfinite(array).all():
        raise TaskError(f"{name} must be {count} finite numbers, not {reprlib.repr(values)}")
    return [float(number) for number in array]
