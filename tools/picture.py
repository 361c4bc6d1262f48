"""A picture of a task's scene: `python -m tools.picture nav_complex [camera] [file.png]`."""

from collections.abc import Sequence
from pathlib import Path

import gymnasium
import numpy as np
from PIL import Image

import tasks
from asddpg.errors import UserError
from asddpg.program import run

WIDTH, HEIGHT = 1280, 800


def main(words: Sequence[str]) -> None:
    """Render and write."""
    if not 1 <= len(words) <= 3 or words[0] not in tasks.ALL_TASKS:
        raise UserError(f"name a task, one of {', '.join(tasks.ALL_TASKS)}, then if wanted a camera and a file")
    camera = words[1] if len(words) > 1 else "free"
    path = Path(words[2] if len(words) > 2 else f"{words[0]}_{camera}.png")
    name = tasks.gymnasium_id(words[0])
    environment = gymnasium.make(name, render_mode="rgb_array", camera=camera, width=WIDTH, height=HEIGHT)
    environment.reset(seed=3)
    picture = np.asarray(environment.render())
    try:
        Image.fromarray(picture).save(path)
    except OSError as error:
        raise UserError(f"the picture {path} cannot be written: {error}") from error
    environment.close()
    print(f"written to {path}")


if __name__ == "__main__":
    run(main, str(__doc__))
