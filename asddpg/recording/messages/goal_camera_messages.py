"""Small messages of Foxglove's: times, the goal, pictures."""

import numpy as np
import numpy.typing as npt
from foxglove.messages import CompressedImage, CompressedVideo, Pose, PoseInFrame, Quaternion, Timestamp, Vector3

from asddpg.recording.samples import NANOSECONDS
from tasks.physics import FloatArray
from tasks.scene.shapes import WORLD

_GRID = 4096.0  # steps a metre


def round_to_grid(values: npt.NDArray[np.floating]) -> FloatArray:
    """Numbers rounded to 1/4096 (0.12 mm off): the lower bytes of such a double are zeros, which compress well."""
    rounded: FloatArray = np.rint(values * np.float64(_GRID)) / _GRID + 0.0  # without the sign of −0
    return rounded


def make_timestamp(time: int) -> Timestamp:
    """Foxglove's time of simulated nanoseconds."""
    return Timestamp(sec=time // NANOSECONDS, nsec=time % NANOSECONDS)


def goal_pose(goal: tuple[float, float], time: int) -> PoseInFrame:
    """The goal on the floor, metres, world frame."""
    x, y = goal
    pose = Pose(position=Vector3(x=x, y=y), orientation=Quaternion(w=1.0))
    return PoseInFrame(timestamp=make_timestamp(time), frame_id=WORLD, pose=pose)


def picture_message(camera: str, picture: bytes, time: int, is_video: bool) -> CompressedImage | CompressedVideo:
    """A camera's picture, as JPEG or as a frame of H.264."""
    if is_video:
        return CompressedVideo(timestamp=make_timestamp(time), frame_id=camera, data=picture, format="h264")
    return CompressedImage(timestamp=make_timestamp(time), frame_id=camera, data=picture, format="jpeg")
