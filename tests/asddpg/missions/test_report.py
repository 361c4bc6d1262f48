"""A mission's line, and missions.csv."""

import csv
from pathlib import Path

import pytest

from asddpg.missions.report import COLUMNS, MissionRow, summarize, write_rows
from tests.support.missions import Pose, log_of

TARGETS = ((1.0, 0.0), (2.0, 0.0))


def row(number: int = 1, failure: str = "") -> MissionRow:
    """Ten steps of 0.1 m, the estimate 0.00, 0.01, …, 0.10 m and 1, 2, … degrees off."""
    places: list[tuple[Pose, Pose]] = [
        ((0.1 * step, 0.0, 0.0), (0.1 * step, 0.01 * step, 0.0174533 * (step + 1))) for step in range(11)
    ]
    return MissionRow.of_log(log_of(places, TARGETS, [{}] * 8 + [{"target": 1}] * 2), number, 0.2, failure)


def test_figures_are_those_of_the_log() -> None:
    found = row()
    assert (found.outcome, found.reached, found.targets) == ("timeout", 1, 2)
    assert (found.seconds, found.path) == pytest.approx((2.0, 1.0))
    assert found.errors == pytest.approx((0.05, 0.095, 0.1))
    assert found.heading == pytest.approx(6.0, abs=1e-3)


def test_a_mission_is_a_line() -> None:
    way = "1 of 2 targets in 2 s and 1.0 m; estimate 0.050 m off, 0.10 at most"
    assert row(3, "touched bin").describe() == f"mission 3: touched bin; {way}"
    assert row().describe() == f"mission 1: all targets reached, nothing touched; {way}"


def test_the_summary_counts_missions_and_targets() -> None:
    text = summarize([row(), row(), row(failure="touched bin"), row()])
    assert text.startswith("3 of 4 missions succeeded, 0.75 [0.")
    assert text.endswith("; 4 of 8 targets reached")


def test_rows_are_written_and_a_reason_with_commas_stays_whole(tmp_path: Path) -> None:
    path, reason = tmp_path / "missions.csv", "touched bin, not on the map, on the way to target 2"
    write_rows([row(), row(2, reason)], path)
    with path.open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(COLUMNS)
    assert [found["failure"] for found in rows] == ["", reason]
    assert rows[1] | {"failure": ""} == {
        "mission": "2", "outcome": "timeout", "reached": "1", "targets": "2", "seconds": "2.000", "path_m": "1.000",
        "error_median_m": "0.050", "error_q95_m": "0.095", "error_max_m": "0.100", "heading_median_deg": "6.000",
        "failure": "",
    }  # fmt: skip
