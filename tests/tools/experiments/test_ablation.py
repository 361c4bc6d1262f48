"""The ablation's grid, its table, and a tiny one from the first word to the last."""

import csv
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from asddpg.errors import UserError
from tests.support.fake_runs import finish, finish_group
from tools import ablation
from tools.experiments.ablation_table import Row
from tools.experiments.factors import FACTORS, Factor
from tools.experiments.run_csv import write_csv
from tools.experiments.run_groups import Run, finished, settings_of
from tools.experiments.run_metrics import read_run_metrics
from tools.experiments.run_store import differences, stored_runs
from tools.experiments.run_tables import Result

TINY = ["steps=300", "seeds=100", "task=nav_empty", "network=fc2x100", "agent.learning_starts=100", "test_episodes=2"]
TINY += ["validation.episodes=1", "task.time_limit_steps=40"]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", FACTORS)
def test_each_factor_changes_the_default_and_switching_it_back_gives_the_default_again(name: str) -> None:
    """So `on` and `off` speak of the same options."""
    factor = FACTORS[name]
    reference = settings_of(["agent=asddpg", *factor.beside])
    on, off = (settings_of(["agent=asddpg", *factor.beside, *arguments]) for arguments in (factor.on, factor.off))
    assert on != off
    assert reference in (on, off) or name in ("withdrawal", "alone_throughout", "alone_stretches")
    assert factor.title
    assert factor.source


def test_a_factor_the_default_has_is_taken_away_and_one_it_lacks_is_added() -> None:
    grid = ablation.rows(ablation.request(["imitation", "n_steps"]))
    default = settings_of(["agent=asddpg"])["agent"]
    expected = ["default", "default_without_imitation" if default["imitation"] else "default_with_imitation"]
    expected += ["default_without_n_steps" if default["n_steps"] > 1 else "default_with_n_steps"]
    assert list(grid) == [*expected, "paper", "paper_with_imitation", "paper_with_n_steps"]
    assert grid["paper_with_imitation"].group.options[-2:] == ("agent=asddpg_paper", "agent.imitation=1")
    assert grid["paper_with_imitation"].reference == "paper"


def test_where_the_default_has_a_factor_at_another_strength_both_are_run(monkeypatch: pytest.MonkeyPatch) -> None:
    strength = Factor("γ", "–", off=("agent.gamma=0",), on=("agent.gamma=0.5",))
    monkeypatch.setattr(ablation, "FACTORS", {"gamma": strength})
    grid = ablation.rows(ablation.request([]))
    assert list(grid) == ["default", "default_without_gamma", "default_with_gamma", "paper", "paper_with_gamma"]


def test_what_a_factor_needs_beside_it_its_reference_has_too() -> None:
    grid = ablation.rows(ablation.request(["critic_follows_switch", "twin_critics"]))
    assert grid["default_with_twin_critics"].reference == "default_without_critic_follows_switch"
    assert grid["paper_with_twin_critics"].reference == "paper"
    alone = ablation.rows(ablation.request(["twin_critics"]))
    assert alone["default_with_twin_critics"].reference == "default_for_twin_critics"
    assert alone["default_for_twin_critics"].reference == "default"


def test_each_row_differs_from_its_reference_by_its_own_factor() -> None:
    """And in an option that acts: what the switch is charged with does only where there is something to charge."""
    grid = ablation.rows(ablation.request([]))
    settings = [row.group.settings(0) for row in grid.values()]
    assert not [one for number, one in enumerate(settings) if one in settings[:number]]
    assert not [argument for row in grid.values() for argument in row.group.options if "$" in argument]
    for name, row in grid.items():
        if row.reference is None:
            continue
        found = differences(grid[row.reference].group.settings(0), row.group.settings(0))
        if "charge_switch_alone" in name:
            assert [text.split(" was ")[0] for text in found] == ["agent.charge_critic"]
            assert row.group.settings(0)["agent"]["controller_price"] == 0.05
        if "twin_critics" in name:
            assert [text.split(" was ")[0] for text in found] == ["agent.twin_critics", "agent.target_noise"]


def test_what_changes_nothing_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    same = Factor("γ", "–", off=("agent.gamma=0.5",), on=("agent.gamma=0.99",))
    monkeypatch.setattr(ablation, "FACTORS", {"gamma": same})
    assert list(ablation.rows(ablation.request([]))) == ["default", "default_without_gamma", "paper"]


def test_a_command_line() -> None:
    asked = ablation.request(["--list", "imitation", "seeds=7,8,7", "steps=500", "task=nav_empty", "reward=dense"])
    assert (asked.verb, list(asked.factors), asked.seeds, asked.steps) == ("list", ["imitation"], (7, 8), 500)
    assert asked.arguments == ("task=nav_empty", "reward=dense")
    plain = ablation.request([])
    assert (plain.verb, plain.seeds, plain.steps, plain.arguments) == (
        "",
        (100, 101, 102),
        60_000,
        ("task=nav_complex",),
    )
    assert plain.factors == FACTORS


