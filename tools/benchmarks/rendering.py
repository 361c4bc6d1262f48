"""Cost of pictures, for tools.bench."""

import time

import numpy as np

import tasks
from tasks.graphics.rendering import OffscreenRenderer
from tasks.physics import Physics
from tasks.scene.loading import TASK_CAMERAS

WIDTH, HEIGHT = 320, 240  # px
RUNS, FRAMES = 7, 20
BAR = 20.0  # ms


def rendering() -> None:
    """Print the CPU time of a picture of nav_complex, which is all of its time with software EGL."""
    environment = tasks.load("nav_complex", random=0)
    environment.reset()
    physics = environment.physics
    for smooth in (False, True):
        kind = "edges smoothed" if smooth else "as recorded"
        renderer = OffscreenRenderer(physics.model.ptr, WIDTH, HEIGHT, smooth)
        try:
            for camera in TASK_CAMERAS:
                renderer.render(physics.data.ptr, camera)
                runs = [_milliseconds(renderer, physics, camera) for _ in range(RUNS)]
                bar = "" if smooth else f"bar: under {BAR:g}; "
                print(
                    f"{camera}, {WIDTH}x{HEIGHT}, {kind}: {np.median(runs):.1f} ms of CPU a picture ({bar}runs "
                    f"{min(runs):.1f} to {max(runs):.1f})"
                )
        finally:
            renderer.close()


def _milliseconds(renderer: OffscreenRenderer, physics: Physics, camera: str) -> float:
    """CPU time a picture, all threads together."""
    begun = time.process_time()
    for _ in range(FRAMES):
        renderer.render(physics.data.ptr, camera)
    return (time.process_time() - begun) / FRAMES * 1e3
