"""A room from straight above without perspective: a picture with one scale of pixels a metre."""

from dataclasses import dataclass

import numpy as np

from tasks.graphics.headless import mujoco
from tasks.graphics.rendering import Picture
from tasks.room_geometry.obstacles import Obstacles
from tools.drawing.picture_file import open_renderer

MARGIN = 0.1  # m around the room
HEIGHT = 10.0  # m of the view above the floor, above everything that stands on it


@dataclass(frozen=True)
class MapView:
    """The visible rectangle of the floor: its middle and its sides, metres, world frame."""

    x: float
    y: float
    width: float
    height: float

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, bottom and top edge, metres, world frame."""
        half_width, half_height = self.width / 2, self.height / 2
        return self.x - half_width, self.x + half_width, self.y - half_height, self.y + half_height

    def render(self, model: mujoco.MjModel, data: mujoco.MjData, pixels_per_metre: float) -> Picture:
        """The picture, uint8 (rows, columns, 3), x to the right and y upwards; TaskError without graphics library."""
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:] = self.x, self.y, 0.0
        camera.distance, camera.azimuth, camera.elevation = HEIGHT, 90.0, -90.0
        free = model.vis.global_
        before = free.orthographic, free.fovy
        free.orthographic, free.fovy = 1, self.height  # metres, in an orthographic view
        renderer = open_renderer(model, round(self.width * pixels_per_metre), round(self.height * pixels_per_metre))
        try:
            return renderer.render(data, camera)
        finally:
            renderer.close()
            free.orthographic, free.fovy = before


def fit_view(room: Obstacles) -> MapView:
    """The view that shows a whole room."""
    low, high = np.array(room.low), np.array(room.high)
    (x, y), (width, height) = ((low + high) / 2).tolist(), (high - low + 2 * MARGIN).tolist()
    return MapView(x, y, width, height)
