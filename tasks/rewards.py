"""Outcomes and rewards of the paper (section V), every constant a field, every term kept by name."""

from dataclasses import dataclass
from enum import StrEnum

from tasks.options import NOT_NEGATIVE, Range, check_options, option

NO_REWARD = {"progress": 0.0, "time": 0.0, "reach": 0.0, "crash": 0.0}  # the terms before the first step


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
    progress: float = option(1.0, "Earned for a metre of progress; 0 makes the reward sparse.", NOT_NEGATIVE)
    time_penalty: float = option(0.01, "The paper's C, taken off each step.", NOT_NEGATIVE)
    reach: float = option(5.0, "The paper's R_reach, earned at the goal.", NOT_NEGATIVE)
    turn_price: float = option(
        0.0, "Taken off each step for the squared change, (rad/s)², of the commanded turn rate.", NOT_NEGATIVE
    )
    crash: float = option(-5.0, "The paper's R_crash, itself negative.", Range(lambda value: value <= 0, "0 or less"))

    def __post_init__(self) -> None:
        """TaskError where a value is out of range."""
        check_options(self)

    def terms(
        self, outcome: Outcome, previous_distance: float, distance: float, turn_change: float = 0.0
    ) -> dict[str, float]:
        """The reward of one step as named terms; their sum is the reward.

        Args:
            outcome: how the step left the episode; a time limit is rewarded like any other step.
            previous_distance: to the goal before the step, metres.
            distance: to the goal after the step, metres.
            turn_change: of the commanded turn rate, from the last step to this, rad/s.
        """
        terms = NO_REWARD.copy()
        if outcome is Outcome.CRASHED:
            terms["crash"] = self.crash
        elif outcome is Outcome.REACHED:
            terms["reach"] = self.reach
        else:
            terms["progress"] = self.progress * (previous_distance - distance)
            terms["time"] = -self.time_penalty
        if self.turn_price:
            terms["turn"] = -self.turn_price * turn_change**2
        return terms

    def bound_returns(self, gamma: float, metres: float) -> tuple[float, float]:
        """Least and greatest discounted return, turn_price aside.

        Args:
            gamma: discount of a step.
            metres: that a step can bring the robot nearer to its goal, at most.
        """
        progress = self.progress * metres
        low = min(self.crash, -(self.time_penalty + progress) / (1.0 - gamma))
        return low, max(self.reach, (progress - self.time_penalty) / (1.0 - gamma))

    @property
    def no_terms(self) -> dict[str, float]:
        """The terms before the first step."""
        return NO_REWARD | ({"turn": 0.0} if self.turn_price else {})


def dense_part(terms: dict[str, float]) -> float:
    """The part of a step's reward that the paper's γ_p may scale: everything but R_reach and R_crash."""
    return terms["progress"] + terms["time"]


REWARDS = {
    "dense": Reward(),
    "sparse": Reward(name="sparse", progress=0.0, time_penalty=0.05),
}
