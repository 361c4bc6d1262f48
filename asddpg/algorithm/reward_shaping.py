"""What the controller's help costs: γ_p of the paper (section V), or a price a step."""

from asddpg.episodes.protocols import Driver


def assisted_reward(reward: float, dense_reward: float, driver: Driver, gamma_p: float, price: float = 0.0) -> float:
    """The reward that the agent learns from: γ_p scales the dense part of the controller's steps while it is positive.

    Args:
        reward: of the task.
        dense_reward: the part of it that is not R_reach or R_crash.
        driver: of the step.
        gamma_p: 0 to 1; 1 makes the controller's help free.
        price: taken off each of the controller's steps; γ_p never acts under the sparse reward, a price does.
    """
    if driver is not Driver.CONTROLLER:
        return reward
    return reward - price - (1.0 - gamma_p) * max(dense_reward, 0.0)
