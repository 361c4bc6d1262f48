"""MJCF scenes: their files, opened and compiled, and the hash of a compiled one."""

import contextlib
import hashlib
import logging
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import mujoco
import numpy as np
from dm_control.mujoco import wrapper

from tasks.errors import TaskError
from tasks.laser import BeamRing, set_beams
from tasks.physics import Physics
from tasks.scene.checks import find_invalid_number, find_missing_elements

# An installed wheel holds models/ inside the package tasks, a checkout beside it.
_INSTALLED, _CHECKOUT = (folder / "models" for folder in Path(__file__).resolve().parents[1:3])
MODELS = (_INSTALLED if _INSTALLED.is_dir() else _CHECKOUT) / "mjcf"
TASK_CAMERAS = ("chase", "top", "onboard")  # every registered task has them


def scene_path(task_name: str) -> Path:
    """The MJCF file of a task's scene."""
    return MODELS / f"{task_name}.xml"


def load_model(
    path: str | Path, ring: BeamRing | None = None, prepare: Callable[[mujoco.MjSpec], None] = lambda _: None
) -> mujoco.MjModel:
    """Compile any MJCF file.

    Args:
        path: of the file.
        ring: beams to give the laser; None leaves it as it is.
        prepare: changes the scene before, such as its robot.

    Raises:
        TaskError: no such file, MuJoCo cannot read it, or it holds invalid numbers.
    """
    if not Path(path).is_file():
        raise TaskError(f"there is no scene file {path}; an MJCF file, .xml, is expected")
    spec = read_spec(path, "scene")
    prepare(spec)
    if ring is not None:
        set_beams(spec, ring)
    return compile_spec(spec, f"the scene {path}")


def read_spec(path: str | Path, kind: str) -> mujoco.MjSpec:
    """An MJCF file, not yet compiled; TaskError, which calls it a `kind`, where MuJoCo cannot read it."""
    try:
        with _suppress_nan_warning():
            return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise TaskError(f"the {kind} {path} cannot be compiled: {_join_lines(str(error))}") from error


def compile_spec(spec: mujoco.MjSpec, name: str) -> mujoco.MjModel:
    """The model of a scene; TaskError, which begins with `name`, where it is invalid."""
    try:
        with _suppress_nan_warning():
            model = spec.compile()
    except ValueError as error:
        raise TaskError(f"{name} cannot be compiled: {_join_lines(str(error))}") from error
    fault = find_invalid_number(model)
    if fault is not None:
        raise TaskError(f"{name} {fault}")
    return model


def open_scene(path: str | Path, cameras: Sequence[str] = (), ring: BeamRing | None = None) -> Physics:
    """Open a scene with the robot.

    Args:
        path: its MJCF file.
        cameras: names of the cameras it must have.
        ring: beams of the laser; None leaves the scene's own.

    Raises:
        TaskError: as load_model, or an element is missing that every scene with the robot must have.
    """
    return robot_physics(load_model(path, ring), path, cameras)


def robot_physics(model: mujoco.MjModel, path: str | Path, cameras: Sequence[str] = ()) -> Physics:
    """The physics of a compiled scene with the robot; errors name `path`. TaskError as open_scene."""
    missing = find_missing_elements(model, cameras)
    if missing:
        raise TaskError(
            f"the scene {path} lacks the {', the '.join(missing)}; pioneer/pioneer.xml brings the robot with its "
            "cameras, rooms/common.xml floor and goal, and a room the camera 'top'"
        )
    try:
        physics: Physics = Physics.from_model(wrapper.MjModel(model))
    except ValueError as error:
        raise TaskError(f"the scene {path} does not fit the robot: {_join_lines(str(error))}") from error
    return physics


def model_hash(model: mujoco.MjModel) -> str:
    """SHA-256 of the compiled model's bytes, 16 hex digits: identifies the model behind a result."""
    buffer = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return hashlib.sha256(buffer.tobytes()).hexdigest()[:16]


@contextlib.contextmanager
def _suppress_nan_warning() -> Iterator[None]:
    """Suppress MuJoCo's warning of a NaN, which dm_control logs: find_invalid_number() says where it is."""

    def is_other(record: logging.LogRecord) -> bool:
        return "'NaN'" not in record.getMessage()

    logger = logging.getLogger("absl")
    logger.addFilter(is_other)
    try:
        yield
    finally:
        logger.removeFilter(is_other)


def _join_lines(message: str) -> str:
    """MuJoCo's message in one line; for an included file MuJoCo gives no line, or line 0."""
    parts = [line.strip().rstrip(".") for line in message.splitlines() if line.strip()]
    return re.sub(r"\bline 0\b", "in a file it includes", ", ".join(parts)).replace("XML Error: Error: ", "XML Error: ")
