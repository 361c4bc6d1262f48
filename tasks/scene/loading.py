"""Where the MJCF scenes lie, how one is opened, and which compiled model it gives."""

import contextlib
import hashlib
import logging
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import mujoco
import numpy as np
from dm_control.mujoco import wrapper

from tasks.errors import TaskError
from tasks.laser import set_beams
from tasks.physics import Physics
from tasks.scene.checks import missing_elements, nonsense

MODELS = Path(__file__).resolve().parents[2] / "models" / "mjcf"
TASK_CAMERAS = ("chase", "top", "onboard")  # every registered task has them


def scene_path(task_name: str) -> Path:
    """The MJCF file of a task's scene."""
    return MODELS / f"{task_name}.xml"


def load_model(path: str | Path, num_beams: int | None = None) -> mujoco.MjModel:
    """Compile any MJCF file.

    Args:
        path: of the file.
        num_beams: beams to give the laser; None leaves it as it is.

    Raises:
        TaskError: no such file, MuJoCo cannot read it, or it holds numbers that make no sense.
    """
    if not Path(path).is_file():
        raise TaskError(f"there is no scene file {path}; an MJCF file, .xml, is expected")
    try:
        with _no_warning_of_nan():
            spec = mujoco.MjSpec.from_file(str(path))
            if num_beams is not None:
                set_beams(spec, num_beams)
            model = spec.compile()
    except TaskError:
        raise
    except ValueError as error:
        raise TaskError(f"the scene {path} cannot be compiled: {_one_line(str(error))}") from error
    fault = nonsense(model)
    if fault is not None:
        raise TaskError(f"the scene {path} {fault}")
    return model


def open_scene(path: str | Path, cameras: Sequence[str] = (), num_beams: int | None = None) -> Physics:
    """Open a scene with the robot.

    Args:
        path: its MJCF file.
        cameras: names of the cameras it must have.
        num_beams: of the laser; None leaves the scene's own.

    Raises:
        TaskError: as load_model, or an element is missing that every scene with the robot must have.
    """
    return robot_physics(load_model(path, num_beams), path, cameras)


def robot_physics(model: mujoco.MjModel, path: str | Path, cameras: Sequence[str] = ()) -> Physics:
    """The physics of a compiled scene with the robot; `path` is what errors call it. TaskError as open_scene."""
    missing = missing_elements(model, cameras)
    if missing:
        raise TaskError(
            f"the scene {path} lacks the {', the '.join(missing)}; pioneer/pioneer.xml brings the robot with its "
            "cameras, rooms/common.xml floor and goal, and a room the camera 'top'"
        )
    try:
        physics: Physics = Physics.from_model(wrapper.MjModel(model))
    except ValueError as error:
        raise TaskError(f"the scene {path} is none for the robot: {_one_line(str(error))}") from error
    return physics


def model_hash(model: mujoco.MjModel) -> str:
    """SHA-256 of the compiled model's bytes, 16 hex digits: names the model a result was made with."""
    buffer = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return hashlib.sha256(buffer.tobytes()).hexdigest()[:16]


@contextlib.contextmanager
def _no_warning_of_nan() -> Iterator[None]:
    """Without MuJoCo's warning, which dm_control logs, of a NaN somewhere in the file: nonsense() says where it is."""

    def other(record: logging.LogRecord) -> bool:
        return "'NaN'" not in record.getMessage()

    logger = logging.getLogger("absl")
    logger.addFilter(other)
    try:
        yield
    finally:
        logger.removeFilter(other)


def _one_line(message: str) -> str:
    """MuJoCo's message without line ends; it knows no line, or 0, of what stands in an included file."""
    parts = [line.strip().rstrip(".") for line in message.splitlines() if line.strip()]
    return re.sub(r"\bline 0\b", "in a file it includes", ", ".join(parts)).replace("XML Error: Error: ", "XML Error: ")
