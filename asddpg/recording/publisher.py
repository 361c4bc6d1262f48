"""Tells episodes on the channels of a recording."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from foxglove.messages import Log, LogLevel

from asddpg.recording.channels import Channels
from asddpg.recording.moments import Moment, MomentReader, Watched
from asddpg.recording.robot_messages import (
    goal_pose,
    kept_ranges,
    laser_scan,
    odometry,
    on_grid,
    timestamp,
    transforms,
)
from asddpg.recording.scene_messages import PathUpdate, Point, scene_update
from asddpg.recording.step_message import cmd_vel_json, outcome_json, step_json
from asddpg.types import Episode
from tasks.scene_parts import scene_parts

STEPS_BETWEEN_PATHS = 10  # the path so far is told anew each time, whole


class Publisher:
    """One environment's episodes, one after the other."""

    def __init__(self, channels: Channels, environment: Watched, reader: MomentReader) -> None:
        """Tell of an environment what a reader reads in it."""
        self._channels = channels
        num_scans, self._num_beams = environment.scan_shape
        self._velocity = slice(num_scans * self._num_beams, num_scans * self._num_beams + 2)
        self._frames = reader.frames
        self._transforms = transforms(reader.frames.frames)
        self._laser_scan, self._odometry = laser_scan(self._num_beams), odometry()
        self._base = [frame.name for frame in reader.frames.frames].index("base")
        self._scene = scene_update(scene_parts(environment.physics.model.ptr))
        self._path = PathUpdate()
        self._goal = (0.0, 0.0)
        self._time = 0
        self.begins_at = 0  # ns, added to the times of an episode

    def begin(self, moment: Moment) -> None:
        """The room, the goal, and how things stand."""
        x, y = self._tell_setting(moment)
        self._path.begin((x, y))
        self._channels.path.log(self._path.message(), log_time=self._time)
        self.say(f"from ({x:.2f}, {y:.2f}) to the goal ({self._goal[0]:.2f}, {self._goal[1]:.2f})")

    def take_up(self, moment: Moment, start: Point, driven: Iterable[tuple[str, Point]]) -> None:
        """What begin() told and what has changed since, for somebody who comes in the middle of an episode.

        Args:
            moment: now.
            start: where the episode began, m.
            driven: who has driven since, and to where, step by step.
        """
        self._tell_setting(moment)
        self._path.begin(start)
        for driver, place in driven:
            self._path.extend(driver, place)
        self._channels.path.log(self._path.message(), log_time=self._time)

    def _tell_setting(self, moment: Moment) -> Point:
        """All but the path; gives where the base is."""
        channels = self._channels
        self._time = time = self.begins_at + moment.time
        channels.scene.log(self._scene, log_time=time)
        channels.outcome.log(outcome_json(None), time)
        self._tell_goal(moment.goal)
        ((x, y),) = self._tell_states([moment])
        self._tell_pictures(moment)
        return x, y

    def steps(self, moments: Sequence[Moment]) -> None:
        """Steps, and how things stand after each; several at once take half the time."""
        channels = self._channels
        for moment, place in zip(moments, self._tell_states(moments), strict=True):
            assert moment.step is not None
            self._time = time = self.begins_at + moment.time
            channels.step.log(step_json(moment), time)
            channels.cmd_vel.log(cmd_vel_json(moment), time)
            if moment.goal != self._goal:
                self._tell_goal(moment.goal)
            self._tell_pictures(moment)
            self._path.extend(moment.step.decision.driver.value, place)
            if moment.number % STEPS_BETWEEN_PATHS == 0:
                channels.path.log(self._path.message(), log_time=time)

    def end(self, episode: Episode) -> None:
        """How it ended."""
        self._channels.path.log(self._path.message(), log_time=self._time)
        self._channels.outcome.log(outcome_json(episode), self._time)
        self.say(f"{episode.outcome} after {episode.steps} steps, {episode.path_length:.1f} m driven")

    def say(self, text: str, level: LogLevel = LogLevel.Info) -> None:
        """A line of the log."""
        message = Log(timestamp=timestamp(self._time), level=level, message=text, name="asddpg")
        self._channels.log.log(message, log_time=self._time)

    def _tell_states(self, moments: Sequence[Moment]) -> Iterator[Point]:
        """Where everything is and what is seen, a moment at a time; yields the robot's place."""
        channels = self._channels
        times = [self.begins_at + moment.time for moment in moments]
        observations = np.stack([moment.observation for moment in moments])
        places = on_grid(self._frames.relative(np.stack([moment.bodies for moment in moments])))
        bases = places[:, self._base]
        motions = np.concatenate((bases, on_grid(observations[:, self._velocity])), axis=1)
        told = zip(
            times,
            self._transforms.fill(times, places.reshape(len(times), -1)),
            self._laser_scan.fill(times, kept_ranges(observations, self._num_beams)),
            self._odometry.fill(times, motions),
            bases[:, :2].tolist(),
            strict=True,
        )
        for time, frames, scan, motion, (x, y) in told:
            channels.tf.log(frames, time)
            channels.scan.log(scan, time)
            channels.odom.log(motion, time)
            yield x, y

    def _tell_pictures(self, moment: Moment) -> None:
        for camera, picture in moment.pictures.items():
            self._channels.log_picture(camera, picture, timestamp(self._time), self._time)

    def _tell_goal(self, goal: tuple[float, float]) -> None:
        self._goal = goal
        self._channels.goal.log(goal_pose(goal, self._time), log_time=self._time)
