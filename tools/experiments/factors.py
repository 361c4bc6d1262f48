"""The factors of the ablation: add one here and it is in the grid.

The grid finds out which of them the default has, so this table stays as it is when the default changes.
"""

from typing import NamedTuple


class Factor(NamedTuple):
    """Something that learning may have or lack, by arguments of `python -m asddpg.train` with spaces between them."""

    title: str
    source: str  # who proposed it
    off: str  # without it
    on: str  # with it
    beside: str = ""  # what has to be set for it to act, or to be possible; its reference has that too


# fmt: off
FACTORS = {
    "critic_follows_switch": Factor(
        "Q^A bootstraps from the switch's value", "ours, in place of Eq. 4",
        off="agent.critic_follows_switch=false", on="agent.critic_follows_switch=true"),
    "imitation": Factor(
        "imitation of the controller where Q^A prefers it", "the paper's Fig. 1, Q-filter of Nair et al., 2018",
        off="agent.imitation=0", on="agent.imitation=1"),
    "controller_price": Factor(
        "a price on each of the controller's steps", "ours: γ_p never acts under the sparse reward",
        off="agent.controller_price=0", on="agent.controller_price=0.05"),
    # Under the sparse reward γ_p never acts, so without a price there would be nothing to charge.
    "charge_switch_alone": Factor(
        "a price of 0.05 and γ_p in y^Q alone", "ours; the paper has γ_p in y^A too",
        off="agent.charge_critic=true", on="agent.charge_critic=false", beside="agent.controller_price=0.05"),
    # The next three set one schedule; each one's `off` takes away its own part of it alone.
    "withdrawal": Factor(
        "the actor drives ever more episodes alone, in the end all", "ours",
        off="agent.withdrawal.last_share=0", on="agent.withdrawal.last_share=1"),
    "alone_throughout": Factor(
        "in place of the withdrawal: the actor drives half of the episodes alone, throughout", "ours",
        off="agent.withdrawal.first_share=0",
        on="agent.withdrawal.first_share=0.5 agent.withdrawal.last_share=0.5"),
    "alone_stretches": Factor(
        "in place of the withdrawal: the actor drives half of all stretches of 20 steps alone, throughout", "ours",
        off="agent.withdrawal.stretch_steps=0",
        on="agent.withdrawal.first_share=0.5 agent.withdrawal.last_share=0.5 agent.withdrawal.stretch_steps=20"),
    "twin_critics": Factor(
        "twin critics and target smoothing", "TD3 (Fujimoto et al., 2018)",
        off="agent.twin_critics=false agent.target_noise=0", on="agent.twin_critics=true agent.target_noise=0.1",
        beside="agent.critic_follows_switch=false"),
    "delayed_policy": Factor(
        "an update of the policy for every two of the critic", "TD3 (Fujimoto et al., 2018)",
        off="agent.policy_every=1", on="agent.policy_every=2"),
    "slow_critic": Factor(
        "learning rate of the critic 3e-4 instead of 1e-3", "TD3's authors' later code",
        off="agent.critic_learning_rate=1e-3", on="agent.critic_learning_rate=3e-4"),
    "layer_norm": Factor(
        "LayerNorm in the critic", "Ba et al., 2016",
        off="network.layer_norm=false", on="network.layer_norm=true"),
    "balanced_batches": Factor(
        "batches half of the actor's steps, half of the controller's", "after RLPD (Ball et al., 2023)",
        off="agent.balanced_batches=false", on="agent.balanced_batches=true"),
    "n_steps": Factor(
        "returns over three steps", "D4PG (Barth-Maron et al., 2018)",
        off="agent.n_steps=1", on="agent.n_steps=3"),
    "annealing": Factor(
        "learning rates decay to zero over the last 30 %", "common practice",
        off="agent.annealing=0", on="agent.annealing=0.3"),
    "shared_convolutions": Factor(
        "one convolutional front for policy and critic; the default has two, the paper's setting none",
        "the paper's Fig. 2",
        off="network.convolutions=separate", on="network.convolutions=shared"),
    "noise_floor": Factor(
        "exploration noise fades to a tenth, not to nothing", "ours",
        off="exploration.final_scale=0", on="exploration.final_scale=0.1"),
    "least_speed": Factor(
        "v from 0.05 m/s", "the released code",
        off="task.min_linear_velocity=0", on="task.min_linear_velocity=0.05"),
    "dense_scan": Factor(
        "682 beams", "the real laser; the released code keeps 40",
        off="task.laser.num_beams=40", on="task.laser.num_beams=682"),
}
# fmt: on
