"""Episodes live in Foxglove, over a WebSocket of this machine: watched by anybody there, steered where that is allowed.

While nobody is connected a step costs next to nothing: it is only counted.
"""

import math
import time
from collections.abc import Callable, Mapping
from typing import Any, SupportsFloat

import foxglove
from foxglove.websocket import Capability, Parameter, StatusLevel, WebSocketServer

from asddpg.episodes.protocols import Episode, Observation, Step
from asddpg.errors import UserError
from asddpg.recording.live.controls import GOAL, GoalWish, LiveControls, Steering
from asddpg.recording.live.listener import LiveListener
from asddpg.recording.messages.channels import Channels
from asddpg.recording.messages.pose_messages import States
from asddpg.recording.messages.publisher import Publisher
from asddpg.recording.messages.scene_messages import Point, scene_message
from asddpg.recording.messages.step_message import told
from asddpg.recording.pictures.cameras import Stills
from asddpg.recording.samples import NANOSECONDS, Moment, MomentReader, Watched
from tasks.errors import TaskError
from tasks.scene.frames import BodyFrames
from tasks.scene.shapes import WORLD

HOST = "127.0.0.1"
GAP = 1.0  # s of the viewer's time between two episodes: long enough to see how the first one ended
_LATE = 0.1  # s behind the clock from which on time is let go rather than caught up
_LONGEST_WAIT = 0.2  # s; then it is looked whether a signal has come
_LAST_WORDS = 0.2  # s for what was told last to be sent


