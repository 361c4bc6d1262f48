"""How an episode stands after a step."""

from enum import StrEnum


class Outcome(StrEnum):
    """`running`, or one of the three ends."""

    RUNNING = "running"
    REACHED = "reached"
    CRASHED = "crashed"
    TIMEOUT = "timeout"
