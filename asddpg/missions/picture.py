"""A mission from above, in the manner of the paper's figure: room, targets, the path driven and the estimated one."""

import numpy as np

from asddpg.missions.log import MissionLog
from asddpg.missions.room_picture import BLACK, WALL, RoomPicture
from asddpg.planning.occupancy_grid import FloatArray
from tasks.room_geometry.obstacles import Obstacles

UNKNOWN, _EDGE = (250, 205, 60), (150, 118, 10)
TARGET, DRIVEN, _START = (31, 119, 180), (214, 39, 40), (44, 160, 44)
_DASH, _GAP = 0.12, 0.10  # m


def draw_mission(log: MissionLog, room: Obstacles, known: Obstacles, within: float) -> RoomPicture:
    """The picture of a mission.

    Args:
        log: of the mission.
        room: all obstacles.
        known: those on the map; the others are yellow.
        within: radius of the targets, metres.
    """
    picture, on_map = RoomPicture(room), set(known.outlines)
    picture.draw_outlines(outline for outline in room.outlines if outline in on_map)
    picture.draw_outlines((outline for outline in room.outlines if outline not in on_map), UNKNOWN, _EDGE)
    for number, target in enumerate(log.targets, 1):
        picture.draw_circle(target, within, TARGET, text=str(number))
    picture.draw_circle(log.mission.start[:2], 0.15, _START, is_filled=True)
    picture.draw_line(np.array(log.poses)[:, :2], DRIVEN, 0.05)
    for dash in _dashes(np.array(log.estimates)[:, :2]):
        picture.draw_line(dash, BLACK, 0.03)
    for touch in log.touches:
        picture.draw_cross(log.poses[touch.step][:2], DRIVEN)
    for text, colour in (("on the map", WALL), ("not on the map", UNKNOWN), ("targets", TARGET), ("driven", DRIVEN)):
        picture.add_legend(text, colour)
    picture.add_legend("estimated", BLACK, is_dashed=True)
    return picture


def _dashes(path: FloatArray) -> list[FloatArray]:
    """Pieces of a path, (n, 2), as long as a dash and a gap apart along it."""
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    dashes = []
    for begin in np.arange(0.0, lengths[-1], _DASH + _GAP):
        at = np.array([begin, min(begin + _DASH, lengths[-1])])
        dashes.append(np.stack([np.interp(at, lengths, path[:, axis]) for axis in (0, 1)], axis=-1))
    return dashes
