"""Reads recordings, complete and interrupted ones."""

import json
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.records import Attachment, McapRecord, Message, Metadata

from asddpg.errors import UserError
from asddpg.recording.files.recording_file import CONFIG, METADATA, PART
from asddpg.recording.files.records import DAMAGE, DecodedMessage, decode_messages, read_records
from asddpg.recording.messages.topics import GOAL, OUTCOME, STEP

MAX_CONFIG = 10**6  # bytes, unpacked
_GZIP = 16 + zlib.MAX_WBITS  # zlib then expects a gzip header


@dataclass(frozen=True)
class Recording:
    """An episode's recording.

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

    @property
    def reset_options(self) -> dict[str, Any]:
        """What an environment's reset takes to begin the episode again.

        Raises:
            UserError: the recording lacks start or goal, or they are damaged.
        """
        options: dict[str, Any] = {"start": self.start, "goal": self.goal}
        options |= {name: self.facts[name] for name in ("room",) if name in self.facts}
        if "variation" in self.facts:
            try:
                options["variation"] = json.loads(self.facts["variation"])
            except ValueError as error:
                raise UserError(f"{self.path} has a damaged variation") from error
        return options

    def _read_place(self, name: str, size: int) -> list[float]:
        try:
            place = [float(number) for number in json.loads(self.facts[name])]
        except (KeyError, TypeError, ValueError):
            place = []
        if len(place) != size:
            raise UserError(f"{self.path} has no {name}: it was made by another version")
        return place

    def messages(self, *topics: str) -> Iterator[DecodedMessage]:
        """Messages in the order of writing; of some topics, or of all.

        Of an interrupted recording, all that are whole.

        Raises:
            UserError: the file is damaged.
        """
        try:
            yield from decode_messages(_read_records(self.path), topics)
        except DAMAGE as error:
            raise _damaged(self.path, error) from error

    def goals(self) -> dict[int, tuple[float, float]]:
        """Goals that were set in the middle of the episode: by the beginning of the first step towards them, ns."""
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
    for record in _read_records(path):
        if isinstance(record, Metadata) and record.name == METADATA:
            facts = record.metadata
        elif isinstance(record, Attachment) and record.name == CONFIG and facts is not None:
            try:
                return Recording(path, facts, _unpack_config(record.data))
            except (zlib.error, ValueError) as error:
                raise _damaged(path, error) from error
        elif isinstance(record, Message):
            break
    raise UserError(f"{path} is a recording of another program: it does not begin with {METADATA} and {CONFIG}")


def _unpack_config(data: bytes) -> str:
    unpacker = zlib.decompressobj(_GZIP)
    text = unpacker.decompress(data, MAX_CONFIG)
    if unpacker.unconsumed_tail:
        raise ValueError(f"a configuration of more than {MAX_CONFIG} bytes")
    if not unpacker.eof:
        raise ValueError("its configuration ends too early")
    return text.decode()


def _read_records(path: Path) -> Iterator[McapRecord]:
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
