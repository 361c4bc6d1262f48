"""The ablation's grid, its table, and a tiny one from its arguments to its table."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from asddpg.errors import UserError
from tests.support.fake_runs import finish, finish_group
from tools import ablation
from tools.experiments.factors import FACTORS, Factor
from tools.experiments.one_robot import one_robot
from tools.experiments.runs import Group, Run

TINY = ["steps=300", "seeds=100", "task=nav_empty", "network=fc2x100", "agent.learning_starts=100", "test_episodes=2"]
TINY += ["validation.episodes=1", "task.time_limit_steps=40"]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def finish_groups(grid: Mapping[str, Group], successes: Mapping[str, list[float]]) -> None:
    for name, values in successes.items():
        finish_group(ablation.FOLDER, grid[name], values)


def grid_of(*arguments: str) -> dict[str, Group]:
    return ablation.make_grid(*ablation.parse(arguments))


@pytest.mark.parametrize("name", FACTORS)
def test_each_factor_changes_the_default_and_switching_it_back_gives_the_default_again(name: str) -> None:
    """So `on` and `off` speak of the same options."""
    factor = FACTORS[name]
    reference, on, off = (
        Group("", one_robot(("agent=asddpg", *factor.beside.split(), *change.split())), 1000, (0,)).digest
        for change in ("", factor.on, factor.off)
    )
    assert on != off
    assert reference in (on, off) or name in ("withdrawal", "alone_throughout", "alone_stretches")
    assert factor.title
    assert factor.source


def test_a_factor_the_default_has_is_taken_away_and_one_it_lacks_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    """At another strength both are done."""
    grid = grid_of("imitation", "layer_norm")
    expected = ["default", "default_without_imitation", "default_with_layer_norm"]
    assert list(grid) == [*expected, "paper", "paper_with_imitation", "paper_with_layer_norm"]
    assert grid["paper_with_imitation"].options[-2:] == ("agent=asddpg_paper", "agent.imitation=1")
    assert grid["paper_with_imitation"].reference == "paper"
    monkeypatch.setattr(ablation, "FACTORS", {"gamma": Factor("γ", "–", off="agent.gamma=0", on="agent.gamma=0.5")})
    assert list(grid_of()) == ["default", "default_without_gamma", "default_with_gamma", "paper", "paper_with_gamma"]


def test_what_a_factor_needs_beside_it_its_reference_has_too() -> None:
    grid = grid_of("critic_follows_switch", "twin_critics")
    assert grid["default_with_twin_critics"].reference == "default_without_critic_follows_switch"
    assert grid["paper_with_twin_critics"].reference == "paper"
    alone = grid_of("twin_critics")
    assert alone["default_with_twin_critics"].reference == "default_for_twin_critics"
    assert alone["default_for_twin_critics"].reference == "default"
    everything = grid_of()
    assert len({group.digest for group in everything.values()}) == len(everything)


def test_all_groups_have_one_robot_unless_the_arguments_name_another_number() -> None:
    assert {group.config.robots for group in grid_of().values()} == {1}
    many = grid_of("imitation", "robots=16")
    assert {group.config.robots for group in many.values()} == {16}
    assert many["default"].arguments == ("task=nav_complex", "robots=16", "agent=asddpg")


def test_a_command_line() -> None:
    parsed, others = ablation.parse(["list", "imitation", "seeds=7,8", "steps=500", "task=nav_empty", "reward=dense"])
    assert (parsed.factors, parsed.seeds, parsed.steps) == (["list", "imitation"], [7, 8], 500)
    assert others == ("task=nav_empty", "reward=dense")
    assert ablation.parse([]) == (ablation.AblationArguments(), ("task=nav_complex",))
    seeds = {name: group.seeds for name, group in grid_of("imitation", "paper_seeds=100").items()}
    assert seeds["default_without_imitation"] == (100, 101, 102)
    assert seeds["paper"] == seeds["paper_with_imitation"] == (100,)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["imitaton"], "there is no factor 'imitaton'; there are .*imitation"),
        (["seeds=5,5"], "seeds must be one or more seeds, different and 0 or more"),
        (["seeds=-1"], "seeds must be one or more seeds"),
        (["steps=0"], "steps must be greater than 0"),
        (["agent=ddpg"], "the grid sets agent itself"),
        (["run_dir=x"], "the grid sets run_dir itself"),
        (["task=nav_foo"], "there is no task"),
        (["agent.imitaton=1"], "did you mean agent.imitation"),
        (["list", "table"], "not both"),
    ],
)
def test_invalid_arguments_are_one_sentence_and_create_nothing(
    arguments: list[str], sentence: str, tmp_path: Path
) -> None:
    with pytest.raises(UserError, match=sentence) as caught:
        ablation.main(arguments)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_the_table_is_sorted_by_the_effect_paired_by_seed(capsys: pytest.CaptureFixture[str]) -> None:
    """And an effect against another group than the first names it."""
    arguments = ["imitation", "n_steps", "twin_critics", "seeds=100,101", "steps=1000"]
    successes = {"paper": [0.5, 0.7], "paper_with_imitation": [0.4, 0.5], "paper_with_n_steps": [0.6, 0.8]}
    successes |= {"paper_with_twin_critics": [0.52]}
    successes |= {"default": [0.9, 0.9], "default_for_twin_critics": [0.85], "default_with_twin_critics": [0.95]}
    finish_groups(grid_of(*arguments), successes)
    ablation.main(["table", *arguments])
    printed = capsys.readouterr().out
    assert "| default with twin_critics, against default for twin_critics (of 2, unfinished) | 100 | 0.950 |" in printed
    lines = [line for line in printed.splitlines() if line.startswith("| paper")]
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
    assert "7 runs are missing." in text
    assert len((ablation.FOLDER / "table.csv").read_text().splitlines()) == 12


def test_what_falls_short_on_the_first_seed_is_trained_on_no_other(capsys: pytest.CaptureFixture[str]) -> None:
    """Its runs stay in the table."""
    arguments = ["imitation", "n_steps", "annealing", "twin_critics", "seeds=100,101,102", "steps=1000"]
    successes = {
        "default": [0.9],
        "default_without_imitation": [0.5, 0.9],
        "default_without_n_steps": [0.85],
        "default_for_twin_critics": [0.3],
        "default_with_twin_critics": [0.4],
        "paper": [0.04],
        "paper_with_imitation": [0.2],
        "paper_with_n_steps": [0.08],
    }
    finish_groups(grid_of(*arguments), successes)
    ablation.main(["list", *arguments])
    listed = capsys.readouterr().out.splitlines()
    ruled_out = [line.split(":")[0] for line in listed if "seeds" in line and "seeds 100, 101, 102;" not in line]
    # The group below default_for_twin_critics is measured against it, so it stays.
    assert ruled_out == ["default_without_imitation", "paper_with_n_steps"]
    ablation.main(["list", *arguments, "rule_out=null"])
    assert "default_without_imitation: default without imitation; seeds 100, 101, 102" in capsys.readouterr().out
    ablation.main(["table", *arguments])
    assert "| default without imitation (ruled out) | 100, 101 | 0.500, 0.900 | -0.400 |" in capsys.readouterr().out


def test_the_first_seed_goes_first_and_one_that_fails_keeps_no_other_seed_from_being_trained(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(ablation, "FACTORS", {})
    trained: list[list[str]] = []

    def train(runs: Sequence[Run], folder: Path) -> list[Run]:
        trained.append([run.title for run in runs])
        for run in runs[1:]:
            finish(folder, run)
        return list(runs[:1])

    monkeypatch.setattr(ablation, "train", train)
    monkeypatch.setattr("tools.experiments.grid.train", train)
    with pytest.raises(SystemExit, match=r"1 of 3 runs failed; .*nav_complex_asddpg_seed100_\w+\.log"):
        ablation.main(["seeds=100,101", "steps=1000"])
    assert (ablation.FOLDER / "table.md").exists()
    assert trained[0] == ["default, seed 100", "paper, seed 100"]
    assert trained[1:] == [["default, seed 100", "default, seed 101", "paper, seed 101"]]


def test_the_list_says_what_would_be_trained_and_how_long_it_takes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ablation.main(["list", "imitation", "steps=60000"])
    printed = capsys.readouterr().out
    assert "total_steps=60000 validation.every=3000 task=nav_complex agent=asddpg_paper agent.imitation=1\n" in printed
    assert "12 runs of 720000 steps in all to train: about 1.1 h, 2 at once, a guess" in printed
    assert not list(tmp_path.iterdir())
    finish_groups(grid_of("imitation"), {"paper": [0.5]})
    ablation.main(["list", "imitation"])
    printed = capsys.readouterr().out
    assert "11 runs of 660000 steps in all to train: about 0.9 h, 2 at once, at 100 steps/s each as measured" in printed


@pytest.mark.slow
def test_a_tiny_ablation_trains_once_and_then_no_more(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(ablation, "FACTORS", {})
    ablation.main(TINY)
    printed = capsys.readouterr().out
    assert "paper, seed 100 trained (" in printed
    assert "missing" not in printed
    times = {path: path.stat().st_mtime_ns for path in ablation.FOLDER.glob("*/resources.json")}
    assert len(times) == 2
    ablation.main(TINY)
    assert "0 runs to train" in capsys.readouterr().out
    assert {path: path.stat().st_mtime_ns for path in ablation.FOLDER.glob("*/resources.json")} == times
