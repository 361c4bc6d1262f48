"""Outcomes and rewards of the paper (section V), every constant a field, every term kept by name."""

from dataclasses import dataclass
from enum import StrEnum


class Outcome(StrEnum):
    """State of an episode after a step: `running`, or one of the three ends."""

    RUNNING = "running"
    REACHED = "reached"
    CRASHED = "crashed"
    TIMEOUT = "timeout"


@dataclass
class Reward:
    """r = R_crash, R_reach, or else progress · (d₋₁ − d) − C, with d the distance to the goal in metres."""

    name: str = "dense"
    # The paper writes (d₋₁ − d)Δt, Δt = 0.2 s; its released code takes the factor 1. 0 makes the reward sparse.
    progress: float = 1.0
    # The paper's C, per step.
    time_penalty: float = 0.01
    # The paper's R_reach.
    reach: float = 5.0
    # The paper's R_crash, itself negative.
    crash: float = -5.0

    def terms(self, outcome: Outcome, previous_distance: float, distance: float) -> dict[str, float]:
        """The reward of one step as named terms; their sum is the reward.

        Args:
            outcome: how the step left the episode; a time limit is rewarded like any other step.
            previous_distance: to the goal before the step, metres.
            distance: to the goal after the step, metres.
        """
        terms = {"progress": 0.0, "time": 0.0, "reach": 0.0, "crash": 0.0}
        if outcome is Outcome.CRASHED:
            terms["crash"] = self.crash
        elif outcome is Outcome.REACHED:
            terms["reach"] = self.reach
        else:
            terms["progress"] = self.progress * (previous_distance - distance)
            terms["time"] = -self.time_penalty
        return terms


def dense_part(terms: dict[str, float]) -> float:
    """The part of a step's reward that the paper's γ_p may scale: everything but R_reach and R_crash."""
    return terms["progress"] + terms["time"]


REWARDS = {
    "dense": Reward(),
    "sparse": Reward(name="sparse", progress=0.0, time_penalty=0.05),
}
