"""Tells episodes: what a recording has of them, message by message."""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np
from foxglove.messages import Log, LogLevel

from asddpg.recording.moments import Moment, MomentReader, Watched
from asddpg.recording.robot_messages import goal_pose, kept_ranges, on_grid, picture_message, states, timestamp
from asddpg.recording.scene_messages import PathUpdate, Point, scene_update
from asddpg.recording.step_message import cmd_vel_json, outcome_json, step_json
from asddpg.recording.topics import CAMERA, CMD_VEL, GOAL, LOG, ODOM, OUTCOME, PATH, SCAN, SCENE, STEP, TF
from asddpg.types import Episode
from tasks.scene_parts import scene_parts

STEPS_BETWEEN_PATHS = 10  # the path so far is told anew each time, whole

LogMessage = Callable[[str, bytes, int], object]  # gets topic, message and simulated ns


class Publisher:
    """One environment's episodes, one after the other."""

    def __init__(self, log: LogMessage, environment: Watched, reader: MomentReader, is_video: bool = False) -> None:
        """Tell of an environment what a reader reads in it.

        Args:
            log: gets the messages.
            environment: what is watched.
            reader: gives the moments.
            is_video: whether their pictures are H.264 and not JPEG.
        """
        self._log, self._is_video = log, is_video
        num_scans, self._num_beams = environment.scan_shape
        self._velocity = slice(num_scans * self._num_beams, num_scans * self._num_beams + 2)
        self._frames = reader.frames
        self._base = [frame.name for frame in reader.frames.frames].index("base")
        self._states = states(reader.frames.frames, self._num_beams)
        self._scene = scene_update(scene_parts(environment.physics.model.ptr)).encode()
        self._path = PathUpdate()
        self._goal = (0.0, 0.0)
        self._time = 0
        self.begins_at = 0  # ns, added to the times of an episode

    def tell(self, moments: Sequence[Moment]) -> None:
        """An episode's beginning, its steps, one after the other; several at once take half the time."""
        for moment, place in self._tell_states(moments):
            if moment.step is None:
                self._begin(moment, place)
            else:
                self._step(moment, moment.step.decision.driver.value, place)

    def take_up(self, moment: Moment, start: Point, driven: Iterable[tuple[str, Point]]) -> None:
        """What there was to tell of a beginning and has changed since, for somebody who comes in the middle of it.

        Args:
            moment: now.
            start: where the episode began, m.
            driven: who has driven since, and to where, step by step.
        """
        (_,) = self._tell_states([moment])
        self._tell_setting(moment)
        self._path.begin(start)
        for driver, place in driven:
            self._path.extend(driver, place)
        self._tell_path()

    def end(self, episode: Episode) -> None:
        """How it ended."""
        self._tell_path()
        self._log(OUTCOME, outcome_json(episode), self._time)
        self.say(f"{episode.outcome} after {episode.steps} steps, {episode.path_length:.1f} m driven")

    def say(self, text: str, level: LogLevel = LogLevel.Info) -> None:
        """A line of the log."""
        message = Log(timestamp=timestamp(self._time), level=level, message=text, name="asddpg")
        self._log(LOG, message.encode(), self._time)

    def _begin(self, moment: Moment, place: Point) -> None:
        """The room, the goal, and how things stand."""
        self._tell_setting(moment)
        self._path.begin(place)
        self._tell_path()
        (x, y), (goal_x, goal_y) = place, moment.goal
        self.say(f"from ({x:.2f}, {y:.2f}) to the goal ({goal_x:.2f}, {goal_y:.2f})")

    def _tell_setting(self, moment: Moment) -> None:
        """The room, the goal, and that nothing has ended."""
        self._log(SCENE, self._scene, self._time)
        self._log(OUTCOME, outcome_json(None), self._time)
        self._tell_goal(moment.goal)
        self._tell_pictures(moment)

    def _step(self, moment: Moment, driver: str, place: Point) -> None:
        """What was chosen in a step, and what came of it."""
        self._log(STEP, step_json(moment), self._time)
        self._log(CMD_VEL, cmd_vel_json(moment), self._time)
        if moment.goal != self._goal:
            self._tell_goal(moment.goal)
        self._tell_pictures(moment)
        self._path.extend(driver, place)
        if (moment.number + 1) % STEPS_BETWEEN_PATHS == 0:
            self._tell_path()

    def _tell_states(self, moments: Sequence[Moment]) -> Iterator[tuple[Moment, Point]]:
        """Where everything is and what is seen, a moment at a time; yields the robot's place."""
        times = [self.begins_at + moment.time for moment in moments]
        observations = np.array([moment.observation for moment in moments])
        places = self._frames.relative([moment.bodies for moment in moments])
        motions = places[:, self._base], observations[:, self._velocity]
        kept = on_grid(np.concatenate((*motions, places.reshape(len(times), -1)), axis=1))
        told = self._states.fill(times, np.concatenate((kept, kept_ranges(observations, self._num_beams)), axis=1))
        for moment, time, (frames, scan, motion), (x, y) in zip(
            moments, times, told, kept[:, :2].tolist(), strict=True
        ):
            self._time = time
            self._log(TF, frames, time)
            self._log(SCAN, scan, time)
            self._log(ODOM, motion, time)
            yield moment, (x, y)

    def _tell_path(self) -> None:
        self._log(PATH, self._path.message().encode(), self._time)

    def _tell_pictures(self, moment: Moment) -> None:
        for camera, picture in moment.pictures.items():
            message = picture_message(camera, picture, self._time, self._is_video)
            self._log(f"{CAMERA}{camera}", message.encode(), self._time)

    def _tell_goal(self, goal: Point) -> None:
        self._goal = goal
        self._log(GOAL, goal_pose(goal, self._time).encode(), self._time)
