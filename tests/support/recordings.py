"""Recordings for tests, some with changed contents."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from asddpg import evaluate
from asddpg.recording.files.contents import Contents, read_contents, write_contents
from asddpg.recording.messages.topics import STEP


def evaluated(folder: Path, *arguments: str) -> list[Path]:
    """Recordings of an evaluation, made in a folder."""
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        evaluate.main([*arguments, "record.every=1"])
    return sorted((folder / "evaluated_episodes").iterdir())


def changed(path: Path, target: Path, change: Callable[[Contents], None]) -> Path:
    """A recording with other contents."""
    contents = read_contents(path)
    change(contents)
    write_contents(target, contents)
    return target


def with_steps(change: Callable[[dict[str, Any]], None]) -> Callable[[Contents], None]:
    """A change of the messages of /step."""

    def act(contents: Contents) -> None:
        (number,) = (channel.id for channel in contents.channels.values() if channel.topic == STEP)
        for message in contents.messages:
            if message.channel_id == number:
                step = json.loads(message.data)
                change(step)
                message.data = json.dumps(step).encode()

    return act
