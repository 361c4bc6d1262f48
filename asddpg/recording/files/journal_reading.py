"""Reads a recording in progress as what it would have become: messages in the place of its journal."""

from collections.abc import Iterable, Iterator
from functools import partial

from mcap.records import Channel, McapRecord, Message

from asddpg.recording.files.journal import ENCODING, Layout, unpacked
from asddpg.recording.messages.pose_messages import States
from asddpg.recording.messages.publisher import Publisher


def in_full(records: Iterable[McapRecord]) -> Iterator[McapRecord]:
    """Records of a file; those of a journal as the messages that tell its moments.

    Raises:
        ArithmeticError, LookupError, TypeError, ValueError, struct.error: the journal is damaged.
    """
    channels: dict[str, int] = {}
    tellers: dict[int, _Teller] = {}  # by the number of the journal's channel
    for record in records:
        if isinstance(record, Channel) and record.message_encoding == ENCODING:
            tellers[record.id] = _Teller(Layout.of_text(record.metadata), channels)
        elif isinstance(record, Message) and record.channel_id in tellers:
            yield from tellers[record.channel_id].messages(record)
        else:
            if isinstance(record, Channel):
                channels[record.topic] = record.id
            yield record


class _Teller:
    """Tells an episode's moments once more."""

    def __init__(self, layout: Layout, channels: dict[str, int]) -> None:
        """Take how to tell them, and the other channels' numbers by topic: the journal's is declared last."""
        self._told: list[Message] = []
        log = {topic: partial(self._take, number) for topic, number in channels.items()}
        self._publisher = Publisher(log, States(layout.frames, layout.scan_shape), None, layout.is_video)

    def messages(self, record: Message) -> list[Message]:
        """What is to be told of a journal's entry."""
        self._told.clear()
        self._publisher.tell(list(unpacked(record.data)))
        return self._told.copy()

    def _take(self, number: int, message: bytes, time: int) -> None:
        self._told.append(Message(number, time, message, time, 0))
