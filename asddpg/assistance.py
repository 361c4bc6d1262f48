"""What the controller's help costs: γ_p of the paper (section V)."""

from asddpg.types import Driver


def assisted_reward(reward: float, dense_reward: float, driver: Driver, gamma_p: float) -> float:
    """The reward that the agent learns from: γ_p scales the dense part of the controller's steps while it is positive.

    Args:
        reward: of the task.
        dense_reward: the part of it that is not R_reach or R_crash.
        driver: who drove.
        gamma_p: 0 to 1; 1 makes the controller's help free.
    """
    if driver is Driver.CONTROLLER and dense_reward > 0.0:
        return reward - (1.0 - gamma_p) * dense_reward
    return reward
