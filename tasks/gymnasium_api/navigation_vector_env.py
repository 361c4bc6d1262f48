"""The tasks as a vector environment: many robots at once."""

import copy
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from tasks.errors import TaskError
from tasks.gymnasium_api.flat_observation import Float32Array
from tasks.gymnasium_api.navigation_env import NavigationEnv, check_scene
from tasks.gymnasium_api.robot_batch import BoolArray, RobotBatch, columns
from tasks.navigation import clip_goal
from tasks.options import POSITIVE, argument, check_options
from tasks.physics import FloatArray
from tasks.rewards import Outcome

_OUTCOMES = np.array([str(outcome) for outcome in Outcome], dtype=object)  # by code
_RUNNING, _REACHED, _CRASHED, _TIMEOUT = range(4)
_NONE = -1  # before the first reset

BatchStep = tuple[Float32Array, FloatArray, BoolArray, BoolArray, dict[str, Any]]


@dataclass
class VectorOptions:
    """Arguments of NavigationVectorEnv beside the single environment's."""

    num_envs: int = argument("Robots.", values=POSITIVE)
    num_threads: int | None = argument("That move the robots.", values=POSITIVE)
    max_episode_steps: int | None = argument("Steps after which an episode is truncated.", values=POSITIVE)


class NavigationVectorEnv(VectorEnv[Any, Any, Any]):
    """Robots of one task or of several, each in a scene of its own; an action is v in m/s and ω in rad/s.

    Robot i equals the single environment of its seed to the last bit. `info` has the keys of NavigationEnv, an array
    each with a row for each robot, and Gymnasium's masks.

    Attributes:
        envs: the environments whose robots these are; their physics may be read.
    """

    def __init__(
        self,
        task: str | Sequence[str],
        num_envs: int = 1,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        num_threads: int | None = None,
        max_episode_steps: int | None = None,
        **kwargs: Any,
    ) -> None:
        """Load the tasks.

        Args:
            task: one of tasks.ALL_TASKS or a room, or one for each robot.
            num_envs: robots.
            autoreset_mode: what follows an episode's end: a reset with the next step, with the same, or by the caller.
            num_threads: that move the robots; None takes one for each core of this process.
            max_episode_steps: steps after which an episode is truncated, as by Gymnasium's TimeLimit; None or −1 for
                the task's own limit alone.
            kwargs: of NavigationEnv.

        Raises:
            TaskError: an argument is out of range.
        """
        limit = None if max_episode_steps == -1 else max_episode_steps
        check_options(VectorOptions(num_envs, num_threads, limit))
        tasks = [task] * num_envs if isinstance(task, str) else [*task]
        if len(tasks) != num_envs:
            raise TaskError(f"task must be one task or num_envs, {num_envs}, of them, not {len(tasks)}")
        self.envs = _make_envs(tasks, kwargs)
        first = self.envs[0]
        self.num_envs, self.render_mode = num_envs, first.render_mode
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {**first.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_observation_space, self.single_action_space = first.observation_space, first.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._substeps = round(first.task.config.control_timestep / first.physics.timestep())
        self._batch = RobotBatch(self.envs, num_threads or len(os.sched_getaffinity(0)))
        self._observations: Float32Array = np.zeros((num_envs, math.prod(first.scan_shape) + 4), np.float32)
        self._max_steps = limit or math.inf
        self._steps, self._outcomes = np.zeros(num_envs, np.int64), np.full(num_envs, _NONE)
        self._over = np.ones(num_envs, np.bool_)  # no episode is in progress
        self._starts, self._goals = np.zeros((num_envs, 3)), np.zeros((num_envs, 2))
        rewards = [env.task.reward for env in self.envs]  # tasks differ in theirs
        self._reward_constants = np.array(
            [(r.progress, r.time_penalty, r.reach, r.crash, r.turn_price) for r in rewards]
        ).T
        self._terms = {name: np.zeros(num_envs) for name in first.task.reward.no_terms}
        self._turn_rates, self._turn_changes = np.zeros(num_envs), np.zeros(num_envs)  # of the commands, rad/s
        self._differences: list[dict[str, Any]] = [env.task.differences for env in self.envs]
        self._readings = self._batch.readings(self._goals)

    # Episodes -----------------------------------------------------------------------------------------------------

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float32Array, dict[str, Any]]:
        """Begin an episode with each robot.

        Args:
            seed: of robot 0, that of robot i is i more; or one for each robot; None continues the present streams.
            options: `start` and `goal` of NavigationEnv, the same for all; `reset_mask`, bool (num_envs,), the robots
                that begin an episode, in place of all.
        """
        seeds: Sequence[int | None] = [None] * self.num_envs
        if seed is not None:
            seeds = seed if isinstance(seed, Sequence) else [int(seed) + robot for robot in range(self.num_envs)]
        options = dict(options or {})
        mask = np.asarray(options.pop("reset_mask", np.ones(self.num_envs, np.bool_)))
        if len(seeds) != self.num_envs or mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
            raise TaskError(f"reset takes {self.num_envs} seeds and a reset_mask of as many booleans, one of them true")
        self._begin_episodes(mask, seeds, options)
        return self._observations.copy(), _masked(self._info(), mask)

    def _begin_episodes(self, mask: BoolArray, seeds: Sequence[int | None], options: dict[str, Any]) -> None:
        self._batch.begin(
            lambda robot: self._begin_episode(robot, seeds[robot], options), np.flatnonzero(mask).tolist()
        )
        self._batch.finish()
        self._readings = self._batch.readings(self._goals)
        self._terms = {name: np.where(mask, 0.0, values) for name, values in self._terms.items()}

    def _begin_episode(self, robot: int, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        self._observations[robot], info = self.envs[robot].reset(seed=seed, options=options)
        self._starts[robot], self._goals[robot] = info["start"], info["goal"]
        self._differences[robot] = self.envs[robot].task.differences
        self._steps[robot], self._outcomes[robot], self._over[robot] = 0, _RUNNING, False
        self._turn_rates[robot] = 0.0

    # Step ---------------------------------------------------------------------------------------------------------

    def step(self, actions: FloatArray) -> BatchStep:
        """Drive for one control step; `actions` are (v, ω) in m/s and rad/s, (num_envs, 2)."""
        self.begin_step(actions)
        return self.finish_step()

    def begin_step(self, actions: FloatArray) -> None:
        """Begin a step: the robots drive in threads until finish_step() waits for them.

        Raises:
            gymnasium.error.ResetNeeded: a robot has no episode in progress, and is not reset automatically.
            TaskError: the actions have another shape.
        """
        if np.shape(actions) != (self.num_envs, 2):
            raise TaskError(f"actions are two numbers for each of {self.num_envs} robots, not {np.shape(actions)}")
        self._resetting = self._over.copy()
        if self._resetting.any() and (_NONE in self._outcomes or self.autoreset_mode != AutoresetMode.NEXT_STEP):
            raise gymnasium.error.ResetNeeded("a robot has no episode in progress: call reset() before step()")
        resetting, speeds = self._resetting.tolist(), self._wheel_speeds(np.asarray(actions, dtype=np.float64))

        def act(robot: int) -> None:
            if resetting[robot]:
                self._begin_episode(robot)
            else:
                physics = self.envs[robot].physics
                physics.set_wheel_speeds(*speeds[robot])
                physics.step(self._substeps)

        self._batch.begin(act, range(self.num_envs))

    def finish_step(self) -> BatchStep:
        """The step that was begun: observations, rewards, terminated, truncated, info."""
        self._batch.finish()
        previous, self._readings = self._readings, self._batch.readings(self._goals)
        driven = ~self._resetting
        self._judge(driven)
        self._reward(driven, previous.distance)
        self._observe(driven)
        terminated = (self._outcomes == _REACHED) | (self._outcomes == _CRASHED)
        truncated = (self._outcomes == _TIMEOUT) | (driven & (self._steps >= self._max_steps))
        self._over = terminated | truncated
        rewards = reduce(np.add, self._terms.values())
        final: dict[str, Any] = {}
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._over.any():
            final = self._begin_next(self._over.copy())
        info = _masked(self._info(), np.ones(self.num_envs, np.bool_))
        return self._observations.copy(), rewards, terminated, truncated, info | final

    def _begin_next(self, ended: BoolArray) -> dict[str, Any]:
        """Begin the next episode where one has ended; returns observations and info of the ends."""
        observations = np.full(self.num_envs, None, dtype=object)
        for robot in np.flatnonzero(ended):
            observations[robot] = self._observations[robot].copy()
        info = _masked(self._info(), ended)
        self._begin_episodes(ended, [None] * self.num_envs, {})
        return {"final_obs": observations, "_final_obs": ended, "final_info": info, "_final_info": ended}

    def _wheel_speeds(self, actions: FloatArray) -> list[list[float]]:
        """Speeds of the left and the right wheel, rad/s, as Navigation.before_step() commands one robot's."""
        config, drive = self.envs[0].task.config, self.envs[0].physics.drive
        linear = np.minimum(np.maximum(actions[:, 0], config.min_linear_velocity), config.max_linear_velocity)
        limit = config.max_angular_velocity
        commanded = np.minimum(np.maximum(actions[:, 1], -limit), limit)
        self._turn_rates, self._turn_changes = commanded, commanded - self._turn_rates
        turn_rate = min(limit, drive.max_angular_velocity)
        half_turn = 0.5 * drive.track * np.minimum(np.maximum(actions[:, 1], -turn_rate), turn_rate)
        speeds: list[list[float]] = (columns(linear - half_turn, linear + half_turn) / drive.radius).tolist()
        return speeds

    def _judge(self, driven: BoolArray) -> None:
        """Outcomes, as Navigation.after_step() judges one."""
        config = self.envs[0].task.config
        self._steps += driven
        outcomes = np.where(self._steps >= config.time_limit_steps, _TIMEOUT, _RUNNING)
        outcomes[self._readings.distance <= config.goal_radius] = _REACHED
        outcomes[self._batch.crashed] = _CRASHED
        self._outcomes = np.where(driven, outcomes, _RUNNING)

    def _reward(self, driven: BoolArray, previous_distance: FloatArray) -> None:
        """Terms of the rewards, as Reward.terms() computes those of one robot."""
        (progress, price, reach, crash, turn_price), outcomes = self._reward_constants, self._outcomes
        has_turn_price = "turn" in self._terms
        on_the_way = driven & ((outcomes == _RUNNING) | (outcomes == _TIMEOUT))
        self._terms = {
            "progress": np.where(on_the_way, progress * (previous_distance - self._readings.distance), 0.0),
            "time": np.where(on_the_way, -price, 0.0),
            "reach": np.where(outcomes == _REACHED, reach, 0.0),
            "crash": np.where(outcomes == _CRASHED, crash, 0.0),
        }
        if has_turn_price:
            self._terms["turn"] = np.where(driven, -turn_price * self._turn_changes**2, 0.0)

    def _observe(self, driven: BoolArray) -> None:
        """Observations of the robots that drove, as ScanStack.push() writes one."""
        flat, (_, beams) = self._observations, self.envs[0].scan_shape
        pushed = np.concatenate(
            (
                self._batch.ranges() / self.envs[0].physics.max_range - 0.5,
                flat[:, : -4 - beams],
                self._readings.velocity,
                self._observed_goals(),
            ),
            axis=1,
            dtype=np.float32,
            casting="same_kind",
        )
        self._observations = np.where(driven[:, None], pushed, flat)

    def _observed_goals(self) -> FloatArray:
        """The goals, as Navigation.observed_goal() gives one robot's."""
        limit = self.envs[0].task.config.goal_range
        return np.array([clip_goal((x, y), limit) for x, y in self._readings.goal.tolist()])

    def _info(self) -> dict[str, Any]:
        terms = self._terms
        return {
            "pose": self._readings.pose,
            "distance": self._readings.distance,
            "pushed": self._batch.pushed.copy(),
            "reward_terms": terms,
            "dense_reward": terms["progress"] + terms["time"],
            "start": self._starts.copy(),
            "goal": self._goals.copy(),
            "outcome": _OUTCOMES[self._outcomes],
            "is_success": self._outcomes == _REACHED,
            **_stack_values(self._differences),
        }

    # State ----------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, Any]:
        """Everything that the steps and episodes to come depend on: the state of each robot's environment."""
        return {"envs": [self._env_state(robot) for robot in range(self.num_envs)], "over": self._over.copy()}

    def _env_state(self, robot: int) -> dict[str, Any]:
        state, outcome = self.envs[robot].state(), int(self._outcomes[robot])
        if outcome == _NONE:
            return state
        terms = {name: float(values[robot]) for name, values in self._terms.items()}
        judged = {"outcome": str(_OUTCOMES[outcome]), "reward_terms": terms, "steps": int(self._steps[robot])}
        judged["turn_rate"] = float(self._turn_rates[robot])
        over = {"over": outcome != _RUNNING, "count": int(self._steps[robot])}
        return state | {"task": state["task"] | judged, "observation": self._observations[robot].copy()} | over

    def load_state(self, state: Mapping[str, Any]) -> tuple[Float32Array, dict[str, Any]]:
        """Restore what state() returned: what follows is equal to the last bit.

        Returns:
            The observations and the `info` of that instant.

        Raises:
            TaskError: it is of other tasks, or of another number of robots.
        """
        if len(state["envs"]) != self.num_envs:
            raise TaskError(f"the state is of {len(state['envs'])} robots, and the environment has {self.num_envs}")
        self._terms = {name: values.copy() for name, values in self._terms.items()}  # an info may hold the present ones
        for robot, (env, each) in enumerate(zip(self.envs, state["envs"], strict=True)):
            self._observations[robot], info = env.load_state(each)
            task = each["task"]
            self._goals[robot] = info["goal"] if info else 0.0
            self._differences[robot] = env.task.differences
            self._steps[robot], self._starts[robot] = task["steps"], task["start"]
            self._turn_rates[robot] = task.get("turn_rate", 0.0)
            self._outcomes[robot] = [*Outcome].index(task["outcome"]) if each["begun"] else _NONE
            for name, values in self._terms.items():
                values[robot] = task["reward_terms"][name]
            self._batch.read(robot)
        self._readings, self._over = self._batch.readings(self._goals), state["over"].copy()
        return self._observations.copy(), _masked(self._info(), self._outcomes != _NONE)

    # Pictures -----------------------------------------------------------------------------------------------------

    def render(self) -> tuple[Any, ...] | None:
        """A picture of each robot, uint8 (height, width, 3); None without a render mode."""
        return None if self.render_mode is None else tuple(env.render() for env in self.envs)

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads and free the renderers."""
        if hasattr(self, "_batch"):  # Gymnasium 1.1 closes what a refused argument left unfinished, too
            self._batch.close()
            for env in self.envs:
                env.close()


def _make_envs(tasks: Sequence[str], kwargs: Mapping[str, Any]) -> list[NavigationEnv]:
    """An environment for each; a copy costs a fraction of loading."""
    loaded = {task: NavigationEnv(task, **kwargs) for task in dict.fromkeys(tasks)}
    envs = [copy.deepcopy(loaded[task]) for task in tasks]
    for env in envs:
        env.np_random, env._np_random_seed = gymnasium.utils.seeding.np_random()  # the copies' are equal
    return envs


def _stack_values(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Mappings as one of arrays, by the keys that all have: text as objects, nested ones likewise."""
    return {
        key: _stack_values([row[key] for row in rows])
        if isinstance(value, Mapping)
        else np.array([row[key] for row in rows], dtype=object if isinstance(value, str) else None)
        for key, value in rows[0].items()
        if all(key in row for row in rows)
    }


def _masked(info: dict[str, Any], mask: BoolArray) -> dict[str, Any]:
    """The same info with Gymnasium's masks: `_<key>` says for which robots it holds."""
    values = {key: _masked(value, mask) if isinstance(value, dict) else value for key, value in info.items()}
    return values | {f"_{key}": mask for key in info}


def room_vector_env(scene: str = "", **arguments: Any) -> NavigationVectorEnv:
    """Robots in a room: `gymnasium.make_vec("asddpg/Nav-v0", num_envs=16, scene=PATH)`; TaskError without a scene."""
    return NavigationVectorEnv(check_scene(scene), **arguments)
