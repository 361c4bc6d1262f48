"""What the controller's help costs: γ_p of the paper (section V), or a price a step."""

import numpy as np

from asddpg.episodes.batch_steps import BoolArray, FloatArray


def assisted_rewards(
    rewards: FloatArray, dense_rewards: FloatArray, by_controller: BoolArray, gamma_p: float, price: float = 0.0
) -> FloatArray:
    """The rewards that the agent learns from: γ_p scales the dense part of the controller's steps while it is positive.

    Args:
        rewards: of the task, (n,).
        dense_rewards: the part of them that is not R_reach or R_crash, (n,).
        by_controller: whether the controller drove, (n,).
        gamma_p: 0 to 1; 1 makes the controller's help free.
        price: taken off each of the controller's steps; γ_p never acts under the sparse reward, a price does.
    """
    charged = rewards - price - (1.0 - gamma_p) * np.maximum(dense_rewards, 0.0)
    return np.where(by_controller, charged, rewards)
