"""A recording's records sorted by kind, and the file that is written of them."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import Writer

from asddpg.errors import UserError
from asddpg.recording.files.reading import DAMAGE, make_decoder, read_records


class DecodedMessage(NamedTuple):
    """A message as it stands in the file, and its content."""

    record: Message
    topic: str
    content: Any


@dataclass
class Contents:
    """The records of a recording.

    Attributes:
        damage: what is wrong with the file, of which these are the records before; empty for a whole file.
    """

    metadata: list[Metadata] = field(default_factory=list)
    attachments: list[Attachment] = field(default_factory=list)
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    messages: list[Message] = field(default_factory=list)
    damage: str = ""

    def decode(self) -> Iterator[DecodedMessage]:
        """Messages in their order, up to the first damaged one.

        Raises:
            UserError: unknown encoding.
        """
        decoders = {
            channel.id: make_decoder(channel, self.schemas.get(channel.schema_id)) for channel in self.channels.values()
        }
        for message in self.messages:
            try:
                content = decoders[message.channel_id](message.data)
            except DAMAGE:
                return
            yield DecodedMessage(message, self.channels[message.channel_id].topic, content)


def read_contents(path: Path) -> Contents:
    """Read a file up to the first damage.

    Raises:
        OSError: it cannot be read.
    """
    found = Contents()
    try:
        for record in read_records(path):
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
    except DAMAGE as error:
        found.damage = " ".join(str(error).split()) or "it ends too early"
    return found


def write_contents(path: Path, contents: Contents) -> None:
    """Write an indexed, compressed file; a failure leaves none.

    Raises:
        UserError: it cannot be written.
    """
    new = path.with_name(path.name + ".new")
    try:
        new.write_bytes(_encode(contents))
        new.replace(path)
    except OSError as error:
        new.unlink(missing_ok=True)
        raise UserError(f"{path} cannot be written: {error.strerror}") from error


def _encode(contents: Contents) -> bytes:
    """MCAP; metadata and attachments come first, as in every recording, so that the beginning says what it is."""
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
