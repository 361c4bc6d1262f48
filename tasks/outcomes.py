"""How an episode stands after a step."""

from enum import StrEnum


class Outcome(StrEnum):
    """`running`, one of the three ends, or `cut` for an episode stopped from outside."""

    RUNNING = "running"
    REACHED = "reached"
    CRASHED = "crashed"
    TIMEOUT = "timeout"
    CUT = "cut"
