"""The topics of a recording: names, and the schemas of those that are JSON.

Foxglove's viewer reads a schema with one type to a field and properties to each object, or not at all, and then shows
nothing of its topic. So a schema has the type of the value, and a message leaves out missing values.
"""

from typing import Any

TF, SCAN, SCENE, PATH = "/tf", "/scan", "/scene", "/path"
GOAL, ODOM, CMD_VEL = "/goal", "/odom", "/cmd_vel"
STEP, OUTCOME, LOG = "/step", "/outcome", "/log"
MAP, PLAN, PARTICLES, AMCL_POSE = "/map", "/plan", "/particles", "/amcl_pose"  # of drivers that plan
CAMERA = "/camera/"  # and the camera's name

Schema = dict[str, Any]


def _object(**properties: Schema) -> Schema:
    return {"type": "object", "properties": properties}


_NUMBER: Schema = {"type": "number"}
_TEXT: Schema = {"type": "string"}
_VELOCITY = _object(v=_NUMBER, omega=_NUMBER)

# v in m/s, omega in rad/s.
CMD_VEL_SCHEMA = _VELOCITY

# The decision of a step, the values behind it, and its reward. `step` counts from 0 in the episode;
# `time` is that at the step's end, s; actions in m/s and rad/s, `actor` before noise; `terms` of the reward by name;
# `distance` to the goal after the step, m; `digest` names the physical state after the step.
# Missing and non-finite values are left out.
STEP_SCHEMA = _object(
    step=_NUMBER,
    time=_NUMBER,
    driver=_TEXT,
    action=_VELOCITY,
    actor=_VELOCITY,
    controller=_VELOCITY,
    noise=_VELOCITY,
    q_policy=_NUMBER,
    q_controller=_NUMBER,
    value=_NUMBER,
    reward=_NUMBER,
    terms=_object() | {"additionalProperties": _NUMBER},
    distance=_NUMBER,
    pushed=_NUMBER,
    digest=_NUMBER,
)

# `outcome` is running, then reached, crashed, timeout or cut; the metrics are those of the whole episode, absent
# before its end; `path_length` in m.
OUTCOME_SCHEMA = _object(
    outcome=_TEXT,
    steps=_NUMBER,
    total_reward=_NUMBER,
    controller_share=_NUMBER,
    path_length=_NUMBER,
)
