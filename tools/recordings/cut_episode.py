"""The episode in what is left of a recording: its whole steps, and an end if it has none."""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from foxglove.messages import Log, LogLevel
from mcap.records import Message

from asddpg.episodes.protocols import Driver, Episode
from asddpg.recording.messages.path_message import PathMessage
from asddpg.recording.messages.robot_messages import timestamp
from asddpg.recording.messages.step_message import outcome_json, reward_in
from asddpg.recording.messages.topics import CMD_VEL, LOG, ODOM, OUTCOME, PATH, STEP
from tools.recordings.contents import Contents, Decoded

RUNNING, CUT = "running", "cut"


@dataclass(frozen=True)
class CutEpisode:
    """An episode that has an end.

    Attributes:
        contents: of its recording.
        outcome: how it ended; cut where the recording does not tell.
        steps: that are whole.
    """

    contents: Contents
    outcome: str
    steps: int


def episode_in(contents: Contents, source: str) -> CutEpisode | None:
    """The episode in a recording's contents; None if no step is whole.

    Args:
        contents: what is left of the recording, in the order of writing.
        source: what the log calls the file.
    """
    messages = list(contents.decoded())
    told = _said(messages, OUTCOME)
    outcome = told[-1]["outcome"] if told else RUNNING
    if outcome == RUNNING:
        messages = _whole_steps(messages)
    contents.messages = [message.record for message in messages]
    steps = _said(messages, STEP)
    if not steps:
        return None
    if outcome == RUNNING:
        outcome = CUT
        contents.messages += _end(contents, messages, source)
    return CutEpisode(contents, outcome, len(steps))


def _said(messages: Sequence[Decoded], topic: str) -> list[Any]:
    return [message.content for message in messages if message.topic == topic]


def _whole_steps(messages: Sequence[Decoded]) -> list[Decoded]:
    """All up to the end of the last whole step: what it was commanded is written last."""
    ends = [message.record.log_time for message in messages if message.topic == CMD_VEL]
    return [message for message in messages if ends and message.record.log_time <= ends[-1]]


def _end(contents: Contents, messages: Sequence[Decoded], source: str) -> list[Message]:
    """What a recorder would have told at the end: the path, the outcome, a line of the log."""
    steps = _said(messages, STEP)
    places = [(each.pose.position.x, each.pose.position.y) for each in _said(messages, ODOM)]
    told = {PATH: _path(steps, places)} if len(places) == len(steps) + 1 else {}
    episode = Episode(
        CUT,
        len(steps),
        sum(map(reward_in, steps)),
        sum(step["driver"] == Driver.CONTROLLER for step in steps),
        sum(math.dist(*pair) for pair in itertools.pairwise(places)),
    )
    time = messages[-1].record.log_time
    text = f"cut after {episode.steps} steps, {episode.path_length:.1f} m driven; recovered from {source}"
    log = Log(timestamp=timestamp(time), level=LogLevel.Warning, message=text, name="asddpg")
    told |= {OUTCOME: outcome_json(episode), LOG: log.encode()}
    numbers = {channel.topic: channel.id for channel in contents.channels.values()}
    return [Message(numbers[topic], time, data, time, 0) for topic, data in told.items() if topic in numbers]


def _path(steps: Sequence[Mapping[str, Any]], places: Sequence[tuple[float, float]]) -> bytes:
    path = PathMessage()
    path.begin(places[0])
    for step, place in zip(steps, places[1:], strict=True):
        path.extend(step["driver"], place)
    return path.encode()