class LiveView:
    """Shows an environment's episodes to whoever is connected, at the pace they want.

    Without steering, as in training, episodes go on while nobody watches; with it they wait for a viewer.
    """

    def __init__(
        self,
        environment: Watched,
        port: int,
        speed: float,
        steering: Steering | None = None,
        cameras: Stills | None = None,
    ) -> None:
        """Serve.

        Args:
            environment: what is watched.
            port: of the WebSocket, 0 for a free one.
            speed: simulated seconds a second while somebody watches, 0 as fast as it goes.
            steering: what viewers may change.
            cameras: whose pictures are shown too; they are taken while somebody watches.

        Raises:
            UserError: the port cannot be had.
        """
        self._physics, self._steering = environment.physics, steering
        self._channels = Channels(cameras.names if cameras else ())
        self._reader = MomentReader(environment, cameras)
        model = self._physics.model.ptr
        states = States(BodyFrames.from_model(model), environment.scan_shape)
        self._publisher = Publisher(self._channels.log, states, scene_message(model))
        self._controls = LiveControls(speed, steering)
        self._listener = LiveListener(self._controls, self._refuse)
        self._pace = _Pace()
        self.stops: Callable[[], bool] = lambda: False  # whether whoever drives has been asked to stop: waiting ends
        self._episode: Episode | None = None
        self._server: WebSocketServer | None = None  # while it is made, viewers may already ask for something
        self._server = _serve(port, self._channels.context, self._listener)

    @property
    def port(self) -> int:
        """Where it is served."""
        assert self._server is not None
        return self._server.port

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Show the beginning."""
        self._number, self._episode = -1, None
        self._start: Point = info["pose"][:2]
        self._driven: list[tuple[str, Point]] = []
        self._told = 0.0
        if self._is_idle:
            return
        self._observation = observation
        self._publish_goal(self._physics.goal())
        self._listener.take_newcomer()
        moment = self._now()
        self._tell_time(moment)
        self._publisher.tell([moment])
        self._hold(0.0)

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Show a step, and wait until the next is due."""
        self._number += 1
        self._driven.append((step.decision.driver.value, step.info["pose"][:2]))
        if self._is_idle:
            return
        self._observation = step.next_observation
        moment = told(self._reader.step(step)._replace(number=self._number))
        elapsed = self._tell_time(moment)
        if self._listener.take_newcomer():
            self._publisher.take_up(moment, self._start, self._driven[:-1])
        self._publisher.tell([moment])
        if not (step.terminated or step.truncated):
            self._hold(min(elapsed, GAP))

    def end_episode(self, episode: Episode) -> None:
        """Show how it ended."""
        self._episode = episode
        if not self._is_idle:
            self._publisher.end(episode)
            self._hold(GAP)
        self._publisher.begins_at += round((self._physics.data.ptr.time + GAP) * NANOSECONDS)

    def close(self) -> None:
        """Let the viewers go; to be called by the thread that drives."""
        assert self._server is not None
        if self._listener.is_watched:
            time.sleep(_LAST_WORDS)
        server, self._server = self._server, None  # first: nobody may ask anything of one that is being stopped
        server.stop()

    # Showing ------------------------------------------------------------------------------------------------------

    @property
    def _is_idle(self) -> bool:
        return self._steering is None and not self._listener.is_watched

    def _now(self) -> Moment:
        return told(self._reader.begin(self._observation)._replace(number=self._number))

    def _tell_time(self, moment: Moment) -> float:
        """Set the viewer's clock, before the messages that it stamps; gives the seconds since it was set last."""
        assert self._server is not None
        self._server.broadcast_time(self._publisher.begins_at + moment.time)
        told, self._told = self._told, moment.time / NANOSECONDS
        return self._told - told

    def _take_up(self) -> None:
        """Everything as it stands, for somebody who has just come or after something was moved."""
        moment = self._now()
        self._tell_time(moment)
        self._publisher.take_up(moment, self._start, self._driven)
        if self._episode is not None:
            self._publisher.end(self._episode)

    # Waiting ------------------------------------------------------------------------------------------------------

    def _hold(self, seconds: float) -> None:
        """Wait as the viewer has it, with so much simulated time since the last wait; heed what is asked for."""
        while True:
            self._controls.woken.clear()
            self._heed()
            rest = self._rest(seconds)
            if rest <= 0.0 or self.stops():
                break
            self._controls.woken.wait(min(rest, _LONGEST_WAIT))
        self._pace.go(seconds, self._controls.speed)

    def _rest(self, seconds: float) -> float:
        """Seconds still to wait."""
        if not self._listener.is_watched:
            return 0.0 if self._steering is None else math.inf
        if self._controls.paused:
            return 0.0 if self._controls.take_step() else math.inf
        return self._pace.rest(seconds, self._controls.speed)

    def _heed(self) -> None:
        if self._listener.take_newcomer():
            self._take_up()
        while not self._controls.goals.empty():
            self._move_goal(self._controls.goals.get())

    # Steering -----------------------------------------------------------------------------------------------------

    def _move_goal(self, wish: GoalWish) -> None:
        assert self._steering is not None
        try:
            x, y = self._in_world(wish)
            self._steering.set_goal(x, y)
        except (UserError, TaskError) as error:
            self._refuse(str(error))
            return
        self._publish_goal((x, y))
        self._take_up()
        self._publisher.say(f"the viewer moves the goal to ({x:.2f}, {y:.2f})")

    def _in_world(self, wish: GoalWish) -> Point:
        """A wish in the world frame: a view that follows the robot gives places in the robot's."""
        if wish.frame in ("", WORLD):
            return wish.x, wish.y
        if wish.frame != "base":
            raise UserError(f"a goal is given in the frame {WORLD} or base, not {wish.frame!r}")
        pose = self._physics.pose()
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        return pose.x + cos * wish.x - sin * wish.y, pose.y + sin * wish.x + cos * wish.y

    def _publish_goal(self, goal: Point) -> None:
        self._controls.goal = goal
        if self._steering is not None and self._server is not None:
            self._server.publish_parameter_values([Parameter(GOAL, value=list(goal))])

    def _refuse(self, sentence: str) -> None:
        if self._server is not None:
            self._server.publish_status(sentence, StatusLevel.Warning)


class _Pace:
    """Simulated time beside the clock on the wall."""

    def __init__(self) -> None:
        self._last = time.monotonic()  # when the last wait should have ended

    def rest(self, seconds: float, speed: float) -> float:
        """Seconds until so much simulated time has gone by since then."""
        return self._last + seconds / speed - time.monotonic() if speed else 0.0

    def go(self, seconds: float, speed: float) -> None:
        """The wait is over."""
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
