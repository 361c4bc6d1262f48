"""Three settings for each algorithm of Stable-Baselines3, its own options, to compare with.

`defaults` takes them as they come: one update of 256 for the 16 steps of 16 robots; DDPG and TD3 then explore without
noise. `matched` takes our training's shape as far as the library's options reach: batches of 256, returns of three
steps, our Ornstein-Uhlenbeck noise; two updates for 16 steps, twice as many as ours, and a learning rate of 3e-4, that
of SAC's authors. `frequent` updates once for each step of a robot, the ratio that the algorithms were published with,
at batch 64, since 256 would leave 50,000 steps in half an hour; Gaussian noise of 0.1, as TD3 was published.

SAC explores by its own entropy. Its temperature begins at 1, ten times the price of a step and more; at 0.1 in the
settings that are not as they come.
"""

from typing import Any, NamedTuple

ALGORITHMS = ("ddpg", "td3", "sac")


class Setting(NamedTuple):
    """Options of the library.

    Attributes:
        options: of all three algorithms.
        noise: of DDPG and TD3, in half an action's range: its kind and σ a step; None for none.
    """

    options: dict[str, Any]
    noise: tuple[str, float] | None = None


SETTINGS = {
    "defaults": Setting({}),
    "matched": Setting(
        {"gradient_steps": 2, "batch_size": 256, "n_steps": 3, "learning_rate": 3e-4, "learning_starts": 1000},
        ("ornstein_uhlenbeck", 0.2),
    ),
    "frequent": Setting(
        {"gradient_steps": -1, "batch_size": 64, "learning_rate": 3e-4, "learning_starts": 1000}, ("gaussian", 0.1)
    ),
}
SAC_OPTIONS = {"ent_coef": "auto_0.1"}  # of the settings that are not the defaults
