"""A recorded episode's signals over time, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from asddpg.errors import UserError
from asddpg.recording.files.reading import Recording
from asddpg.recording.messages.topics import ODOM
from asddpg.runs.safe_loading import plain_values
from tasks.physics import FloatArray


@dataclass(frozen=True)
class Signals:
    """An episode of n steps over time.

    Attributes:
        title: which episode, and how it ended.
        control_timestep: s.
        drivers: n names.
        driven: (n + 1, 2), v in m/s and ω in rad/s, at the beginning and at the end of each step.
        by_name: n values each, NaN where there is none: v, omega, distance, q_policy, q_controller, value, noise_v,
            noise_omega, as far as they are there.
        terms: n values for each term of the reward.
    """

    title: str
    control_timestep: float
    drivers: Sequence[str]
    driven: FloatArray
    by_name: dict[str, FloatArray]
    terms: dict[str, FloatArray]

    @property
    def ends(self) -> FloatArray:
        """When each step ended, s, after 0 for the beginning: (n + 1,)."""
        return np.arange(len(self.drivers) + 1, dtype=np.float64) * np.float64(self.control_timestep)


def read_signals(recording: Recording) -> Signals:
    """Read an episode's signals; UserError where it has no steps."""
    steps = recording.steps()
    if not steps:
        raise UserError(f"the recording {recording.path} holds no steps to plot")
    columns = {
        **{name: [step["action"][name] for step in steps] for name in ("v", "omega")},
        **{name: [step.get(name) for step in steps] for name in ("distance", "q_policy", "q_controller", "value")},
        **{f"noise_{name}": [(step.get("noise") or {}).get(name) for step in steps] for name in ("v", "omega")},
    }
    by_name = {name: np.array(values, dtype=float) for name, values in columns.items()}
    outcome = recording.outcome()["outcome"]
    facts = recording.facts
    return Signals(
        title=f"{facts['task']}, episode {facts['episode']}: {outcome} after {steps[-1]['time']:.1f} s",
        control_timestep=_control_timestep(recording),
        drivers=[step["driver"] for step in steps],
        driven=np.array([_velocity(message.content) for message in recording.messages(ODOM)][: len(steps) + 1]),
        by_name={name: values for name, values in by_name.items() if not np.isnan(values).all()},
        terms={name: np.array([step["terms"].get(name) for step in steps], dtype=float) for name in _term_names(steps)},
    )


def _control_timestep(recording: Recording) -> float:
    """Of a version with other options too."""
    try:
        return float(plain_values(recording.config)["task"]["control_timestep"])
    except (ValueError, TypeError, LookupError) as error:
        raise UserError(f"the configuration in {recording.path} is damaged or not written by asddpg.train") from error


def _term_names(steps: Sequence[dict[str, Any]]) -> list[str]:
    """Of the terms that are ever anything but 0."""
    return [*dict.fromkeys(name for step in steps for name, term in step["terms"].items() if term)]


def _velocity(odometry: Any) -> tuple[float, float]:
    return odometry.linear_velocity.x, odometry.angular_velocity.z
