"""Episodes live in Foxglove, over a WebSocket of this machine; in play they can be steered too.

Without a subscriber a step costs next to nothing: it is only counted.
"""

import math
import time
from collections.abc import Callable, Mapping
from typing import Any, SupportsFloat

import foxglove
from foxglove.websocket import Capability, Parameter, StatusLevel, WebSocketServer

from asddpg.episodes.protocols import Episode, Observation, Step
from asddpg.errors import UserError
from asddpg.recording.live.controls import GOAL, GoalRequest, LiveControls, Steering
from asddpg.recording.live.listener import LiveListener
from asddpg.recording.messages.channels import Channels
from asddpg.recording.messages.publisher import Publisher
from asddpg.recording.messages.scan_pose_messages import PoseEncoder
from asddpg.recording.messages.scene_messages import Point, scene_message
from asddpg.recording.pictures.cameras import Stills
from asddpg.recording.samples import NANOSECONDS, ReadNavigation, Sample, Sampler
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.scene.shapes import WORLD

HOST = "127.0.0.1"
GAP = 1.0  # s of the viewer's time between two episodes: long enough to see how the first one ended
_LATE = 0.1  # s behind the clock beyond which lost time is not caught up
_LONGEST_WAIT = 0.2  # s between two looks for a signal
_LAST_MESSAGES = 0.2  # s for the last messages to be sent


