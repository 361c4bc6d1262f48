"""A recording's channels: one set a process, from which files and the live view take their messages."""

from collections.abc import Callable
from typing import Any

import foxglove
from foxglove._foxglove_py import BaseChannel
from foxglove.channels import (
    CompressedImageChannel,
    CompressedVideoChannel,
    LogChannel,
    PoseInFrameChannel,
    SceneUpdateChannel,
)
from foxglove.messages import CompressedImage, CompressedVideo, FrameTransforms, LaserScan, Odometry, Timestamp

from asddpg.recording import topics


class Channels:
    """A context with a channel for each topic; whatever is open on the context gets what is logged."""

    def __init__(self, cameras: tuple[str, ...] = (), video: bool = False) -> None:
        """Make the channels.

        Args:
            cameras: names of those whose pictures are shown.
            video: whether they come as H.264 and not as JPEG.
        """
        self.context = foxglove.Context()
        context = self.context
        self.tf = self._encoded(topics.TF, FrameTransforms.get_schema())
        self.scan = self._encoded(topics.SCAN, LaserScan.get_schema())
        self.odom = self._encoded(topics.ODOM, Odometry.get_schema())
        self.scene = SceneUpdateChannel(topics.SCENE, context=context)
        self.path = SceneUpdateChannel(topics.PATH, context=context)
        self.goal = PoseInFrameChannel(topics.GOAL, context=context)
        self.log = LogChannel(topics.LOG, context=context)
        self.cmd_vel = self._json(topics.CMD_VEL, topics.CMD_VEL_SCHEMA)
        self.step = self._json(topics.STEP, topics.STEP_SCHEMA)
        self.outcome = self._json(topics.OUTCOME, topics.OUTCOME_SCHEMA)
        kind: Any = CompressedVideoChannel if video else CompressedImageChannel
        self._as_message: Callable[..., Any] = CompressedVideo if video else CompressedImage
        self._format = "h264" if video else "jpeg"
        self._cameras = {name: kind(f"{topics.CAMERA}{name}", context=context) for name in cameras}

    def log_picture(self, camera: str, picture: bytes, stamp: Timestamp, time: int) -> None:
        """Tell what a camera saw, encoded, at a simulated time in ns."""
        message = self._as_message(timestamp=stamp, frame_id=camera, data=picture, format=self._format)
        self._cameras[camera].log(message, log_time=time)

    def _encoded(self, topic: str, schema: foxglove.Schema) -> BaseChannel:
        """For messages that come as bytes, from a Template."""
        return foxglove.Channel(topic, schema=schema, message_encoding="protobuf", context=self.context).base

    def _json(self, topic: str, schema: topics.Schema) -> BaseChannel:
        return foxglove.Channel(topic, schema=schema, message_encoding="json", context=self.context).base
