"""Recordings for tests, some with changed contents."""

import gzip
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.records import Attachment, Channel, McapRecord, Message

from asddpg import evaluate
from asddpg.recording.files.records import read_records, write_records


def evaluated(folder: Path, *arguments: str) -> list[Path]:
    """Recordings of an evaluation, made in a folder."""
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        evaluate.main([*arguments, "record.every=1"])
    return sorted((folder / "evaluated_episodes").iterdir())


def changed(path: Path, target: Path, change: Callable[[list[McapRecord]], object]) -> Path:
    """A recording with other records."""
    records = list(read_records(path))
    change(records)
    write_records(target, records)
    return target


def with_messages(topic: str, change: Callable[[bytes], bytes]) -> Callable[[list[McapRecord]], None]:
    """A change of the messages of a topic."""

    def act(records: list[McapRecord]) -> None:
        numbers = {each.id for each in records if isinstance(each, Channel) and each.topic == topic}
        for each in records:
            if isinstance(each, Message) and each.channel_id in numbers:
                each.data = change(each.data)

    return act


def with_config(change: Callable[[str], str]) -> Callable[[list[McapRecord]], None]:
    """A change of the configuration in the attachment."""

    def act(records: list[McapRecord]) -> None:
        (attachment,) = (each for each in records if isinstance(each, Attachment))
        attachment.data = gzip.compress(change(gzip.decompress(attachment.data).decode()).encode())

    return act
