"""Failures of a driver, on episodes made by hand."""

from tasks.physics import Pose
from tasks.room_geometry.held_out import Pair
from tools.publishing.failures import DrivenEpisode, report


def drive(goal: tuple[float, float], length: float, outcome: str) -> DrivenEpisode:
    return DrivenEpisode(Pair(Pose(0.0, 0.0, 0.0), goal, length), outcome, (1.0, 0.0))


def test_nothing_failed() -> None:
    assert report([drive((1.0, 1.0), 1.2, "reached")]) == "On none of the 1 pairs."


def test_kinds_lengths_and_regions() -> None:
    drives = [drive((3.0, -0.5), 2.5, "reached"), drive((2.0, -2.0), 2.0, "crashed")]
    drives += [
        drive((3.1, -0.1), 2.9, "crashed"),
        drive((3.2, -1.9), 3.0, "timeout"),
        drive((-1.0, 1.0), 1.5, "timeout"),
    ]
    text = report(drives)
    assert "It fails on 4 of 5 pairs: 2 crashed, 2 timed out; 0 end within 1 m of the goal." in text
    assert "| 2 to 3 m | 3 | 1 | 2 | 0 |" in text
    assert "| 3 to 4 m | 1 | 0 | 0 | 1 |" in text
    rows = [line for line in text.splitlines() if line.startswith("| x ")]
    assert rows[0].startswith("| x 2 to 4, y -2 to 0 | 3 of 4 | 2 crashed, 1 timed out | (0.00, 0.00) → (2.00, -2.00)")
    assert rows[1].startswith("| x -2 to 0, y 0 to 2 | 1 of 1 |")


def test_only_the_worst_are_written_out() -> None:
    drives = [drive((2.0 * index + 0.5, 0.5), 2.0, "crashed") for index in range(8)]
    text = report(drives)
    assert "It fails on 8 of 8 pairs: 8 crashed; 1 ends within 1 m of the goal." in text
    assert len([line for line in text.splitlines() if line.startswith("| x ")]) == 5
    assert "The other 3 lie elsewhere; `test.json` lists every failure" in text
