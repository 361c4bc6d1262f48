"""Figures of finished runs, and the tables made of them."""

from pathlib import Path

import pytest

from asddpg.build import make_environment
from asddpg.command_line import train_config
from asddpg.episodes.intervals import Estimate
from asddpg.errors import UserError
from asddpg.runs.provenance import environment_hash
from tests.support.fake_runs import finish, finish_group
from tools.experiments.current_scenes import scene_today
from tools.experiments.markdown import markdown
from tools.experiments.run_groups import Group, finished
from tools.experiments.run_metrics import RunMetrics, read_run_metrics
from tools.experiments.run_provenance import provenance
from tools.experiments.run_store import stored_runs
from tools.experiments.run_tables import COLUMNS, Result, Results, runs_table

GROUP = Group("nav_empty", ("task=nav_empty",), 1000, (0, 1, 2))
DDPG = Group("DDPG", ("task=nav_empty", "agent=ddpg"), 1000, (0,))


def read(path: Path) -> RunMetrics:
    (run,) = stored_runs(path.parent)
    return read_run_metrics(run)


def results(groups: dict[str, Group], folder: Path) -> Results:
    found = finished(groups, stored_runs(folder))
    return {name: [Result(run, read_run_metrics(run)) for run in runs] for name, runs in found.items()}


def test_figures_of_a_run(tmp_path: Path) -> None:
    shares = [0.1] * 25 + [0.2] * 25 + [0.3] * 25 + [0.4] * 15 + [0.9] * 10
    validations = [1, 0.1, 0.9, 0.8, 0.2, 0.3, 0.4, 0.5]
    path = finish(
        tmp_path / "run",
        GROUP.settings(0),
        reach=0.7,
        outcomes=("reached", "reached", "reached", "crashed"),
        shares=shares,
        validations=validations,
    )
    found = read(path)
    assert found.success_training == 0.75
    assert (found.success_last, found.collision_last, found.success_best) == pytest.approx((0.7, 0.3, 0.8))
    assert (found.share_1, found.share_2, found.share_3) == pytest.approx((0.1, 0.2, 0.3))
    assert found.share_4 == pytest.approx((15 * 0.4 + 10 * 0.9) / 25)
    assert found.share_end == pytest.approx(0.9)
    assert found.last_five == pytest.approx((0.8 + 0.2 + 0.3 + 0.4 + 0.5) / 5)
    assert found.best_five == pytest.approx((1 + 0.9 + 0.8 + 0.5 + 0.4) / 5)
    assert found.swing == pytest.approx(0.28)
    assert (found.steps_per_second, found.memory_mb) == (100, 500)


def test_only_the_last_200_episodes_count_and_none_that_was_cut(tmp_path: Path) -> None:
    path = finish(tmp_path / "run", GROUP.settings(0))
    rows = ["1,reached,1,0"] * 50 + ["1,crashed,1,0"] * 150 + ["1,reached,1,0"] * 50 + ["1,cut,1,0"]
    (path / "metrics.csv").write_text("\n".join(["step,outcome,steps,controller_share", *rows]))
    assert read(path).success_training == 0.25


def test_where_there_is_nothing_to_measure(tmp_path: Path) -> None:
    path = finish(tmp_path / "run", DDPG.settings(0) | {"test_episodes": 0})
    (path / "test.json").unlink()
    (path / "validation.csv").unlink()
    found = read(path)
    assert (found.share_1, found.share_end, found.success_last, found.swing) == (None, None, None, None)


