"""Recordings for tests, and such with something changed."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from asddpg import evaluate
from asddpg.recording.messages.topics import STEP
from tools.recordings.contents import Contents, contents_of, write_recording
from tools.recordings.salvage import salvage


def evaluated(folder: Path, *arguments: str) -> list[Path]:
    """Recordings of an evaluation, made in a folder."""
    folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        evaluate.main([*arguments, "record.every=1"])
    return sorted((folder / "evaluated_episodes").iterdir())


def changed(path: Path, target: Path, change: Callable[[Contents], None]) -> Path:
    """A recording with other contents."""
    contents = contents_of(salvage(path).records)
    change(contents)
    write_recording(target, contents)
    return target


def with_steps(change: Callable[[dict[str, Any]], None]) -> Callable[[Contents], None]:
    """A change of what /step says."""

    def act(contents: Contents) -> None:
        (number,) = (channel.id for channel in contents.channels.values() if channel.topic == STEP)
        for message in contents.messages:
            if message.channel_id == number:
                step = json.loads(message.data)
                change(step)
                message.data = json.dumps(step).encode()

    return act
