"""The JSON of a recording: what /step, /cmd_vel and /outcome say."""

from math import isfinite
from typing import Any

import orjson

from asddpg.recording.moments import NANOSECONDS, Moment
from asddpg.types import Action, Episode

_SCALE = 1e5  # what is only looked at has 5 digits after the point


def step_json(moment: Moment) -> bytes:
    """/step of a moment that ends a step."""
    assert moment.step is not None
    decision, info = moment.step.decision, moment.step.info
    return as_json(
        {
            "step": moment.number,
            "time": moment.time / NANOSECONDS,
            "driver": decision.driver,
            "action": _exactly(decision.action),
            "actor": _about(decision.actor_action),
            "controller": _about(decision.controller_action),
            "noise": _about(decision.noise),
            "q_policy": _rounded(decision.q_policy),
            "q_controller": _rounded(decision.q_controller),
            "value": _rounded(decision.value),
            "reward": _rounded(moment.step.reward),
            "terms": {name: _rounded(term) for name, term in info.get("reward_terms", {}).items()},
            "distance": _rounded(info.get("distance")),
            "pushed": info.get("pushed", 0),
            "digest": moment.digest,
        }
    )


def cmd_vel_json(moment: Moment) -> bytes:
    """/cmd_vel of a moment that ends a step."""
    assert moment.step is not None
    return as_json(_exactly(moment.step.decision.action))


def outcome_json(episode: Episode | None) -> bytes:
    """/outcome: the episode's figures, or that it is still running."""
    if episode is None:
        return as_json({"outcome": "running"})
    return as_json(
        {
            "outcome": episode.outcome,
            "steps": episode.steps,
            "total_reward": episode.total_reward,
            "controller_share": episode.controller_share,
            "path_length": episode.path_length,
        }
    )


def as_json(message: Any) -> bytes:
    """JSON proper: NaN and infinity, which JSON does not know, become null; a float32 gets its own few digits."""
    return orjson.dumps(message, option=orjson.OPT_SERIALIZE_NUMPY)


def _exactly(action: Action) -> dict[str, Any]:
    """(v, ω) in the digits that give the same float32 back: from it the episode can be run again."""
    return {"v": action[0], "omega": action[1]}


def _about(action: Action | None) -> dict[str, Any] | None:
    if action is None:
        return None
    v, omega = action.tolist()
    return {"v": _rounded(v), "omega": _rounded(omega)}


def _rounded(value: float | None) -> float | None:
    """To a few digits; round(value, 5) would take thrice as long."""
    return None if value is None or not isfinite(value) else round(value * _SCALE) / _SCALE
