"""Reads recordings, complete and interrupted ones."""

import json
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, NamedTuple, cast

from google.protobuf.message import DecodeError
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, McapRecord, Metadata, Schema
from mcap.records import Message as McapMessage
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory
from zstandard import ZstdError

from asddpg.errors import UserError
from asddpg.recording.files.chunks import unpack_chunk, unpack_config
from asddpg.recording.files.recording_file import CONFIG, METADATA, PART
from asddpg.recording.files.whole_reads import WholeReads
from asddpg.recording.messages.topics import GOAL, OUTCOME, STEP

# What reading a damaged file raises.
DAMAGE = (
    *(McapError, ZstdError, DecodeError, EOFError, struct.error, ValueError, LookupError, MemoryError),
    *(TypeError, RecursionError, ArithmeticError),
)


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
        x, y, yaw = self._read_place("start", 3)
        return x, y, yaw

    @property
    def goal(self) -> tuple[float, float]:
        """x, y: m; exact."""
        x, y = self._read_place("goal", 2)
        return x, y

    def _read_place(self, name: str, size: int) -> list[float]:
        try:
            place = [float(number) for number in json.loads(self.facts[name])]
        except (KeyError, TypeError, ValueError):
            place = []
        if len(place) != size:
            raise UserError(f"{self.path} has no {name}: it was made by another version")
        return place

    def messages(self, *topics: str) -> Iterator[Message]:
        """Messages in the order of writing; of some topics, or of all.

        Of an interrupted recording, all that are whole.

        Raises:
            UserError: the file is damaged.
        """
        schemas: dict[int, Schema] = {}
        channels: dict[int, tuple[str, Callable[[bytes], Any]]] = {}  # of the topics
        for record in _records(self.path):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                if not topics or record.topic in topics:
                    channels[record.id] = record.topic, self._make_decoder(record, schemas.get(record.schema_id))
            elif isinstance(record, McapMessage) and record.channel_id in channels:
                topic, decode = channels[record.channel_id]
                try:
                    content = decode(record.data)
                except DAMAGE as error:
                    raise _damaged(self.path, error) from error
                yield Message(topic, record.log_time, content)

    def _make_decoder(self, channel: Channel, schema: Schema | None) -> Callable[[bytes], Any]:
        try:
            return make_decoder(channel, schema)
        except DAMAGE as error:
            raise _damaged(self.path, error) from error

    def goals(self) -> dict[int, tuple[float, float]]:
        """Goals that were set in the middle of the episode: by the end of the first step towards them, simulated ns."""
        poses = [(message.time, message.content.pose.position) for message in self.messages(GOAL)]
        return {time: (place.x, place.y) for time, place in poses[1:]}

    def steps(self) -> list[dict[str, Any]]:
        """The messages of /step."""
        return [message.content for message in self.messages(STEP)]

    def outcome(self) -> dict[str, Any]:
        """The last message of /outcome: how the episode ended, or that it was running."""
        last: dict[str, Any] = {"outcome": "running"}  # interrupted before the first message
        for message in self.messages(OUTCOME):
            last = message.content
        return last


def open_recording(path: str | Path) -> Recording:
    """Open the recording of an episode; `<name>.mcap.part` is an interrupted one.

    Raises:
        UserError: there is no such file, it is a recording of another program, or it is damaged.
    """
    path = Path(path)
    facts: Mapping[str, str] | None = None
    for record in _records(path):
        if isinstance(record, Metadata) and record.name == METADATA:
            facts = record.metadata
        elif isinstance(record, Attachment) and record.name == CONFIG and facts is not None:
            return Recording(path, facts, _unpack_config(record, path))
        elif isinstance(record, McapMessage):
            break
    raise UserError(f"{path} is a recording of another program: it does not begin with {METADATA} and {CONFIG}")


def _unpack_config(attachment: Attachment, path: Path) -> str:
    try:
        return unpack_config(attachment.data)
    except (EOFError, zlib.error, ValueError) as error:
        raise _damaged(path, error) from error


def make_decoder(channel: Channel, schema: Schema | None) -> Callable[[bytes], Any]:
    """A function that decodes a channel's messages.

    Raises:
        UserError: unknown encoding.
    """
    if channel.message_encoding == "json":
        return json.loads
    decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
    if decoder is None:
        raise UserError(
            f"the topic {channel.topic} is in {channel.message_encoding}; only json and protobuf can be read"
        )
    return decoder


def read_records(path: Path) -> Iterator[McapRecord]:
    """All records of a file in turn, chunks unpacked.

    Raises:
        OSError: it cannot be read.
        DAMAGE: it is damaged, or ends too early.
    """
    with path.open("rb") as file:
        stream = StreamReader(cast(IO[bytes], WholeReads(file)), emit_chunks=True, validate_crcs=True)
        for record in stream.records:
            yield from unpack_chunk(record) if isinstance(record, Chunk) else [record]


def _records(path: Path) -> Iterator[McapRecord]:
    """All records of a file in turn; a part ends with its last whole record."""
    try:
        yield from read_records(path)
    except DAMAGE as error:
        if path.suffix != PART:
            raise _damaged(path, error) from error
    except OSError as error:
        raise UserError(f"the recording {path} cannot be read: {error.strerror}") from error


def _damaged(path: Path, error: Exception) -> UserError:
    what = " ".join(str(error).split()) or type(error).__name__
    return UserError(
        f"{path} is damaged or not a recording ({what}); to save whole steps: python -m tools.recover {path}"
    )
