"""Tells episodes: what a recording has of them, message by message."""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from foxglove.messages import Log, LogLevel

from asddpg.episodes.protocols import Driver, Episode
from asddpg.recording.messages.channels import LogMessage
from asddpg.recording.messages.path_message import PathMessage
from asddpg.recording.messages.pose_messages import States
from asddpg.recording.messages.robot_messages import goal_pose, picture_message, timestamp
from asddpg.recording.messages.scene_messages import Point
from asddpg.recording.messages.step_message import outcome_json, reward_of
from asddpg.recording.messages.topics import CAMERA, CMD_VEL, GOAL, LOG, ODOM, OUTCOME, PATH, SCAN, SCENE, STEP, TF
from asddpg.recording.samples import Moment

STEPS_BETWEEN_PATHS = 2  # the path so far is told anew each time, whole; in 2 the robot hides where it ends
LONG_PATH = 100  # a long one is told whenever it has grown by a part of so many, or its messages would grow squared


class Publisher:
    """One environment's episodes, one after the other."""

    def __init__(
        self, log: Mapping[str, LogMessage], states: States, scene: bytes | None, is_video: bool = False
    ) -> None:
        """Tell episodes of a scene.

        Args:
            log: gets the messages, by topic.
            states: tells where everything is.
            scene: the message of /scene; None where it is told already.
            is_video: whether cameras' pictures are H.264 and not JPEG.
        """
        self._log, self._states, self._scene, self._is_video = log, states, scene, is_video
        self._path = PathMessage()
        self._goal = (0.0, 0.0)
        self._time = 0
        self.begins_at = 0  # ns, added to the times of an episode

    def tell(self, moments: Sequence[Moment]) -> None:
        """An episode's beginning, its steps, one after the other; many at once take a fraction of the time."""
        for moment, place in self._tell_states(moments):
            if moment.driver:
                self._step(moment, place)
            else:
                self._begin(moment, place)

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

    def cut(self, moments: Sequence[Moment]) -> Episode:
        """Figures of an episode that is broken off after some moments."""
        places = [self._states.place(moment) for moment in moments]
        return Episode(
            "cut",
            len(moments) - 1,
            sum(reward_of(moment) for moment in moments),
            sum(moment.driver == Driver.CONTROLLER for moment in moments),
            sum(itertools.starmap(math.dist, itertools.pairwise(places))),
        )

    def end(self, episode: Episode) -> None:
        """How it ended."""
        self._tell_path()
        self._log[OUTCOME](outcome_json(episode), self._time)
        self.say(f"{episode.outcome} after {episode.steps} steps, {episode.path_length:.1f} m driven")

    def say(self, text: str, level: LogLevel = LogLevel.Info) -> None:
        """A line of the log."""
        message = Log(timestamp=timestamp(self._time), level=level, message=text, name="asddpg")
        self._log[LOG](message.encode(), self._time)

    def _begin(self, moment: Moment, place: Point) -> None:
        """The room, the goal, and how things stand."""
        self._tell_setting(moment)
        self._path.begin(place)
        self._tell_path()
        (x, y), (goal_x, goal_y) = place, self._goal
        self.say(f"from ({x:.2f}, {y:.2f}) to the goal ({goal_x:.2f}, {goal_y:.2f})")

    def _tell_setting(self, moment: Moment) -> None:
        """The room, the goal, and that nothing has ended."""
        if self._scene is not None:
            self._log[SCENE](self._scene, self._time)
        self._log[OUTCOME](outcome_json(None), self._time)
        self._tell_goal(self._states.goal(moment))
        self._tell_pictures(moment)

    def _step(self, moment: Moment, place: Point) -> None:
        """What was chosen in a step, and what came of it."""
        self._log[STEP](moment.step, self._time)
        self._log[CMD_VEL](moment.command, self._time)
        goal = self._states.goal(moment)
        if goal != self._goal:
            self._tell_goal(goal)
        self._tell_pictures(moment)
        self._path.extend(moment.driver, place)
        steps = moment.number + 1
        if steps % max(STEPS_BETWEEN_PATHS, steps // LONG_PATH) == 0:
            self._tell_path()

    def _tell_states(self, moments: Sequence[Moment]) -> Iterator[tuple[Moment, Point]]:
        """Where everything is and what is seen, a moment at a time; yields the robot's place."""
        times = [self.begins_at + moment.time for moment in moments]
        tell_frames, tell_scan, tell_motion = self._log[TF], self._log[SCAN], self._log[ODOM]
        for moment, time, (frames, scan, motion, place) in zip(
            moments, times, self._states.of(moments, times), strict=True
        ):
            self._time = time
            tell_frames(frames, time)
            tell_scan(scan, time)
            tell_motion(motion, time)
            yield moment, place

    def _tell_path(self) -> None:
        self._log[PATH](self._path.encode(), self._time)

    def _tell_pictures(self, moment: Moment) -> None:
        for camera, picture in moment.pictures.items():
            message = picture_message(camera, picture, self._time, self._is_video)
            self._log[f"{CAMERA}{camera}"](message.encode(), self._time)

    def _tell_goal(self, goal: Point) -> None:
        self._goal = goal
        self._log[GOAL](goal_pose(goal, self._time).encode(), self._time)
