"""A recording's channels: one set a process, from which files and the live view take their messages."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import foxglove
import orjson
from foxglove.messages import (
    CompressedImage,
    CompressedVideo,
    FrameTransforms,
    Grid,
    LaserScan,
    Log,
    Odometry,
    PoseInFrame,
    PosesInFrame,
    SceneUpdate,
)
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

from asddpg.recording.messages import topics

_PROTOBUF: Mapping[str, Any] = {
    topics.TF: FrameTransforms,
    topics.SCAN: LaserScan,
    topics.SCENE: SceneUpdate,
    topics.PATH: SceneUpdate,
    topics.GOAL: PoseInFrame,
    topics.ODOM: Odometry,
    topics.LOG: Log,
}

_NAVIGATION: Mapping[str, Any] = {
    topics.MAP: Grid,
    topics.PLAN: PosesInFrame,
    topics.PARTICLES: PosesInFrame,
    topics.AMCL_POSE: PoseInFrame,
}


def _as_schema(name: str, schema: topics.Schema) -> foxglove.Schema:
    return foxglove.Schema(name=name, encoding="jsonschema", data=orjson.dumps(schema))


_JSON = {
    topics.CMD_VEL: _as_schema("asddpg.VelocityCommand", topics.CMD_VEL_SCHEMA),
    topics.STEP: _as_schema("asddpg.Step", topics.STEP_SCHEMA),
    topics.OUTCOME: _as_schema("asddpg.Outcome", topics.OUTCOME_SCHEMA),
}


def _message_encoding(schema: foxglove.Schema) -> str:
    return "json" if schema.encoding == "jsonschema" else schema.encoding


LogMessage = Callable[[bytes, int], object]  # takes a message and simulated ns


class Channels:
    """A context with a channel for each topic; whatever is open on the context gets what is logged.

    Attributes:
        schemas: by topic.
        context: foxglove's.
        log: by topic, takes its messages; for as long as this object lives.
    """

    def __init__(self, cameras: Sequence[str] = (), is_video: bool = False, is_planned: bool = False) -> None:
        """Make the channels.

        Args:
            cameras: names of the cameras that are shown.
            is_video: whether their pictures are H.264, else JPEG.
            is_planned: whether a driver plans: map, path, particles and estimated pose have topics too.
        """
        picture = CompressedVideo if is_video else CompressedImage
        messages = dict(_PROTOBUF) | {f"{topics.CAMERA}{name}": picture for name in cameras}
        messages |= _NAVIGATION if is_planned else {}
        self.schemas = {topic: compact(message.get_schema()) for topic, message in messages.items()}
        self.schemas |= _JSON
        self.context = foxglove.Context()
        self._channels = {
            topic: foxglove.Channel(
                topic, schema=schema, message_encoding=_message_encoding(schema), context=self.context
            )
            for topic, schema in self.schemas.items()
        }
        self.log: Mapping[str, LogMessage] = {topic: channel.base.log for topic, channel in self._channels.items()}


def compact(schema: foxglove.Schema) -> foxglove.Schema:
    """The same messages and fields in less space, in one file a package, without what code generators read."""
    packages: dict[str, FileDescriptorProto] = {}
    package_of: dict[str, str] = {}  # by file
    for file in FileDescriptorSet.FromString(schema.data).file:
        package_of[file.name] = file.package
        whole = packages.setdefault(
            file.package, FileDescriptorProto(name=file.package, package=file.package, syntax=file.syntax)
        )
        whole.message_type.extend(file.message_type)
        whole.enum_type.extend(file.enum_type)
        needed = {package_of[name] for name in file.dependency} - {file.package, *whole.dependency}
        whole.dependency.extend(sorted(needed))
    # google.protobuf, which needs nothing, comes before foxglove, which needs it.
    files = sorted(packages.values(), key=lambda file: len(file.dependency))
    return foxglove.Schema(
        name=schema.name, encoding=schema.encoding, data=FileDescriptorSet(file=files).SerializeToString()
    )
