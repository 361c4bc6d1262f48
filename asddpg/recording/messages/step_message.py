"""The JSON of a recording: /step, /cmd_vel and /outcome.

Missing and non-finite numbers are left out: a schema as Foxglove reads it has no null.
"""

from collections.abc import Mapping
from math import isfinite, nan
from typing import Any

import orjson

from asddpg.episodes.protocols import Action, Episode, Step
from asddpg.recording.samples import NANOSECONDS, Sample
from tasks.physics import compute_digest

_SCALE = 1e5
Velocity = dict[str, Any]  # v in m/s, omega in rad/s


def encode_step(sample: Sample, step: Step) -> bytes:
    """/step."""
    decision, info = step.decision, step.info
    terms = info.get("reward_terms", {})
    is_finite = isfinite(step.reward)  # and so are the terms, whose sum it is
    values = {
        "step": sample.number,
        "time": sample.time / NANOSECONDS,
        "driver": decision.driver,
        "action": _velocity(decision.action),
        "actor": _velocity(decision.actor_action),
        "controller": _velocity(decision.controller_action),
        "noise": _velocity(decision.noise),
        "q_policy": _rounded(decision.q_policy),
        "q_controller": _rounded(decision.q_controller),
        "value": _rounded(decision.value),
        "reward": step.reward if is_finite else None,
        "terms": terms if is_finite else _finite(terms),
        "distance": _rounded(info.get("distance")),
        "pushed": info.get("pushed", 0),
        "digest": compute_digest(sample.qpos, sample.qvel),
    }
    return encode_json({name: value for name, value in values.items() if value is not None})


def encode_command(step: Step) -> bytes:
    """/cmd_vel."""
    return encode_json(_velocity(step.decision.action))


def encode_outcome(episode: Episode | None) -> bytes:
    """/outcome: the episode's metrics, or that it is still running."""
    if episode is None:
        return encode_json({"outcome": "running"})
    metrics = {
        "steps": episode.steps,
        "total_reward": episode.total_reward,
        "controller_share": episode.controller_share,
        "path_length": episode.path_length,
    }
    return encode_json({"outcome": episode.outcome} | _finite(metrics))


def read_reward(step: Mapping[str, Any]) -> float:
    """The reward in a message of /step; NaN where it was not finite."""
    reward = step.get("reward")
    return nan if reward is None else float(reward)


def encode_json(message: Any) -> bytes:
    """Strict JSON: NaN and infinity become null; a float32 gets the few digits that give it back."""
    return orjson.dumps(message, option=orjson.OPT_SERIALIZE_NUMPY)


def _finite(numbers: Mapping[str, float]) -> dict[str, float]:
    return {name: number for name, number in numbers.items() if isfinite(number)}


def _velocity(action: Action | None) -> Velocity | None:
    """(v, ω) in the digits that give the same float32 back: the executed actions reproduce the episode."""
    return None if action is None else {"v": action[0], "omega": action[1]}


def _rounded(value: float | None) -> float | None:
    """Five digits, for plots; round(value, 5) would take three times as long."""
    return None if value is None or not isfinite(value) else round(value * _SCALE) / _SCALE
