"""Publishes episodes message by message, to a recording or to the live view."""

from collections.abc import Iterable, Mapping, Sequence

from foxglove.messages import Log, LogLevel

from asddpg.episodes.protocols import Episode, Step
from asddpg.recording.messages.channels import LogMessage
from asddpg.recording.messages.goal_camera_messages import goal_pose, make_timestamp, picture_message
from asddpg.recording.messages.navigation_messages import NavigationPublisher
from asddpg.recording.messages.path_message import PathMessage
from asddpg.recording.messages.scan_pose_messages import PoseEncoder, PoseMessages
from asddpg.recording.messages.scene_messages import Point
from asddpg.recording.messages.step_message import encode_command, encode_outcome, encode_step
from asddpg.recording.messages.topics import CAMERA, CMD_VEL, GOAL, LOG, ODOM, OUTCOME, PATH, SCAN, SCENE, STEP, TF
from asddpg.recording.samples import Sample

STEPS_BETWEEN_PATHS = 2  # the whole path is published each time; within 2 steps the robot covers its end
LONG_PATH = 100  # steps; a longer path is published at each 1 % of growth: all its messages together stay linear


class Publisher:
    """Publishes one environment's episodes, one after the other."""

    def __init__(self, log: Mapping[str, LogMessage], poses: PoseEncoder, scene: bytes, is_video: bool = False) -> None:
        """Publish episodes of a scene.

        Args:
            log: takes the messages, by topic.
            poses: encodes moving frames.
            scene: the message of /scene.
            is_video: whether cameras' pictures are H.264 and not JPEG.
        """
        self._log, self._poses, self._scene, self._is_video = log, poses, scene, is_video
        self._path = PathMessage((0.0, 0.0))
        self._navigation = NavigationPublisher(log)
        self._goal = (0.0, 0.0)
        self._time = 0
        self.offset = 0  # ns, added to the times of an episode

    def change_scene(self, scene: bytes) -> None:
        """Take another message of /scene, from the next episode on."""
        self._scene = scene

    def publish(self, samples: Sequence[Sample]) -> None:
        """Publish consecutive samples of an episode; a batch costs a fraction of one by one."""
        for sample, messages in zip(samples, self._poses.encode(samples, self.offset), strict=True):
            if sample.step is None:
                self._publish_poses(messages)
                self._publish_beginning(sample, messages.place)
            else:
                self._publish_decision(sample, sample.step, messages.begin)
                self._publish_poses(messages)
                self._publish_step(sample, sample.step, messages.place)

    def publish_state(self, sample: Sample, start: Point, driven: Iterable[tuple[str, Point]]) -> None:
        """Publish the full state, for a subscriber in the middle of an episode.

        Args:
            sample: the present one.
            start: where the episode began, m.
            driven: driver and reached place of each step since.
        """
        (messages,) = self._poses.encode([sample], self.offset)
        self._publish_poses(messages)
        self._publish_setting(sample)
        self._publish_navigation(sample)
        self._path = PathMessage(start)
        for driver, place in driven:
            self._path.extend(driver, place)
        self._publish_path()

    def publish_end(self, episode: Episode) -> None:
        """Publish how the episode ended."""
        self._publish_path()
        self._log[OUTCOME](encode_outcome(episode), self._time)
        self.publish_log(f"{episode.outcome} after {episode.steps} steps, {episode.path_length:.1f} m driven")

    def publish_log(self, text: str) -> None:
        """Publish a line of the log."""
        message = Log(timestamp=make_timestamp(self._time), level=LogLevel.Info, message=text, name="asddpg")
        self._log[LOG](message.encode(), self._time)

    def _publish_beginning(self, sample: Sample, place: Point) -> None:
        self._publish_setting(sample)
        self._publish_navigation(sample)
        self._path = PathMessage(place)
        self._publish_path()
        (x, y), (goal_x, goal_y) = place, self._goal
        self.publish_log(f"from ({x:.2f}, {y:.2f}) to the goal ({goal_x:.2f}, {goal_y:.2f})")

    def _publish_setting(self, sample: Sample) -> None:
        """The room, the goal, the pictures, and that the episode is running."""
        self._navigation.begin()
        self._log[SCENE](self._scene, self._time)
        self._log[OUTCOME](encode_outcome(None), self._time)
        self._publish_goal(self._poses.read_goal(sample))
        self._publish_pictures(sample)

    def _publish_decision(self, sample: Sample, step: Step, begin: int) -> None:
        """Publish what held from the step's beginning on: the command, and a goal that was moved before it."""
        self._time = begin
        self._log[CMD_VEL](encode_command(step), begin)
        goal = self._poses.read_goal(sample)
        if goal != self._goal:
            self._publish_goal(goal)

    def _publish_poses(self, messages: PoseMessages) -> None:
        self._time = messages.time
        for time, transforms in messages.transforms:
            self._log[TF](transforms, time)
        self._log[SCAN](messages.scan, messages.time)
        self._log[ODOM](messages.odometry, messages.time)

    def _publish_step(self, sample: Sample, step: Step, place: Point) -> None:
        """Publish the rest; /step comes last, so that a recording that breaks off has whole steps up to it."""
        self._publish_pictures(sample)
        self._publish_navigation(sample)
        self._path.extend(step.decision.driver.value, place)
        steps = sample.number + 1
        if steps % max(STEPS_BETWEEN_PATHS, steps // LONG_PATH) == 0:
            self._publish_path()
        self._log[STEP](encode_step(sample, step), self._time)

    def _publish_path(self) -> None:
        self._log[PATH](self._path.encode(), self._time)

    def _publish_navigation(self, sample: Sample) -> None:
        if sample.navigation is not None:
            self._navigation.publish(sample.navigation, self._time)

    def _publish_pictures(self, sample: Sample) -> None:
        for camera, picture in sample.pictures.items():
            message = picture_message(camera, picture, self._time, self._is_video)
            self._log[f"{CAMERA}{camera}"](message.encode(), self._time)

    def _publish_goal(self, goal: Point) -> None:
        self._goal = goal
        self._log[GOAL](goal_pose(goal, self._time).encode(), self._time)
