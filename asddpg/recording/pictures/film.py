"""Episodes as a film, an .mp4 that any browser plays."""

import contextlib
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, SupportsFloat

import numpy as np
from PIL import Image

from asddpg.atomic_write import take_lock
from asddpg.episodes.protocols import Episode, Observation, Step
from asddpg.errors import UserError
from asddpg.recording.messages.path_message import DRIVER_COLOURS, OTHER_COLOUR
from asddpg.recording.pictures.caption import OUTCOME_COLOURS, Colour, captioned
from asddpg.recording.pictures.h264 import CODEC, OPTIONS, require_av
from tasks.graphics.rendering import OffscreenRenderer
from tasks.gymnasium_api.navigation_env import NavigationEnv

HOLD = 1.5  # s of film on an episode's last picture, to read how it ended
# The written part can be played up to its last second at any time, also after the process was killed.
_IN_PROGRESS = {"movflags": "empty_moov+default_base_moof", "frag_duration": "1000000", "flush_packets": "1"}
_FINISHED = {"movflags": "faststart"}


class Film:
    """Films episodes one after the other, a picture a control step.

    In progress it is `<path>.part`, which can be played as well.
    """

    def __init__(
        self,
        path: Path,
        environment: NavigationEnv,
        camera: str = "chase",
        width: int = 640,
        height: int = 480,
        control_timestep: float = 0.2,
        speed: float = 1.0,
    ) -> None:
        """Open the file and render a first picture, so that errors show at once.

        Args:
            path: of the film, .mp4; an existing one is replaced at the end.
            environment: to film.
            camera: of the scene, or `free`.
            width: px, even.
            height: px, even.
            control_timestep: seconds between two pictures.
            speed: 1 is real time, 2 twice as fast.

        Raises:
            UserError: PyAV is missing, or the file cannot be written, or another process is writing it.
            TaskError: no such camera, no such size, or no graphics library.
        """
        if path.suffix.lower() != ".mp4":
            raise UserError(f"a film's file must end in .mp4, not {path.name!r}")
        if width % 2 or height % 2:
            raise UserError(f"a film's width and height must be even, not {width} x {height}")
        self._av = require_av()
        self._path, self._camera = path, camera
        self.part = path.with_name(path.name + ".part")
        self._physics = environment.physics
        self._renderer = OffscreenRenderer(self._physics.model.ptr, width, height)
        try:
            self._image = self._rendered()
            self._rate = Fraction(speed / control_timestep).limit_denominator(1000)
            self._container: Any = None
            self._closing = contextlib.ExitStack()
            self._writing(self._open)
        except BaseException:
            self._renderer.close()
            raise
        self._episodes = self._frames = 0

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Show the beginning."""
        self._episodes += 1
        self._show("start")

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Show the state after the step."""
        driver = step.decision.driver.value
        self._show(f"{self._physics.data.time:.1f} s · {driver} drives", DRIVER_COLOURS.get(driver, OTHER_COLOUR))

    def end_episode(self, episode: Episode) -> None:
        """Show how it ended, long enough to be read."""
        text = f"{episode.outcome} after {self._physics.data.time:.1f} s"
        for _ in range(max(1, round(HOLD * self._rate))):
            self._write(text, OUTCOME_COLOURS.get(episode.outcome))

    def close(self) -> None:
        """Complete the film; may be called again.

        Raises:
            UserError: it could not be written; its written part stays as `<path>.part`.
        """
        self._renderer.close()
        if self._container is not None:
            self._writing(self._finish)

    # Pictures -----------------------------------------------------------------------------------------------------

    def _rendered(self) -> Image.Image:
        return Image.fromarray(self._renderer.render(self._physics.data.ptr, self._camera))

    def _show(self, text: str, colour: Colour | None = None) -> None:
        self._image = self._rendered()
        self._write(text, colour)

    def _write(self, text: str, colour: Colour | None = None) -> None:
        image = captioned(self._image, f"episode {self._episodes} · {text}", colour)
        frame = self._av.VideoFrame.from_ndarray(np.asarray(image), format="rgb24")
        frame.pts, self._frames = self._frames, self._frames + 1
        self._writing(lambda: self._container.mux(self._stream.encode(frame)))

    # File ---------------------------------------------------------------------------------------------------------

    def _open(self) -> None:
        lock = self._closing.enter_context(self.part.open("ab"))  # until it is closed: one process films at a time
        take_lock(lock)
        # "file:" lets no colon in a name make a protocol of it.
        self._container = self._av.open(f"file:{self.part}", "w", format="mp4", options=_IN_PROGRESS)
        stream = self._container.add_stream(CODEC, rate=self._rate, options=OPTIONS)
        stream.width, stream.height, stream.pix_fmt = *self._image.size, "yuv420p"
        stream.codec_context.thread_count = 1
        stream.time_base = stream.codec_context.time_base = 1 / self._rate
        self._container.start_encoding()  # or else the file would be made with the first picture
        self._stream = stream

    def _finish(self) -> None:
        container, self._container = self._container, None
        container.mux(self._stream.encode(None))
        container.close()
        if self._frames:
            self._copy_whole()
        self.part.unlink()
        self._closing.close()

    def _copy_whole(self) -> None:
        """The same packets with a table of contents, at the beginning: players then know how long it is."""
        whole = self._path.with_name(self._path.name + ".new")
        try:
            with (
                self._av.open(f"file:{self.part}") as source,
                self._av.open(f"file:{whole}", "w", format="mp4", options=_FINISHED) as target,
            ):
                stream = target.add_stream_from_template(source.streams.video[0])
                for packet in source.demux(video=0):
                    if packet.dts is not None:
                        packet.stream = stream
                        target.mux(packet)
            whole.replace(self._path)
        except BaseException:
            whole.unlink(missing_ok=True)
            raise

    def _writing(self, act: Callable[[], object]) -> None:
        try:
            act()
        except (OSError, self._av.error.FFmpegError) as error:
            container, self._container = self._container, None
            with contextlib.suppress(OSError, self._av.error.FFmpegError):
                if container is not None:
                    container.close()
            self._closing.close()
            left = f"; {self.part} holds the film so far" if self.part.is_file() else ""
            if isinstance(error, BlockingIOError):
                raise UserError(f"another process is writing the film {self._path}; choose another video=") from error
            reason = getattr(error, "strerror", None) or error
            raise UserError(f"the film {self._path} cannot be written: {reason}{left}") from error
