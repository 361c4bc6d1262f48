"""The topics of a recording: names, and the schemas of those that are JSON."""

from typing import Any

TF, SCAN, SCENE, PATH = "/tf", "/scan", "/scene", "/path"
GOAL, ODOM, CMD_VEL = "/goal", "/odom", "/cmd_vel"
STEP, OUTCOME, LOG = "/step", "/outcome", "/log"
CAMERA = "/camera/"  # and the camera's name

Schema = dict[str, Any]


def _object(**properties: Schema) -> Schema:
    return {"type": "object", "properties": properties}


_NUMBER: Schema = {"type": "number"}
_MAYBE: Schema = {"type": ["number", "null"]}
_TEXT: Schema = {"type": "string"}


_VELOCITY: Schema = {"type": ["object", "null"], "properties": {"v": _NUMBER, "omega": _NUMBER}}

# v in m/s, omega in rad/s.
CMD_VEL_SCHEMA = _object(v=_NUMBER, omega=_NUMBER)

# What was chosen in a step, what was weighed in choosing, and what it earned. `time` is that at the step's end, s;
# `step` counts from 0 in the episode; actions in m/s and rad/s, `actor` before noise; `distance` to the goal after the
# step, m; `digest` names the physical state after the step (tasks.state_digest).
STEP_SCHEMA = _object(
    step=_NUMBER,
    time=_NUMBER,
    driver=_TEXT,
    action=_VELOCITY,
    actor=_VELOCITY,
    controller=_VELOCITY,
    noise=_VELOCITY,
    q_policy=_MAYBE,
    q_controller=_MAYBE,
    value=_MAYBE,
    reward=_NUMBER,
    terms={"type": "object", "additionalProperties": _NUMBER},
    distance=_NUMBER,
    pushed=_NUMBER,
    digest=_NUMBER,
)

# `outcome` is running, then reached, crashed, timeout or cut; the figures are those of the whole episode, null before
# its end; `path_length` in m.
OUTCOME_SCHEMA = _object(
    outcome=_TEXT,
    steps=_MAYBE,
    total_reward=_MAYBE,
    controller_share=_MAYBE,
    path_length=_MAYBE,
)
