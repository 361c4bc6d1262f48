"""H.264 by PyAV, which is an extra: imported when the first encoder is made."""

from fractions import Fraction
from typing import Any

from asddpg.errors import UserError, import_extra
from tasks.graphics.rendering import Picture

CODEC = "libx264"
# No frame waits for another: each goes in and comes out. A keyframe begins with the parameters of the stream.
OPTIONS = {"preset": "fast", "tune": "zerolatency", "crf": "28", "forced-idr": "1"}


def require_av() -> Any:
    """PyAV.

    Raises:
        UserError: it is not installed, or cannot write H.264.
    """
    av = import_extra("av", "video", "videos")
    if CODEC not in av.codecs_available:
        raise UserError(f"video needs {CODEC}, which this build of PyAV lacks; the wheels on PyPI have it")
    return av


class VideoEncoder:
    """A stream of pictures as H.264 in Annex B, a packet each, as Foxglove's CompressedVideo wants them."""

    def __init__(self, width: int, height: int, keyframe_every: int = 10) -> None:
        """Encode pictures of width × height px, both even."""
        self._av = require_av()
        context: Any = self._av.CodecContext.create(CODEC, "w")
        context.width, context.height, context.pix_fmt = width, height, "yuv420p"
        context.time_base, context.thread_count = Fraction(1, 1), 1
        context.gop_size, context.max_b_frames = keyframe_every, 0
        context.options = OPTIONS
        self._context, self._count = context, 0

    def encode(self, picture: Picture, is_first: bool) -> bytes:
        """One picture; the first of a recording stands for itself."""
        frame = self._av.VideoFrame.from_ndarray(picture, format="rgb24")
        frame.pts, self._count = self._count, self._count + 1
        if is_first:
            frame.pict_type = self._av.video.frame.PictureType.I
        (packet,) = self._context.encode(frame)
        return bytes(packet)
