"""Reads recordings, whole ones and such as were cut off."""

import gzip
import json
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, McapRecord, Metadata, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory
from zstandard import ZstdError

from asddpg.errors import UserError
from asddpg.recording.mcap_file import CONFIG, METADATA
from asddpg.recording.topics import OUTCOME, STEP

PART = ".part"  # ending of a recording that was not completed


class Message(NamedTuple):
    """A message, decoded: a dict of JSON, or an object of protobuf."""

    topic: str
    time: int  # simulated ns
    content: Any


@dataclass(frozen=True)
class Recording:
    """What a recording is of.

    Attributes:
        path: its file.
        facts: by name, as text: task, seed, start, goal, versions and more.
        config: the resolved configuration, YAML.
    """

    path: Path
    facts: Mapping[str, str]
    config: str

    @property
    def start(self) -> tuple[float, float, float]:
        """x, y, yaw that the episode began with: m, rad; exact."""
        x, y, yaw = json.loads(self.facts["start"])
        return x, y, yaw

    @property
    def goal(self) -> tuple[float, float]:
        """x, y: m; exact."""
        x, y = json.loads(self.facts["goal"])
        return x, y

    def messages(self, *topics: str) -> Iterator[Message]:
        """Messages in the order of writing; of some topics, or of all.

        Of a recording that was cut off, all that are whole.

        Raises:
            UserError: the file is damaged.
        """
        channels: dict[int, tuple[str, Callable[[bytes], Any]]] = {}
        schemas: dict[int, Schema] = {}
        for record in _records(self.path):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record.topic, _decoder(record, schemas[record.schema_id])
            elif isinstance(record, McapMessage):
                topic, decode = channels[record.channel_id]
                if not topics or topic in topics:
                    yield Message(topic, record.log_time, decode(record.data))

    def steps(self) -> list[dict[str, Any]]:
        """What /step says, one after the other."""
        return [message.content for message in self.messages(STEP)]

    def outcome(self) -> dict[str, Any]:
        """What /outcome said last: how the episode ended, or that it was running."""
        last: dict[str, Any] = {"outcome": "running"}  # where it was cut off before anything was said
        for message in self.messages(OUTCOME):
            last = message.content
        return last


def open_recording(path: str | Path) -> Recording:
    """A recording of an episode; `<name>.mcap.part` is one that was cut off.

    Raises:
        UserError: there is no such file, it is none of this project's recordings, or it is damaged.
    """
    path = Path(path)
    facts: Mapping[str, str] | None = None
    for record in _records(path):
        if isinstance(record, Metadata) and record.name == METADATA:
            facts = record.metadata
        elif isinstance(record, Attachment) and record.name == CONFIG and facts is not None:
            return Recording(path, facts, _unpacked(record, path))
        elif isinstance(record, McapMessage):
            break
    raise UserError(f"{path} is a recording of another program: it does not begin with {METADATA} and {CONFIG}")


def _unpacked(attachment: Attachment, path: Path) -> str:
    try:
        return gzip.decompress(attachment.data).decode()
    except (OSError, EOFError, zlib.error, UnicodeDecodeError) as error:
        raise _damaged(path, error) from error


def _decoder(channel: Channel, schema: Schema) -> Callable[[bytes], Any]:
    if channel.message_encoding == "json":
        return json.loads
    decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
    if decoder is None:
        raise UserError(f"the topic {channel.topic} is in {channel.message_encoding}, which nobody here can read")
    return decoder


def _records(path: Path) -> Iterator[McapRecord]:
    """All records of a file in turn; a part ends where it was cut off."""
    is_part = path.suffix == PART
    try:
        with path.open("rb") as file:
            yield from StreamReader(file, validate_crcs=True).records
    except (McapError, ZstdError, EOFError, struct.error, ValueError) as error:
        if not is_part:
            raise _damaged(path, error) from error
    except OSError as error:
        raise UserError(f"the recording {path} cannot be read: {error.strerror}") from error


def _damaged(path: Path, error: Exception) -> UserError:
    what = " ".join(str(error).split()) or type(error).__name__
    return UserError(f"{path} is no whole recording ({what}); what is left of one: python -m tools.recover {path}")
