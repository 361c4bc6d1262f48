"""Encoded pictures of the scene's cameras, for recordings."""

import io
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from PIL import Image

from asddpg.recording.pictures.h264 import VideoEncoder
from tasks.graphics.rendering import OffscreenRenderer, Picture
from tasks.gymnasium_api.navigation_env import NavigationEnv

JPEG_QUALITY = 80


class Cameras:
    """Some cameras of an environment's scene."""

    def __init__(
        self, environment: NavigationEnv, names: Sequence[str], width: int, height: int, is_video: bool
    ) -> None:
        """Open them, and take a picture with each, so that errors show before a run begins.

        Args:
            environment: with the scene.
            names: of the cameras; `free` is the overall view.
            width: of the pictures, px.
            height: of the pictures, px.
            is_video: H.264 instead of JPEG.

        Raises:
            TaskError: no such camera, no such size, or no graphics library.
            UserError: no encoder.
        """
        self.names, self.is_video = tuple(names), is_video
        self._encoders = {name: VideoEncoder(width, height) for name in names} if is_video else {}
        self._physics = environment.physics
        self._renderer = OffscreenRenderer(self._physics.model.ptr, width, height, smooth=False)
        for name in names:
            self._render(name)

    def take(self, is_first: bool) -> Mapping[str, bytes]:
        """What each camera sees now; `is_first` in an episode."""
        return {name: self._encoded(name, is_first) for name in self.names}

    def stills(self) -> "Stills":
        """The same cameras, for the live view."""
        return Stills(self.names, self._render)

    def close(self) -> None:
        """Free the renderer; may be called again."""
        self._renderer.close()

    def _render(self, name: str) -> Picture:
        return self._renderer.render(self._physics.data.ptr, name)

    def _encoded(self, name: str, is_first: bool) -> bytes:
        picture = self._render(name)
        return self._encoders[name].encode(picture, is_first) if self.is_video else encode_jpeg(picture)


class Stills(NamedTuple):
    """Cameras for the live view: JPEG, since a late subscriber cannot decode a video from its middle."""

    names: tuple[str, ...]
    render: Callable[[str], Picture]

    def take(self, is_first: bool) -> Mapping[str, bytes]:
        """What each camera sees now."""
        return {name: encode_jpeg(self.render(name)) for name in self.names}


def encode_jpeg(picture: Picture) -> bytes:
    """A picture in JPEG."""
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, "JPEG", quality=JPEG_QUALITY)
    return buffer.getvalue()
