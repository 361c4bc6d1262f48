"""Metrics of finished runs, and the tables made of them."""

from pathlib import Path
from typing import Any

import pytest

from asddpg.build import make_environment
from asddpg.command_line import train_config
from asddpg.episodes.intervals import Estimate
from asddpg.errors import UserError
from asddpg.runs.provenance import environment_hash
from tasks.laser import BeamRing
from tests.support.fake_runs import finish, finish_group
from tools.experiments.run_metrics import METRICS, Metrics
from tools.experiments.run_store import RunStore
from tools.experiments.runs import Group, current_scene
from tools.experiments.tables import describe_provenance, markdown, runs_table

GROUP = Group("nav_empty", ("task=nav_empty",), 1000, (0, 1, 2))
DDPG = Group("DDPG", ("task=nav_empty", "agent=ddpg"), 1000, (0,))


def metrics(folder: Path, group: Group = GROUP, **made_up: Any) -> Metrics:
    """Those of a made-up run."""
    finish(folder, group.run(0), **made_up)
    found = RunStore(folder).find(group.run(0))
    assert found
    return found.metrics


def test_metrics_of_a_run(tmp_path: Path) -> None:
    shares = [0.1] * 25 + [0.2] * 25 + [0.3] * 25 + [0.4] * 15 + [0.9] * 10
    validations = [1, 0.1, 0.9, 0.8, 0.2, 0.3, 0.4, 0.5]
    outcomes = ("reached", "reached", "reached", "crashed")
    assert metrics(
        tmp_path, success=0.7, outcomes=outcomes, shares=shares, validations=validations
    ) == pytest.approx({
        "success_training": 0.75, "success_last": 0.7, "collision_last": 0.3, "success_best": 0.8,
        "share_1": 0.1, "share_2": 0.2, "share_3": 0.3, "share_4": (15 * 0.4 + 10 * 0.9) / 25, "share_end": 0.9,
        "switch_prefers": None, "last_five": (0.8 + 0.2 + 0.3 + 0.4 + 0.5) / 5,
        "best_five": (1 + 0.9 + 0.8 + 0.5 + 0.4) / 5, "swing": 0.28, "steps_per_second": 100, "memory_mb": 500,
    })  # fmt: skip


def test_only_the_last_200_episodes_count_and_none_that_was_cut(tmp_path: Path) -> None:
    path = finish(tmp_path, GROUP.run(0))
    rows = ["1,reached,1,0"] * 50 + ["1,crashed,1,0"] * 150 + ["1,reached,1,0"] * 50 + ["1,cut,1,0"]
    (path / "metrics.csv").write_text("\n".join(["step,outcome,steps,controller_share", *rows]))
    assert "| nav_empty, seed 0 | 0.250 |" in _table(GROUP, tmp_path)[2]


def test_where_there_is_nothing_to_measure(tmp_path: Path) -> None:
    untested = Group("", ("task=nav_empty", "agent=ddpg", "test_episodes=0"), 1000, (0,))
    path = finish(tmp_path, untested.run(0))
    for name in ("test.json", "validation.csv"):
        (path / name).unlink()
    found = RunStore(tmp_path).find(untested.run(0))
    assert found
    measured = {name for name, value in found.metrics.items() if value is not None}
    assert measured == {"success_training", "steps_per_second", "memory_mb"}


def test_what_the_switch_prefers_is_counted_in_the_last_tenth_whichever_drove(tmp_path: Path) -> None:
    last = [1.0] * 30 + [-1.0] * 60 + [0.0] * 10
    assert metrics(tmp_path / "a", prefers=[1.0] * 900 + last)["switch_prefers"] == 0.3
    assert metrics(tmp_path / "b", prefers=[1.0] * 900)["switch_prefers"] is None
    assert metrics(tmp_path / "c", DDPG, prefers=[float("nan")] * 1000)["switch_prefers"] is None


@pytest.mark.parametrize(
    "damage", ["test.json={}", "test.json={", "metrics.csv=a\n1\n", "steps.npz=", "steps.npz=PK\3\4"]
)
def test_a_damaged_file_is_one_sentence(damage: str, tmp_path: Path) -> None:
    file, _, text = damage.partition("=")
    (finish(tmp_path, GROUP.run(0)) / file).write_text(text)
    with pytest.raises(UserError, match=r"_seed0_\w+ lacks a metric; remove it to train it again"):
        RunStore(tmp_path).find(GROUP.run(0))


def _table(group: Group, folder: Path) -> list[str]:
    return runs_table({"": group}, RunStore(folder).results({"": group})).splitlines()


def test_a_row_a_run_and_the_means_with_their_intervals(tmp_path: Path) -> None:
    finish_group(tmp_path, GROUP, [0.7, 0.8])
    assert "mean of 2** (of 3, unfinished)" in _table(GROUP, tmp_path)[-1]
    finish(tmp_path, GROUP.run(2), success=0.9)
    finish_group(tmp_path, DDPG, [0.0])
    groups = {"empty": GROUP, "ddpg": DDPG, "none": Group("none", ("task=nav_empty",), 7000, (0,))}
    lines = runs_table(groups, RunStore(tmp_path).results(groups)).splitlines()
    assert [line.split(" | ")[0] for line in lines[2:]] == [
        "| nav_empty, seed 0", "| nav_empty, seed 1", "| nav_empty, seed 2", "| **mean of 3**",
        "| DDPG, seed 0", "| **mean of 1**",
    ]  # fmt: skip
    # t(0.975, 2) = 4.303; σ = 0.1.
    assert "| 0.800 [0.552, 1.000] |" in lines[5]
    assert lines[6].count("–") == 6


def test_runs_of_another_scene_than_todays_are_named(tmp_path: Path) -> None:
    config = train_config(["task=nav_empty", "task.laser.num_beams=24"])
    assert current_scene("nav_empty", BeamRing(24)) == environment_hash(make_environment(config.task, config.reward))
    groups, store, today = {"empty": GROUP}, RunStore(tmp_path), current_scene("nav_empty", BeamRing())
    assert not describe_provenance(groups, store.results(groups))
    finish_group(tmp_path, GROUP, [0.7, 0.8], model_hash=today)
    made = f"Trained with asddpg 0.0.9; scene nav_empty with 40 beams {today}."
    assert describe_provenance(groups, store.results(groups)) == made
    finish(tmp_path, GROUP.run(2), model_hash="fedc")
    warning = f"Not all runs are of today's scene: nav_empty with 40 beams is {today} now."
    assert warning in describe_provenance(groups, store.results(groups))


def test_a_cell_of_a_table() -> None:
    """A share's interval ends at 0 and 1, another's does not; a bar in a cell does not end it."""
    assert METRICS["success_last"].cell(Estimate(0.9, 0.7, 1.1)) == "0.900 [0.700, 1.000]"
    assert METRICS["swing"].cell(Estimate(0.9, -0.7, 1.1)) == "0.900 [-0.700, 1.100]"
    assert METRICS["swing"].cell(Estimate(None, None, None)) == "–"
    assert markdown(["a"], [["b|c"]]).splitlines()[-1] == "| b/c |"