def test_what_the_switch_prefers_is_counted_in_the_last_tenth_whoever_drove(tmp_path: Path) -> None:
    last = [1.0] * 30 + [-1.0] * 60 + [0.0] * 10
    nan = float("nan")
    assert read(finish(tmp_path / "a/run", GROUP.settings(0), prefers=[1.0] * 900 + last)).switch_prefers == 0.3
    assert read(finish(tmp_path / "b/run", GROUP.settings(0), prefers=[1.0] * 900)).switch_prefers is None
    assert read(finish(tmp_path / "c/run", DDPG.settings(0), prefers=[nan] * 1000)).switch_prefers is None
    assert read(finish(tmp_path / "d/run", GROUP.settings(0))).switch_prefers is None


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("test.json", "{}"),
        ("test.json", "{"),
        ("metrics.csv", "a\n1\n"),
        ("steps.npz", ""),
        ("steps.npz", "PK\x03\x04"),
    ],
)
def test_a_damaged_file_is_one_sentence(file: str, text: str, tmp_path: Path) -> None:
    path = finish(tmp_path / "run", GROUP.settings(0))
    (path / file).write_text(text)
    with pytest.raises(UserError, match="remove it to train it again"):
        read(path)


def test_a_row_a_run_and_the_means_with_their_intervals(tmp_path: Path) -> None:
    groups = {"empty": GROUP, "ddpg": DDPG, "none": Group("none", ("task=nav_empty",), 7000, (0,))}
    finish_group(tmp_path, "empty", GROUP, [0.7, 0.8, 0.9])
    finish_group(tmp_path, "ddpg", DDPG, [0.0])
    lines = runs_table(groups, results(groups, tmp_path)).splitlines()
    assert [line.split(" | ")[0] for line in lines[2:]] == [
        "| nav_empty, seed 0", "| nav_empty, seed 1", "| nav_empty, seed 2", "| **mean of 3**",
        "| DDPG, seed 0", "| **mean of 1**",
    ]  # fmt: skip
    # t(0.975, 2) = 4.303; σ = 0.1.
    assert "| 0.800 [0.552, 1.000] |" in lines[5]
    assert lines[6].count("–") == 6


def test_a_group_with_runs_missing_says_so(tmp_path: Path) -> None:
    finish_group(tmp_path, "empty", GROUP, [0.7, 0.8])
    assert "mean of 2** (of 3, unfinished)" in runs_table({"empty": GROUP}, results({"empty": GROUP}, tmp_path))


def test_intervals_of_shares_end_at_0_and_1_and_others_do_not() -> None:
    assert COLUMNS["success_last"].cell(Estimate(0.9, 0.7, 1.1)) == "0.900 [0.700, 1.000]"
    assert COLUMNS["swing"].cell(Estimate(0.9, -0.7, 1.1)) == "0.900 [-0.700, 1.100]"
    assert COLUMNS["swing"].cell(Estimate(0.9, None, None)) == "0.900"
    assert COLUMNS["swing"].cell(Estimate(None, None, None)) == "–"


def test_runs_on_different_models_of_a_scene_are_told(tmp_path: Path) -> None:
    today = scene_today("nav_empty", 40)
    finish_group(tmp_path, "empty", GROUP, [0.7, 0.8], model_hash=today)
    said = provenance(results({"empty": GROUP}, tmp_path))
    assert said == f"Trained with asddpg 0.0.9; scene nav_empty with 40 beams {today}."
    finish(tmp_path / "empty_seed2", GROUP.settings(2), model_hash="fedc")
    said = provenance(results({"empty": GROUP}, tmp_path))
    assert (
        f"{', '.join(sorted(['fedc', today]))}. Runs made with different models of a scene stand side by side" in said
    )
    assert "today" not in said


def test_runs_that_are_all_of_another_scene_than_todays_are_told(tmp_path: Path) -> None:
    finish_group(tmp_path, "empty", GROUP, [0.7, 0.8])
    said = provenance(results({"empty": GROUP}, tmp_path))
    assert f"No run is of today's scene: nav_empty with 40 beams is {scene_today('nav_empty', 40)} now" in said
    assert provenance({"empty": []}) == ""


def test_todays_scene_is_the_one_that_training_notes() -> None:
    config = train_config(["task=nav_empty", "task.laser.num_beams=24"])
    assert scene_today("nav_empty", 24) == environment_hash(make_environment(config.task, config.reward))


def test_a_bar_in_a_cell_does_not_end_it() -> None:
    assert markdown(["a"], [["b|c"]]).splitlines()[-1] == "| b/c |"
