"""Completes recordings that were interrupted or damaged: whole steps become a complete file."""

import contextlib
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foxglove.messages import Log, LogLevel
from mcap.records import Attachment, Channel, McapRecord, Message, Metadata

from asddpg.episodes.protocols import Driver, Episode
from asddpg.errors import UserError, truncated_repr
from asddpg.recording.files.recording_file import CONFIG, MCAP, METADATA, PART
from asddpg.recording.files.records import DAMAGE, DecodedMessage, decode_messages, read_records, write_records
from asddpg.recording.messages.goal_camera_messages import make_timestamp
from asddpg.recording.messages.path_message import PathMessage
from asddpg.recording.messages.step_message import encode_outcome, read_reward
from asddpg.recording.messages.topics import LOG, ODOM, OUTCOME, PATH, STEP

RUNNING, CUT = "running", "cut"
OUTCOMES = ("reached", "crashed", "timeout", CUT)


@dataclass(frozen=True)
class RecoveredEpisode:
    """An episode that has an end.

    Attributes:
        records: of its recording.
        outcome: how it ended; cut where the recording ends before the episode.
        steps: whole ones.
    """

    records: Sequence[McapRecord]
    outcome: str
    steps: int


def recover(source: Path, target: Path | None = None) -> tuple[RecoveredEpisode, Path]:
    """Complete a recording; returns what was saved, and its file.

    Args:
        source: the rest of the recording, which stays.
        target: the new file; None names it after the old one and the outcome.

    Raises:
        UserError: the file is missing, whole, of another program, or holds no whole step; or the new one exists, or
            cannot be written.
    """
    episode = _recover_episode(source)
    if episode is None:
        raise UserError(f"{source} holds no whole step, so there is nothing to recover")
    if target is None and episode.outcome not in OUTCOMES:
        raise UserError(
            f"{source} ended in {truncated_repr(episode.outcome)}, which is no outcome: give the new file a name"
        )
    target = target or _name_target(source, episode.outcome)

    def refuse(path: Path) -> None:
        raise UserError(f"{path} exists already; name another file: python -m tools.recover {source} <file.mcap>")

    write_records(target, episode.records, refuse)
    return episode, target


def complete_interrupted(part: Path) -> Path | None:
    """Complete the recording that a killed process left, and delete the part.

    Args:
        part: `<stem>.mcap.part`; one that cannot be completed, as on a full disk, stays.

    Returns:
        `<stem>_cut.mcap`; or the complete recording of that stem, if the process was killed before it deleted the part;
        None where no step is whole, or nothing could be written.
    """
    path = next(part.parent.glob(f"{_stem(part)}_*{MCAP}"), None)
    if path is None:
        try:
            episode = _recover_episode(part)
        except UserError:
            episode = None
        if episode is not None:
            path = part.with_name(f"{_stem(part)}_{CUT}{MCAP}")
            try:
                write_records(path, episode.records)
            except UserError:
                return None
    with contextlib.suppress(OSError):
        part.unlink()
    return path


def _recover_episode(source: Path) -> RecoveredEpisode | None:
    records = _read_rest(source)
    try:
        return _end_episode(records, source.name)
    except DAMAGE:
        return None


def _read_rest(source: Path) -> list[McapRecord]:
    """The records up to the first damage."""
    records: list[McapRecord] = []
    damage = ""
    try:
        for record in read_records(source):
            records.append(record)
    except DAMAGE as error:
        damage = " ".join(str(error).split()) or "it ends too early"
    except OSError as error:
        raise UserError(f"{source} cannot be read: {error.strerror}") from error
    is_ours = any(isinstance(record, Metadata) and record.name == METADATA for record in records)
    if not is_ours and (not damage or any(isinstance(record, Message) for record in records)):
        raise UserError(f"{source} is a recording of another program: it does not begin with {METADATA}")
    if not any(isinstance(record, Attachment) and record.name == CONFIG for record in records) or not is_ours:
        raise UserError(f"nothing of {source} can be recovered, its beginning is not whole ({damage})")
    if not damage and source.suffix != PART:
        raise UserError(f"{source} is whole, there is nothing to recover")
    return records


# Episode --------------------------------------------------------------------------------------------------------------


def _end_episode(records: Sequence[McapRecord], source: str) -> RecoveredEpisode | None:
    """Give the episode an end, if it has none; None if it has no whole step."""
    messages = _decode_whole(records)
    outcomes = _select(messages, OUTCOME)
    outcome = outcomes[-1]["outcome"] if outcomes else RUNNING
    if outcome == RUNNING:
        # A whole step ends with /step, which is written last.
        end = max((index for index, message in enumerate(messages, 1) if message.topic == STEP), default=0)
        messages = messages[:end]
    steps = _select(messages, STEP)
    if not steps:
        return None
    kept = [record for record in records if not isinstance(record, Message)]
    kept += [message.record for message in messages]
    if outcome == RUNNING:
        outcome = CUT
        kept += _make_end({each.topic: each.id for each in records if isinstance(each, Channel)}, messages, source)
    return RecoveredEpisode(kept, outcome, len(steps))


def _decode_whole(records: Sequence[McapRecord]) -> list[DecodedMessage]:
    messages: list[DecodedMessage] = []
    with contextlib.suppress(*DAMAGE):
        for message in decode_messages(records):
            messages.append(message)
    return messages


def _select(messages: Sequence[DecodedMessage], topic: str) -> list[Any]:
    return [message.content for message in messages if message.topic == topic]


def _make_end(channels: dict[str, int], messages: Sequence[DecodedMessage], source: str) -> list[Message]:
    """The messages with which a recorder would have ended: path, outcome, a line of the log."""
    steps = _select(messages, STEP)
    places = [(each.pose.position.x, each.pose.position.y) for each in _select(messages, ODOM)]
    drivers = [step["driver"] for step in steps]
    end: dict[str, bytes] = {}
    if len(places) == len(steps) + 1:
        path = PathMessage(places[0])
        for driver, place in zip(drivers, places[1:], strict=True):
            path.extend(driver, place)
        end[PATH] = path.encode()
    length = sum(math.dist(*pair) for pair in itertools.pairwise(places))
    share = drivers.count(Driver.CONTROLLER)
    episode = Episode(CUT, len(steps), sum(map(read_reward, steps)), share, length)
    time = messages[-1].time
    text = f"cut after {episode.steps} steps, {episode.path_length:.1f} m driven; recovered from {source}"
    log = Log(timestamp=make_timestamp(time), level=LogLevel.Warning, message=text, name="asddpg")
    end |= {OUTCOME: encode_outcome(episode), LOG: log.encode()}
    return [Message(channels[topic], time, data, time, 0) for topic, data in end.items() if topic in channels]


# File names -----------------------------------------------------------------------------------------------------------


def _name_target(source: Path, outcome: str) -> Path:
    target = source.with_name(f"{_stem(source)}_{outcome}{MCAP}")
    # A file that is damaged after its outcome would get its own name.
    return target if target != source else source.with_name(f"{_stem(source)}_recovered_{outcome}{MCAP}")


def _stem(source: Path) -> str:
    """Its name without endings and outcome."""
    stem = source.name.removesuffix(PART).removesuffix(MCAP)
    for outcome in OUTCOMES:
        stem = stem.removesuffix(f"_{outcome}")
    return stem
