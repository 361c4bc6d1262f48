"""Which compiled scene a task has today: figures measured in another one are of another experiment."""

import functools

from tasks.scene.loading import load_model, model_hash, scene_path


@functools.cache
def scene_today(task_name: str, num_beams: int) -> str:
    """Hash of a task's compiled scene, as asddpg.train notes it."""
    return model_hash(load_model(scene_path(task_name), num_beams))
