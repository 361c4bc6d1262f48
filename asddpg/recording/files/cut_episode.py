"""The episode in the rest of a recording: its whole steps, and an end if it has none."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from foxglove.messages import Log, LogLevel
from mcap.records import Message

from asddpg.episodes.protocols import Driver, Episode
from asddpg.recording.files.contents import Contents, DecodedMessage
from asddpg.recording.messages.path_message import PathMessage
from asddpg.recording.messages.robot_messages import make_timestamp
from asddpg.recording.messages.step_message import encode_outcome, read_reward
from asddpg.recording.messages.topics import CMD_VEL, LOG, ODOM, OUTCOME, PATH, STEP

RUNNING, CUT = "running", "cut"


@dataclass(frozen=True)
class CutEpisode:
    """An episode that has an end.

    Attributes:
        contents: of its recording.
        outcome: how it ended; cut where the recording ends before the episode.
        steps: whole ones.
    """

    contents: Contents
    outcome: str
    steps: int


def end_episode(contents: Contents, source: str) -> CutEpisode | None:
    """Give a recording's episode an end; None if it has no whole step.

    Args:
        contents: the rest of the recording, in the order of writing; it gets the messages of the end.
        source: the file's name for the log.
    """
    messages = list(contents.decode())
    outcomes = _select(messages, OUTCOME)
    outcome = outcomes[-1]["outcome"] if outcomes else RUNNING
    if outcome == RUNNING:
        messages = _whole_steps(messages)
    contents.messages = [message.record for message in messages]
    steps = _select(messages, STEP)
    if not steps:
        return None
    if outcome == RUNNING:
        outcome = CUT
        contents.messages += _make_end(contents, messages, source)
    return CutEpisode(contents, outcome, len(steps))


def _select(messages: Sequence[DecodedMessage], topic: str) -> list[Any]:
    return [message.content for message in messages if message.topic == topic]


def _whole_steps(messages: Sequence[DecodedMessage]) -> list[DecodedMessage]:
    """All up to the end of the last whole step: its command is written last."""
    ends = [message.record.log_time for message in messages if message.topic == CMD_VEL]
    return [message for message in messages if ends and message.record.log_time <= ends[-1]]


def _make_end(contents: Contents, messages: Sequence[DecodedMessage], source: str) -> list[Message]:
    """The messages with which a recorder would have ended: path, outcome, a line of the log."""
    steps = _select(messages, STEP)
    places = [(each.pose.position.x, each.pose.position.y) for each in _select(messages, ODOM)]
    drivers = [step["driver"] for step in steps]
    end = {PATH: _encode_path(drivers, places)} if len(places) == len(steps) + 1 else {}
    episode = Episode(
        CUT,
        len(steps),
        sum(map(read_reward, steps)),
        drivers.count(Driver.CONTROLLER),
        sum(math.dist(*pair) for pair in itertools.pairwise(places)),
    )
    time = messages[-1].record.log_time
    text = f"cut after {episode.steps} steps, {episode.path_length:.1f} m driven; recovered from {source}"
    log = Log(timestamp=make_timestamp(time), level=LogLevel.Warning, message=text, name="asddpg")
    end |= {OUTCOME: encode_outcome(episode), LOG: log.encode()}
    numbers = {channel.topic: channel.id for channel in contents.channels.values()}
    return [Message(numbers[topic], time, data, time, 0) for topic, data in end.items() if topic in numbers]


def _encode_path(drivers: Sequence[str], places: Sequence[tuple[float, float]]) -> bytes:
    path = PathMessage(places[0])
    for driver, place in zip(drivers, places[1:], strict=True):
        path.extend(driver, place)
    return path.encode()
