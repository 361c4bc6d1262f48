"""A recording's records sorted by kind, and the file that is written of them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Attachment, Channel, McapRecord, Message, Metadata, Schema
from mcap.writer import Writer

from asddpg.errors import UserError
from asddpg.recording.files.reading import DAMAGE, decoder_of


class Decoded(NamedTuple):
    """A message as it stands in the file, and what it says."""

    record: Message
    topic: str
    content: Any


@dataclass
class Contents:
    """What a recording holds."""

    metadata: list[Metadata] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    messages: list[Message] = field(default_factory=list)

    def decoded(self) -> Iterator[Decoded]:
        """Messages in their order, up to the first that is damaged.

        Raises:
            UserError: they are in no encoding that is known here.
        """
        decoders = {
            channel.id: decoder_of(channel, self.schemas.get(channel.schema_id)) for channel in self.channels.values()
        }
        for message in self.messages:
            try:
                content = decoders[message.channel_id](message.data)
            except DAMAGE:
                return
            yield Decoded(message, self.channels[message.channel_id].topic, content)


def contents_of(records: Iterable[McapRecord]) -> Contents:
    """Records by kind."""
    found = Contents()
    for record in records:
        if isinstance(record, Metadata):
            found.metadata.append(record)
        elif isinstance(record, Attachment):
            found.attachments.append(record)
        elif isinstance(record, Schema):
            found.schemas[record.id] = record
        elif isinstance(record, Channel):
            found.channels[record.id] = record
        elif isinstance(record, Message):
            found.messages.append(record)
    return found


def write_recording(path: Path, contents: Contents) -> None:
    """Write an indexed, compressed file, which is whole or not there.

    Raises:
        UserError: it cannot be written.
    """
    part = path.with_name(path.name + ".new")
    try:
        part.write_bytes(_as_bytes(contents))
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise UserError(f"{path} cannot be written: {error.strerror}") from error


def _as_bytes(contents: Contents) -> bytes:
    """MCAP; metadata and attachments first, as everywhere here: a reader of the beginning knows what it is."""
    file = BytesIO()
    writer = Writer(file)
    writer.start(library="asddpg.recover")
    for metadata in contents.metadata:
        writer.add_metadata(metadata.name, metadata.metadata)
    for each in contents.attachments:
        writer.add_attachment(each.create_time, each.log_time, each.name, each.media_type, each.data)
    schemas = {0: 0}  # 0 is none
    for number, schema in contents.schemas.items():
        schemas[number] = writer.register_schema(schema.name, schema.encoding, schema.data)
    channels = {}
    for number, channel in contents.channels.items():
        schema_id = schemas[channel.schema_id]
        channels[number] = writer.register_channel(channel.topic, channel.message_encoding, schema_id, channel.metadata)
    for message in contents.messages:
        writer.add_message(
            channels[message.channel_id], message.log_time, message.data, message.publish_time, message.sequence
        )
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()
