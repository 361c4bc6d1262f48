"""Figures and differences of episodes made up by hand."""

from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from asddpg.episodes.intervals import Estimate
from asddpg.episodes.protocols import Episode
from tools.comparison.driven_episodes import DrivenCase, DrivenEpisode
from tools.comparison.figures import figures_of, paired_differences
from tools.comparison.smoothness import Smoothness, measure_smoothness
from tools.comparison.tables import write_tables

NOTHING = Estimate(None, None, None)
SMOOTH = Smoothness(changes=0, total_change=0.0, large_changes=0, sign_flips=0)


def episode(goal: float, outcome: str, steps: int, driven: float, smoothness: Smoothness = SMOOTH) -> DrivenEpisode:
    """From the origin to (goal, 0), whose shortest path is 2 m."""
    statistics = Episode(outcome, steps, path_length=driven)
    return DrivenEpisode("nav_empty", (0.0, 0.0, 0.0), (goal, 0.0), 2.0, statistics, smoothness, 1.0)


def case(driver: str, *episodes: DrivenEpisode, **task: float | str) -> DrivenCase:
    constants = {"name": "nav_empty", "control_timestep": 0.2, **task}
    return DrivenCase({"driver": driver, "task": constants}, {"asddpg": "1"}, 1.5, list(episodes))


OURS = case(
    "ours",
    episode(1, "reached", 50, 2.5),
    episode(2, "reached", 40, 2.0),
    episode(3, "crashed", 10, 1.0),
    episode(9, "reached", 10, 2.0),  # which the other did not drive
)
THEIRS = case(
    "theirs",
    episode(3, "reached", 60, 4.0),
    episode(2, "reached", 50, 2.5),
    episode(1, "reached", 50, 4.0),
)


def student(values: list[float]) -> tuple[float, float, float]:
    half = stats.t.ppf(0.975, len(values) - 1) * np.std(values, ddof=1) / np.sqrt(len(values))
    return float(np.mean(values)), float(np.mean(values) - half), float(np.mean(values) + half)


def test_differences_are_those_of_the_pairs_that_both_drove() -> None:
    pairs, found = paired_differences(OURS, THEIRS)
    assert pairs == 3
    assert (found["success_rate"].value, found["collision_rate"].value) == pytest.approx((-1 / 3, 1 / 3))
    assert found["success_rate"].low == -1.0  # the interval ends where a difference of rates does
    assert found["metric"] == pytest.approx(student([0.0, 0.1, -0.1 - 1.4]))
    assert found["time"] == pytest.approx(student([0.0, -2.0]))  # s, of the goals 1 and 2
    assert found["spl"][:2] == pytest.approx((student([0.8 - 0.5, 1.0 - 0.8, -0.5])[0], -1.0), abs=1e-9)


def test_a_single_pair_has_no_interval_and_none_no_difference() -> None:
    alone = case("alone", episode(1, "timeout", 200, 9.0))
    pairs, found = paired_differences(alone, THEIRS)
    assert (pairs, found["success_rate"], found["time"]) == (1, Estimate(-1.0, None, None), NOTHING)
    pairs, found = paired_differences(case("far", episode(7, "reached", 9, 2.0)), THEIRS)
    assert (pairs, set(found.values())) == (0, {NOTHING})


def test_smoothness_by_hand() -> None:
    # Changes: 0.5, not above it; 0.9, a flip; 0.6 to a slow turn the other way, none; 0.2; 0.8, a flip.
    found = measure_smoothness([0.0, 0.5, -0.4, 0.2, 0.4, -0.4])
    assert (found.changes, found.large_changes, found.sign_flips) == (5, 3, 2)
    assert found.total_change == pytest.approx(0.5 + 0.9 + 0.6 + 0.2 + 0.8)
    assert measure_smoothness([1.0]) == SMOOTH


def test_smoothness_counts_every_change_of_all_episodes_alike() -> None:
    short, long = Smoothness(10, 5.0, 4, 2), Smoothness(90, 5.0, 1, 0)
    found = figures_of(case("ours", episode(1, "reached", 11, 2.0, short), episode(2, "reached", 91, 2.0, long)))
    values = [found[name].value for name in ("turn_change", "large_changes", "sign_flips")]
    assert values == pytest.approx([10 / 100, 5 / 100, 2 / 100])
    # A ratio's interval: of what each episode has beyond the ratio times its length, by the mean length of 50.
    assert found["turn_change"].high == pytest.approx(student([0.1 + 4.0 / 50, 0.1 - 4.0 / 50])[2])
    assert found["turn_change"].low == 0.0
    assert found["decision_ms"] == Estimate(1.5, None, None)
    assert figures_of(OURS)["turn_change"] == NOTHING


def test_an_interval_of_a_ratio_holds_it_in_19_of_20_samples() -> None:
    rng, held = np.random.default_rng(0), 0
    for _ in range(150):
        lengths = rng.integers(20, 200, size=60)
        amounts = rng.binomial(lengths, rng.beta(2, 8, size=60))  # 0.2 a change, episodes unlike one another
        episodes = [
            episode(number, "reached", 1, 2.0, Smoothness(int(changes), 0.0, int(amount), 0))
            for number, (changes, amount) in enumerate(zip(lengths, amounts, strict=True))
        ]
        found = figures_of(case("ours", *episodes))["large_changes"]
        assert found.low is not None
        assert found.high is not None
        held += found.low <= 0.2 <= found.high
    assert 0.9 <= held / 150 <= 0.99


def test_the_tables_say_in_which_constants_and_versions_the_drivers_differ(tmp_path: Path) -> None:
    slow = case("slow", *THEIRS.episodes, goal_radius=0.5)
    newer = DrivenCase({**THEIRS.conditions, "driver": "newer"}, {"asddpg": "2"}, 1.5, THEIRS.episodes)
    text = write_tables([case("ours", *OURS.episodes, goal_radius=0.3), slow], "ours", tmp_path)
    assert "- In nav_empty task.goal_radius differs: 0.3 of ours, 0.5 of slow." in text
    assert "versions" not in text
    assert "- Not all were driven with the same versions" in write_tables([THEIRS, newer], "newer", tmp_path)
    assert "| theirs | nav_empty | 3 | +0.000 [+0.000, +0.000] |" in (tmp_path / "table.md").read_text()
    assert "0.5 of slow" in (tmp_path / "table_1.md").read_text()


def test_an_empty_differences_table_is_left_out(tmp_path: Path) -> None:
    assert "paired" not in write_tables([OURS], "ours", tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["table.csv", "table.md"]


def test_a_file_is_read_as_it_was_written_and_another_is_kept(tmp_path: Path) -> None:
    OURS.write(tmp_path / "case.json")
    assert DrivenCase.read(tmp_path / "case.json") == OURS
    THEIRS.write(tmp_path / "case.json")
    assert DrivenCase.read(tmp_path / "case_1.json") == OURS