class LiveView:
    """Publishes an environment's episodes to its viewers, at the pace they choose.

    Without steering, as in training, episodes go on while there is no viewer; with it they wait for one.
    """

    def __init__(
        self,
        environment: NavigationEnv,
        port: int,
        speed: float,
        steering: Steering | None = None,
        cameras: Stills | None = None,
        read_navigation: ReadNavigation | None = None,
    ) -> None:
        """Start the server.

        Args:
            environment: what is shown.
            port: of the WebSocket, 0 for a free one.
            speed: simulated seconds a second while there are viewers, 0 as fast as possible.
            steering: what viewers may change.
            cameras: their pictures are shown too, while there are viewers.
            read_navigation: map and plan of a driver that plans, which are shown too.

        Raises:
            UserError: the port is not available.
        """
        self._physics, self._steering = environment.physics, steering
        self._channels = Channels(cameras.names if cameras else (), is_planned=read_navigation is not None)
        self._sampler = Sampler(environment, cameras, read_navigation)
        model = self._physics.model.ptr
        poses = PoseEncoder(environment)
        self._publisher = Publisher(self._channels.log, poses, scene_message(model))
        self._controls = LiveControls(speed, steering)
        self._listener = LiveListener(self._controls, self._refuse)
        self._pace = _Pace()
        self.stops: Callable[[], bool] = lambda: False  # whether the program shall stop: ends waiting
        self._episode: Episode | None = None
        self._begin_path(self._physics.pose()[:2])
        self._server: WebSocketServer | None = None  # viewers may send requests before it is returned
        self._server = _serve(port, self._channels.context, self._listener)

    @property
    def port(self) -> int:
        """Of the WebSocket."""
        assert self._server is not None
        return self._server.port

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Show the beginning."""
        self._begin_path(info["pose"][:2])
        if self._is_idle:
            return
        self._observation = observation
        if "room" in info:  # another one in each episode
            self._publisher.change_scene(scene_message(self._physics.model.ptr))
        self._publish_goal(self._physics.goal())
        self._listener.take_subscription()
        sample = self._sample()
        self._broadcast_time(sample)
        self._publisher.publish([sample])
        self._wait(0.0)

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Show a step, and wait until the next is due."""
        self._number += 1
        self._driven.append((step.decision.driver.value, step.info["pose"][:2]))
        if self._is_idle:
            return
        self._observation = step.next_observation
        if self._physics.goal() != self._controls.goal:  # a mission goes on to its next target
            self._publish_goal(self._physics.goal())
        sample = self._sampler.sample(self._number, step, step.next_observation)
        elapsed = self._broadcast_time(sample)
        if self._listener.take_subscription():
            self._publisher.publish_state(sample, self._start, self._driven[:-1])
        self._publisher.publish([sample])
        if not (step.terminated or step.truncated):
            self._wait(min(elapsed, GAP))

    def end_episode(self, episode: Episode) -> None:
        """Show how it ended."""
        self._episode = episode
        if not self._is_idle:
            self._publisher.publish_end(episode)
            self._wait(GAP)
        self._publisher.offset += round((self._physics.data.ptr.time + GAP) * NANOSECONDS)

    def close(self) -> None:
        """Disconnect the viewers; to be called by the thread that drives."""
        assert self._server is not None
        if self._listener.has_viewers:
            time.sleep(_LAST_MESSAGES)
        server, self._server = self._server, None  # first: listeners must not use a server that is being stopped
        server.stop()

    # Publishing ---------------------------------------------------------------------------------------------------

    @property
    def _is_idle(self) -> bool:
        return self._steering is None and not self._listener.has_viewers

    def _begin_path(self, place: Point) -> None:
        self._start, self._number, self._published_time = place, -1, 0.0
        self._driven: list[tuple[str, Point]] = []  # driver and reached place of each step
        self._episode = None

    def _sample(self) -> Sample:
        return self._sampler.sample(self._number, None, self._observation)

    def _broadcast_time(self, sample: Sample) -> float:
        """Set the viewers' clock, before the messages of that time; returns the seconds since the last time."""
        assert self._server is not None
        self._server.broadcast_time(self._publisher.offset + sample.time)
        before, self._published_time = self._published_time, sample.seconds
        return self._published_time - before

    def _publish_state(self) -> None:
        """Publish the present state, for a new subscriber or after the goal was moved."""
        sample = self._sample()
        self._broadcast_time(sample)
        self._publisher.publish_state(sample, self._start, self._driven)
        if self._episode is not None:
            self._publisher.publish_end(self._episode)

    # Waiting ------------------------------------------------------------------------------------------------------

    def _wait(self, seconds: float) -> None:
        """Wait at the viewers' pace, with so much simulated time since the last wait; handle requests meanwhile."""
        while True:
            self._controls.wake_event.clear()
            self._handle_requests()
            rest = self._remaining(seconds)
            if rest <= 0.0 or self.stops():
                break
            self._controls.wake_event.wait(min(rest, _LONGEST_WAIT))
        self._pace.finish_wait(seconds, self._controls.speed)

    def _remaining(self, seconds: float) -> float:
        """Seconds still to wait."""
        if not self._listener.has_viewers:
            return 0.0 if self._steering is None else math.inf
        if self._controls.paused:
            return 0.0 if self._controls.take_single_step() else math.inf
        return self._pace.remaining(seconds, self._controls.speed)

    def _handle_requests(self) -> None:
        if self._listener.take_subscription():
            self._publish_state()
        while not self._controls.goals.empty():
            self._move_goal(self._controls.goals.get())

    # Steering -----------------------------------------------------------------------------------------------------

    def _move_goal(self, request: GoalRequest) -> None:
        assert self._steering is not None
        try:
            x, y = self._transform_to_world(request)
            self._steering.set_goal(x, y)
        except (UserError, TaskError) as error:
            self._refuse(str(error))
            return
        self._publish_goal((x, y))
        self._publish_state()
        self._publisher.publish_log(f"the viewer moves the goal to ({x:.2f}, {y:.2f})")

    def _transform_to_world(self, request: GoalRequest) -> Point:
        """The requested goal in the world frame: a view that follows the robot gives places in the robot's."""
        if request.frame in ("", WORLD):
            return request.x, request.y
        if request.frame != "base":
            raise UserError(f"a goal is given in the frame {WORLD} or base, not {request.frame!r}")
        pose = self._physics.pose()
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        return pose.x + cos * request.x - sin * request.y, pose.y + sin * request.x + cos * request.y

    def _publish_goal(self, goal: Point) -> None:
        self._controls.goal = goal
        if self._steering is not None and self._server is not None:
            self._server.publish_parameter_values([Parameter(GOAL, value=list(goal))])

    def _refuse(self, sentence: str) -> None:
        if self._server is not None:
            self._server.publish_status(sentence, StatusLevel.Warning)


class _Pace:
    """Keeps simulated time in step with the wall clock."""

    def __init__(self) -> None:
        self._last = time.monotonic()  # when the last wait should have ended

    def remaining(self, seconds: float, speed: float) -> float:
        """Seconds until so much simulated time has passed since the last wait."""
        return self._last + seconds / speed - time.monotonic() if speed else 0.0

    def finish_wait(self, seconds: float, speed: float) -> None:
        """Reset the count."""
        now = time.monotonic()
        due = self._last + seconds / speed if speed else now
        self._last = min(max(due, now - _LATE), now)


def _serve(port: int, context: foxglove.Context, listener: LiveListener) -> WebSocketServer:
    try:
        return foxglove.start_server(
            name="asddpg",
            host=HOST,
            port=port,
            capabilities=[Capability.Time, Capability.Parameters, Capability.ClientPublish],
            server_listener=listener,
            supported_encodings=["json"],
            context=context,
        )
    except (RuntimeError, OSError) as error:
        reason = str(error).rpartition(": ")[2].partition(" (")[0]
        raise UserError(f"port {port} cannot be served at: {reason}; choose another port=, 0 for a free one") from error
