"""Valid arguments of a training, for property-based tests."""

from collections.abc import Sequence
from typing import Any

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

from asddpg.command_line import GROUPS
from asddpg.config import TrainConfig
from asddpg.options.values import write_value
from tests.support.option_values import ArgumentLists, options, rules, values_of

RANGES = "network.ranges"


def valid_arguments(widest: int = 65_536, most_beams: int = 2000) -> ArgumentLists:
    """Arguments of a training, from the whole of each range but for what decides how much memory is taken."""
    kinds, is_right = options(TrainConfig), rules(TrainConfig)
    # Sockets, pictures; a robot has speeds of its own.
    left_out = ("live", "run_dir", "device", "controller.type", "record.cameras", "record.codec", "task.robot", RANGES)
    special: dict[str, SearchStrategy[Any]] = {
        "network.widths": st.lists(st.integers(1, widest), min_size=2, max_size=4),
        "network.convolutions": st.sampled_from(["separate", "shared", "none"]),
        "agent.buffer_size": st.integers(2000, 100_000),
        "task.control_timestep": st.integers(2, 400).map(lambda steps: steps * 0.005),
        "task.num_scans": st.integers(1, 8),
        "task.laser.num_beams": st.integers(12, most_beams),
        "task.laser.height": st.floats(0.3, 2.0),  # above the robot
        "task.max_linear_velocity": st.floats(0.01, 1.199, allow_subnormal=False),
        "task.max_angular_velocity": st.floats(0.01, 5.235, allow_subnormal=False),
        "record.picture_size": st.lists(st.integers(8, 540).map(lambda half: 2 * half), min_size=2, max_size=2),
    }

    def value(name: str) -> SearchStrategy[str]:
        drawn = special[name] if name in special else values_of(kinds[name])
        # Within a function of its own: hypothesis would make bounds of a rule, 5e-324 of "greater than 0", which is 0
        # once prepare_torch has turned such numbers off.
        taken = drawn.filter(lambda each: name not in is_right or is_right[name](each))
        return taken.map(lambda each: f"{name}={write_value(each)}")

    names = st.lists(st.sampled_from(sorted(set(kinds) - set(left_out))), max_size=8, unique=True)
    single = names.flatmap(lambda chosen: st.tuples(*map(value, chosen)))
    groups = st.tuples(*(st.sampled_from(sorted(choices)) for choices in GROUPS.values())).map(
        lambda choices: [f"{group}={choice}" for group, choice in zip(GROUPS, choices, strict=True)]
    )
    return st.builds(lambda chosen, arguments: [*chosen, *arguments, *_ranges(arguments)], groups, single)


def _ranges(arguments: Sequence[str]) -> list[str]:
    """Without convolutions the logarithm, which task=nav_anywhere has, must be given up."""
    return [f"{RANGES}=linear"] if "network.convolutions=none" in arguments else []
