"""A recording's records, read and written with MCAP's own library; a file from elsewhere may not exhaust the memory."""

import json
import os
import struct
from collections.abc import Callable, Collection, Iterable, Iterator
from io import BytesIO
from pathlib import Path
from typing import IO, Any, NamedTuple, cast

import zstandard
from google.protobuf.message import DecodeError
from mcap.exceptions import EndOfFile, McapError
from mcap.records import Attachment, Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory

from asddpg.atomic_write import write_whole
from asddpg.errors import UserError

# What reading a damaged file raises.
DAMAGE = (
    *(McapError, zstandard.ZstdError, DecodeError, EOFError, struct.error, ValueError, LookupError, MemoryError),
    *(TypeError, RecursionError, ArithmeticError),
)
MAX_CHUNK = 2**28  # bytes, unpacked
_LZ4_MAX_RATIO = 255


class DecodedMessage(NamedTuple):
    """A message, its topic, and its content: a dict of JSON, or an object of protobuf."""

    topic: str
    time: int  # simulated ns
    content: Any
    record: Message


def read_records(path: Path) -> Iterator[McapRecord]:
    """All records of a file in turn, chunks unpacked.

    Raises:
        OSError: it cannot be read.
        DAMAGE: it is damaged, or ends too early.
    """
    with path.open("rb") as file:
        stream = StreamReader(cast(IO[bytes], _WholeReads(file)), emit_chunks=True, validate_crcs=True)
        for record in stream.records:
            yield from unpack_chunk(record) if isinstance(record, Chunk) else [record]


def unpack_chunk(chunk: Chunk) -> list[McapRecord]:
    """A chunk's records; DAMAGE if it is damaged, or would unpack to more than MAX_CHUNK."""
    size = chunk.uncompressed_size
    if chunk.compression == "zstd":  # its header gives the size that would be allocated
        size = max(size, zstandard.frame_content_size(chunk.data))
    elif chunk.compression == "lz4":
        size = max(size, _LZ4_MAX_RATIO * len(chunk.data))
    if size > MAX_CHUNK:
        raise McapError(f"a chunk that unpacks to {size} bytes")
    return breakup_chunk(chunk, validate_crc=True)


def decode_messages(records: Iterable[McapRecord], topics: Collection[str] = ()) -> Iterator[DecodedMessage]:
    """Decode messages in the order of writing; of some topics, or of all.

    Raises:
        DAMAGE: a message is damaged.
        UserError: unknown encoding.
    """
    schemas: dict[int, Schema] = {}
    channels: dict[int, tuple[str, Callable[[bytes], Any]]] = {}
    for record in records:
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            if not topics or record.topic in topics:
                channels[record.id] = record.topic, _make_decoder(record, schemas.get(record.schema_id))
        elif isinstance(record, Message) and record.channel_id in channels:
            topic, decode = channels[record.channel_id]
            yield DecodedMessage(topic, record.log_time, decode(record.data), record)


def write_records(
    path: Path, records: Iterable[McapRecord], on_existing: Callable[[Path], object] = lambda _: None
) -> None:
    """Write an indexed, compressed file, as write_whole(); a failure leaves none.

    Raises:
        UserError: it cannot be written.
    """
    try:
        write_whole(path, _encode(records), on_existing, suffix=".new")  # .part is that of the source
    except OSError as error:
        raise UserError(f"{path} cannot be written: {error.strerror}") from error


class _WholeReads:
    """A file that returns all requested bytes or raises: mcap's reader takes half a message for a whole one."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file, self._left = file, os.fstat(file.fileno()).st_size

    def read(self, length: int) -> bytes:
        if length > self._left:  # a damaged length allocates no memory
            raise EndOfFile("it ends too early")
        self._left -= length
        return self._file.read(length)


def _make_decoder(channel: Channel, schema: Schema | None) -> Callable[[bytes], Any]:
    if channel.message_encoding == "json":
        return json.loads
    decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
    if decoder is None:
        raise UserError(
            f"the topic {channel.topic} is in {channel.message_encoding}; only json and protobuf can be read"
        )
    return decoder


def _encode(records: Iterable[McapRecord]) -> bytes:
    file = BytesIO()
    writer = Writer(file)
    writer.start(library="asddpg.recover")
    schemas, channels = {0: 0}, {}  # new ids by old ones; a schema of 0 is none
    for record in records:
        match record:
            case Metadata(name=name, metadata=metadata):
                writer.add_metadata(name, metadata)
            case Attachment():
                writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)
            case Schema(id=number) if number not in schemas:
                schemas[number] = writer.register_schema(record.name, record.encoding, record.data)
            case Channel(id=number) if number not in channels:
                schema = schemas.get(record.schema_id, 0)
                channels[number] = writer.register_channel(
                    record.topic, record.message_encoding, schema, record.metadata
                )
            case Message():
                channel = channels[record.channel_id]
                writer.add_message(channel, record.log_time, record.data, record.publish_time, record.sequence)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()
