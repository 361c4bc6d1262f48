"""MCAP without chunks and index, as bytes: what a recording in progress holds; https://mcap.dev/spec."""

import struct
from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

import foxglove
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, McapRecord, Metadata, Schema

MAGIC = b"\x89MCAP0\r\n"
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length of the rest, channel, sequence, log time, publish time
_BEYOND_LENGTH = _MESSAGE.size - 9


Logged = tuple[str, bytes, int]  # topic, message and simulated ns


class OtherChannel(NamedTuple):
    """A channel without a schema."""

    topic: str
    encoding: str
    metadata: Mapping[str, str]


class PlainMcap:
    """Encodes what recordings of the same channels and configuration hold."""

    def __init__(
        self, schemas: Mapping[str, foxglove.Schema], attachment: Attachment, others: Collection[OtherChannel] = ()
    ) -> None:
        """Encode what they have in common; schemas by topic, and channels that have none."""
        topics = [*schemas, *(other.topic for other in others)]
        self._numbers = {topic: number for number, topic in enumerate(topics, 1)}
        declared: list[McapRecord] = []
        for topic, schema in schemas.items():
            declared += _declared(topic, schema, self._numbers[topic])
        for topic, encoding, metadata in others:
            declared.append(Channel(self._numbers[topic], topic, encoding, dict(metadata), 0))
        self._common = _encoded(attachment, *declared)

    def beginning(self, metadata: Metadata) -> bytes:
        """All before the messages."""
        return MAGIC + _encoded(Header("", "asddpg"), metadata) + self._common

    def messages(self, logged: Iterable[Logged]) -> bytes:
        """Messages."""
        pack, opcode, numbers = _MESSAGE.pack, int(Opcode.MESSAGE), self._numbers
        pieces: list[bytes] = []
        for topic, message, time in logged:
            pieces += pack(opcode, len(message) + _BEYOND_LENGTH, numbers[topic], 0, time, time), message
        return b"".join(pieces)


def message_encoding(schema: foxglove.Schema) -> str:
    """How messages of a schema are encoded."""
    return "json" if schema.encoding == "jsonschema" else schema.encoding


def _declared(topic: str, schema: foxglove.Schema, number: int) -> tuple[Schema, Channel]:
    """A channel and its schema, of the same number."""
    return (
        Schema(id=number, name=schema.name, encoding=schema.encoding, data=schema.data),
        Channel(number, topic, message_encoding(schema), {}, number),
    )


def _encoded(*records: McapRecord) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    encoded: bytes = builder.end()  # type: ignore[no-untyped-call]
    return encoded
