"""The JSON of a recording: what /step, /cmd_vel and /outcome say.

What nobody gave, or is no finite number, is left out: a schema as Foxglove reads it knows no null.
"""

from collections.abc import Mapping
from math import isfinite, nan
from typing import Any

import orjson

from asddpg.episodes.protocols import Action, Episode, Step
from asddpg.recording.samples import NANOSECONDS, Moment, Reading
from tasks.physics import compute_digest

_SCALE = 1e5
_MICROSECOND = 1_000  # ns: what is smaller is rounding errors
Velocity = dict[str, Any]  # v in m/s, omega in rad/s


def told(reading: Reading) -> Moment:
    """What is told of a reading."""
    number, step, observation, seconds, positions, quaternions, qpos, qvel, pictures = reading
    time = round(seconds * (NANOSECONDS / _MICROSECOND)) * _MICROSECOND
    if step is None:
        return Moment(number, time, "", b"", b"", observation, positions, quaternions, pictures)
    action = _velocity(step.decision.action)
    message = as_json(_step(step, number, time / NANOSECONDS, action, compute_digest(qpos, qvel)))
    driver, command = step.decision.driver.value, as_json(action)
    return Moment(number, time, driver, message, command, observation, positions, quaternions, pictures)


def reward_of(moment: Moment) -> float:
    """What its step earned, 0 where there was none; NaN where that was no finite number."""
    return reward_in(orjson.loads(moment.step)) if moment.step else 0.0


def reward_in(step: Mapping[str, Any]) -> float:
    """What a message of /step says that the step earned; NaN where that was no finite number."""
    reward = step.get("reward")  # recordings of old have null there
    return nan if reward is None else float(reward)


def _step(step: Step, number: int, time: float, action: Velocity | None, digest: int) -> dict[str, Any]:
    decision, info = step.decision, step.info
    terms = info.get("reward_terms", {})
    is_finite = isfinite(step.reward)  # and so are the terms, whose sum it is
    everything = {
        "step": number,
        "time": time,
        "driver": decision.driver,
        "action": action,
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
        "digest": digest,
    }
    return {name: value for name, value in everything.items() if value is not None}


def outcome_json(episode: Episode | None) -> bytes:
    """/outcome: the episode's figures, or that it is still running."""
    if episode is None:
        return as_json({"outcome": "running"})
    metrics = {
        "steps": episode.steps,
        "total_reward": episode.total_reward,
        "controller_share": episode.controller_share,
        "path_length": episode.path_length,
    }
    return as_json({"outcome": episode.outcome} | _finite(metrics))


def _finite(numbers: Mapping[str, float]) -> dict[str, float]:
    return {name: number for name, number in numbers.items() if isfinite(number)}


def as_json(message: Any) -> bytes:
    """JSON proper: NaN and infinity, which JSON does not know, become null; a float32 gets its own few digits."""
    return orjson.dumps(message, option=orjson.OPT_SERIALIZE_NUMPY)


def _velocity(action: Action | None) -> Velocity | None:
    """(v, ω) in the digits that give the same float32 back: from the executed one the episode can be run again."""
    return None if action is None else {"v": action[0], "omega": action[1]}


def _rounded(value: float | None) -> float | None:
    """To a few digits, for what is only looked at; round(value, 5) would take thrice as long."""
    return None if value is None or not isfinite(value) else round(value * _SCALE) / _SCALE