def test_the_papers_side_may_have_fewer_seeds() -> None:
    grid = ablation.rows(ablation.request(["imitation", "paper_seeds=100"]))
    assert {name: row.group.seeds for name, row in grid.items()} == {
        "default": (100, 101, 102),
        "default_without_imitation": (100, 101, 102),
        "paper": (100,),
        "paper_with_imitation": (100,),
    }
    assert ablation.request(["seeds=7,8"]).paper_seeds == (7, 8)


def test_every_rows_words_in_the_table_train_it_again_from_a_shell(tmp_path: Path) -> None:
    grid = ablation.rows(ablation.request(["withdrawal", "seeds=100", "steps=1000", "controller.gains=[2, 1]"]))
    groups = {name: row.group for name, row in grid.items()}
    results = {}
    for name, group in groups.items():
        finish_group(tmp_path, name, group, [0.5])
    for name, runs in finished(groups, stored_runs(tmp_path)).items():
        results[name] = [Result(run, read_run_metrics(run)) for run in runs]
    write_csv(tmp_path / "table.csv", groups, results)
    with (tmp_path / "table.csv").open() as file:
        written = {row["group"]: row["arguments"] for row in csv.DictReader(file)}
    assert list(written) == list(grid)
    for name, arguments in written.items():
        assert settings_of(shlex.split(arguments)) == groups[name].settings(100)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["imitaton"], "there is no factor 'imitaton'; there are .*imitation"),
        (["seeds=a"], "seeds must be whole numbers"),
        (["seeds="], "seeds must be whole numbers"),
        (["paper_seeds=a"], "paper_seeds must be whole numbers"),
        (["steps=-5"], "steps must be whole numbers"),
        (["steps=1,2"], "steps must be one whole number"),
        (["rule_out=2"], "rule_out must be a share"),
        (["rule_out=-0.1"], "rule_out must be a share"),
        (["steps=0"], "total_steps must be greater than 0"),
        (["agent=ddpg"], "the grid sets itself"),
        (["run_dir=x"], "the grid sets itself"),
        (["task=nav_foo"], "there is no task"),
        (["agent.imitaton=1"], "did you mean agent.imitation"),
        (["list", "table"], "not both"),
        (["seeds=5", "seeds=6"], "seeds is given twice, as 5 and 6"),
    ],
)
def test_wrong_words_are_one_sentence_and_create_nothing(arguments: list[str], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=sentence) as caught:
        ablation.main(arguments)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_the_table_is_sorted_by_the_effect_paired_by_seed(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["imitation", "n_steps", "twin_critics", "seeds=100,101", "steps=1000"]
    grid = ablation.rows(ablation.request(arguments))
    reaches = {"paper": [0.5, 0.7], "paper_with_imitation": [0.4, 0.5], "paper_with_n_steps": [0.6, 0.8]}
    for name, values in reaches.items():
        finish_group(ablation.FOLDER, name, grid[name].group, values)
    finish_group(ablation.FOLDER, "paper_with_twin_critics", grid["paper_with_twin_critics"].group, [0.52])
    ablation.main(["table", *arguments])
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| paper")]
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    assert [cell[:4] for cell in cells] == [
        ["paper", "100, 101", "0.500, 0.700", "–"],
        ["paper with n_steps", "100, 101", "0.600, 0.800", "+0.100 [+0.100, +0.100]"],
        ["paper with twin_critics (of 2, unfinished)", "100", "0.520", "+0.020"],
        # −0.1 and −0.2: t(0.975, 1) = 12.706 times 0.05.
        ["paper with imitation", "100, 101", "0.400, 0.500", "-0.150 [-0.785, +0.485]"],
    ]
    text = (ablation.FOLDER / "table.md").read_text()
    assert lines[1] in text
    assert "11 runs are missing." in text
    with (ablation.FOLDER / "table.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 7


def _finish(grid: Mapping[str, Row], reaches: Mapping[str, list[float]]) -> None:
    for name, values in reaches.items():
        finish_group(ablation.FOLDER, name, grid[name].group, values)


def test_what_falls_short_on_the_first_seed_is_trained_on_no_other(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["imitation", "n_steps", "annealing", "twin_critics", "seeds=100,101", "steps=1000"]
    reaches = {
        "default": [0.9],
        "default_without_imitation": [0.5],
        "default_without_n_steps": [0.85],
        "default_for_twin_critics": [0.3],
        "default_with_twin_critics": [0.4],
        "paper": [0.04],
        "paper_with_imitation": [0.2],
        "paper_with_n_steps": [0.08],
    }
    _finish(ablation.rows(ablation.request(arguments)), reaches)
    ablation.main(["list", *arguments])
    asked = [line.split(";")[0] for line in capsys.readouterr().out.splitlines() if "seeds 100, 101;" in line]
    assert sorted(asked) == [
        "default: default",
        "default_for_twin_critics: default for twin_critics",  # what it gives is needed by the row below it
        "default_with_twin_critics: default with twin_critics",
        "default_without_annealing: default without annealing",
        "default_without_n_steps: default without n_steps",
        "paper: paper",
        "paper_with_annealing: paper with annealing",
        "paper_with_imitation: paper with imitation",
        "paper_with_twin_critics: paper with twin_critics",
    ]
    ablation.main(["list", *arguments, "rule_out=none"])
    assert "default_without_imitation: default without imitation; seeds 100, 101" in capsys.readouterr().out
    ablation.main(["table", *arguments])
    assert "| default without imitation (ruled out) | 100 | 0.500 | -0.400 |" in capsys.readouterr().out


def test_runs_of_what_is_ruled_out_stay_in_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["imitation", "seeds=100,101,102", "steps=1000"]
    grid = ablation.rows(ablation.request(arguments))
    _finish(grid, {"default": [0.9], "default_without_imitation": [0.5, 0.9]})
    ablation.main(["table", *arguments])
    assert "| default without imitation (ruled out) | 100, 101 | 0.500, 0.900 |" in capsys.readouterr().out


def test_the_first_seed_of_every_setting_is_trained_before_any_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ablation, "FACTORS", {})
    trained: list[list[str]] = []

    def train(runs: Sequence[Run], _folder: Path) -> list[Run]:
        trained.append([run.name for run in runs])
        return []

    monkeypatch.setattr("tools.experiments.run_grid.train", train)
    ablation.main(["seeds=100,101", "steps=1000"])
    assert trained[0] == ["default_seed100", "paper_seed100"]


def test_a_first_run_that_fails_keeps_no_other_setting_from_its_seeds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ablation, "FACTORS", {})
    trained: list[list[str]] = []

    def train(runs: Sequence[Run], folder: Path) -> list[Run]:
        trained.append([run.name for run in runs])
        for run in runs[1:]:
            finish(folder / run.name, run.settings)
        return list(runs[:1])

    monkeypatch.setattr("tools.experiments.run_grid.train", train)
    with pytest.raises(SystemExit, match=r"1 of 3 runs failed; .*default_seed100\.log"):
        ablation.main(["seeds=100,101", "steps=1000"])
    assert trained == [["default_seed100", "paper_seed100"], ["default_seed100", "default_seed101", "paper_seed101"]]


def test_an_effect_against_another_row_than_the_first_names_it(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["critic_follows_switch", "twin_critics", "seeds=100", "steps=1000"]
    grid = ablation.rows(ablation.request(arguments))
    reaches = {"default": 0.9, "default_without_critic_follows_switch": 0.5, "default_with_twin_critics": 0.6}
    for name, value in reaches.items():
        finish_group(ablation.FOLDER, name, grid[name].group, [value])
    ablation.main(["table", *arguments])
    row = "| default with twin_critics, against default without critic_follows_switch | 100 | 0.600 | +0.100 |"
    assert row in capsys.readouterr().out


def test_the_list_tells_what_would_be_trained_and_how_long_it_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ablation.main(["list", "imitation", "steps=60000"])
    printed = capsys.readouterr().out
    assert "total_steps=60000 validation.every=3000 task=nav_complex agent=asddpg_paper agent.imitation=1\n" in printed
    assert "12 runs of 720000 steps in all to train: about 1.1 h, 2 at once at 90 steps/s each, a guess" in printed
    assert not list(tmp_path.iterdir())
    grid = ablation.rows(ablation.request(["imitation"]))
    finish_group(ablation.FOLDER, "paper", grid["paper"].group, [0.5])
    ablation.main(["list", "imitation"])
    assert "11 runs of 660000 steps in all to train: about 0.9 h, 2 at once at 100 steps/s" in capsys.readouterr().out


def test_an_empty_table_is_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    ablation.main(["table", "imitation"])
    assert "12 runs are missing." in capsys.readouterr().out


@pytest.mark.slow
def test_a_tiny_ablation_trains_once_and_then_no_more(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(ablation, "FACTORS", {})
    ablation.main(TINY)
    printed = capsys.readouterr().out
    assert "paper_seed100 trained" in printed
    assert "missing" not in printed
    times = {path: path.stat().st_mtime_ns for path in ablation.FOLDER.glob("*/resources.json")}
    assert len(times) == 2
    ablation.main(TINY)
    assert "0 runs to train" in capsys.readouterr().out
    assert {path: path.stat().st_mtime_ns for path in ablation.FOLDER.glob("*/resources.json")} == times


def test_a_run_that_fails_is_named_and_the_status_is_1(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ablation, "FACTORS", {})
    monkeypatch.setattr("tools.experiments.run_training.command", lambda *_: ["false"])
    with pytest.raises(SystemExit, match=r"2 of 2 runs failed; .*default_seed100\.log, .*paper_seed100\.log"):
        ablation.main(TINY)
    assert (ablation.FOLDER / "table.md").exists()
