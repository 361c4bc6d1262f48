"""Where the MJCF scenes lie and which compiled model they give."""

import hashlib
from pathlib import Path

import mujoco
import numpy as np

MODELS = Path(__file__).resolve().parent.parent / "models" / "mjcf"


def scene_path(task_name: str) -> Path:
    """The MJCF file of a task's scene."""
    return MODELS / f"{task_name}.xml"


def model_hash(model: mujoco.MjModel) -> str:
    """SHA-256 of the compiled model's bytes, 16 hex digits: names the model a result was made with."""
    buffer = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return hashlib.sha256(buffer.tobytes()).hexdigest()[:16]
