"""The declarations of options: what --help and the reference say of them, and the one parser that reads them."""

import re
import runpy
import subprocess
import sys
import warnings
from dataclasses import MISSING, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from asddpg.command_line import GROUPS, OWN_ROOM, driver_config, train_config
from asddpg.config import EvaluateConfig, MissionConfig, PlayConfig, TrainConfig
from asddpg.errors import UserError
from asddpg.options.help_text import help_text
from asddpg.options.parsing import label, parse_arguments, with_values
from asddpg.options.values import read_value, write_value
from tasks import ALL_TASKS, LaserConfig, NavigationConfig, Reward
from tasks.errors import TaskError
from tasks.options import POSITIVE, argument, option, options_of
from tests.conftest import ROOT
from tools.options_reference import PROGRAMS, declaration, options_reference

READERS: dict[type, Any] = {
    TrainConfig: train_config,
    EvaluateConfig: partial(driver_config, EvaluateConfig),
    PlayConfig: partial(driver_config, PlayConfig),
    MissionConfig: partial(driver_config, MissionConfig),
}


def help_of(program: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> str:
    """What a user sees."""
    monkeypatch.setattr(sys, "argv", [program, "--help"])
    monkeypatch.setattr("asddpg.program._end_on_signals", lambda: None)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of a module that is run after it was imported
        runpy.run_module(program, run_name="__main__")
    return capsys.readouterr().out


@pytest.mark.parametrize("program", PROGRAMS)
def test_help_lists_every_option_and_each_is_accepted_with_its_default(
    program: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    doc, kind = declaration(program)
    text = help_of(program, monkeypatch, capsys)
    assert text.startswith(doc.strip().splitlines()[0])
    listed = dict(re.findall(r"^  ([\w.]+)=(\S*)", text, re.MULTILINE))
    declared = list(options_of(kind))
    assert set(listed) == {each.name for each in declared if each.is_named}
    needed = [
        each.name.lower() if not each.is_named else f"{each.name}=given" for each in declared if each.value is MISSING
    ]
    needed = [{"scene": "nav_empty", "room": "cylinders:0"}.get(each, each) for each in needed]
    for each in declared:
        assert each.meaning in " ".join(text.split())
        if each.is_named and each.value is not MISSING:
            word = f"{each.name}={listed[each.name]}"
            read: Any = READERS[kind]([word]) if kind in READERS else parse_arguments(kind, [*needed, word])
            assert {found.name: found.value for found in options_of(read)}[each.name] == each.value, word


def test_every_program_stands_in_the_reference() -> None:
    paths = (path.relative_to(ROOT) for package in ("asddpg", "tools") for path in (ROOT / package).rglob("*.py"))
    programs = {".".join(path.with_suffix("").parts) for path in paths if "__main__" in (ROOT / path).read_text()}
    assert programs - {"asddpg.__main__"} == set(PROGRAMS)  # which runs the others, and has no options
    reference = options_reference()
    for program in PROGRAMS:
        assert f"## `{program}`" in reference
        for each in options_of(declaration(program)[1]):
            assert f"| `{label(each) if not each.is_named else each.name}` |" in reference


def test_the_choices_of_groups_are_those_that_exist(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert tuple(GROUPS["task"]) == ALL_TASKS
    for group in ("task", "agent", "network"):
        found = {path.stem for path in (ROOT / "asddpg/conf" / group).glob("*.yaml")}
        assert set(GROUPS[group]) == found - {OWN_ROOM}
    text = help_of("asddpg.train", monkeypatch, capsys)
    for presets in GROUPS.values():
        for preset, sentence in presets.items():
            assert re.search(rf"^  {preset} +{re.escape(sentence)}$", text, re.MULTILINE)


def test_the_defaults_are_those_of_the_presets() -> None:
    """But for the least speed, which the preset of the default's room sets."""
    assert train_config(["task.min_linear_velocity=0"]) == TrainConfig()


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("task.laser.num_beams", 2001),
        ("task.laser.dropout", 1.5),
        ("task.max_linear_velocity", 1.21),
        ("task.max_angular_velocity", 5.24),
        ("task.control_timestep", 0.013),
        ("reward.crash", 1.0),
    ],
)
def test_a_range_is_the_same_for_a_program_and_for_a_command_line(name: str, value: float) -> None:
    kind = {"laser": LaserConfig, "reward": Reward}.get(name.split(".")[-2], NavigationConfig)
    with pytest.raises(TaskError) as raised:
        kind(**{name.rpartition(".")[2]: value})
    with pytest.raises(UserError) as refused:
        train_config([f"{name}={value}"])
    assert str(refused.value).endswith(str(raised.value))


def test_the_robots_limits_are_taken_by_both() -> None:
    config = train_config(["task.max_linear_velocity=1.195", "task.max_angular_velocity=5.235"])
    own = NavigationConfig(max_linear_velocity=1.195, max_angular_velocity=5.235)
    assert config.task.max_linear_velocity == own.max_linear_velocity
    assert train_config(["task.laser.num_beams=2", "network.convolutions=none"]).task.laser.num_beams == 2
    with pytest.raises(UserError, match="12 or more for the convolutions, not 11"):
        train_config(["task.laser.num_beams=11"])


def test_the_agent_is_imported_without_mujoco() -> None:
    code = "import asddpg.algorithm.agent, sys; print({'mujoco', 'tasks'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"


@dataclass(frozen=True)
class ToolArguments:
    """What the tool does."""

    files: list[Path] = argument("Files, such as a.mcap.")
    name: str = option(MISSING, "A name.")
    count: int | None = option(None, "How many.", POSITIVE)
    sizes: list[float] = option([0.5, 1.0], "Of each.")
    flat: bool = option(False, "Whether it is flat.", name="shape.flat")


def test_arguments_are_read_by_place_and_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("b=c").touch()
    parsed = parse_arguments(
        ToolArguments, ["~/a", "name=x=y", "b=c", "sizes=[1, 2e-3]", "shape.flat=Yes", "count=1_000"]
    )
    assert parsed == ToolArguments([Path.home() / "a", Path("b=c")], "x=y", 1000, [1.0, 0.002], flat=True)
    assert parse_arguments(ToolArguments, ["a", "name=1", "sizes=[]", "count=null"]).sizes == []


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["name=x"], "FILES… is missing: files, such as a.mcap"),
        (["a"], "name= is missing: a name"),
        (["a", "nmae=x"], "there is no option 'nmae'; did you mean name?"),
        (["a", "colour=x"], "there is no option 'colour'; there are name, count, sizes, shape.flat"),
        (["a", "name=x", "name=y"], "name is given twice, as 'x' and 'y'"),
        (["a", "count=0"], "count must be greater than 0, not 0"),
        (["a", "count=1.5"], "count must be a whole number or null, not '1.5'"),
        (["a", "sizes=[1"], "sizes must be a list of numbers, such as [1,2.5], not '[1'"),
        (["a", "name="], "name= gives name no value; write one, or leave name out"),
    ],
)
def test_an_invalid_argument_is_one_sentence(arguments: list[str], sentence: str) -> None:
    with pytest.raises(UserError, match=re.escape(sentence)):
        parse_arguments(ToolArguments, arguments)


def test_values_are_written_as_they_are_read() -> None:
    for each in (*options_of(TrainConfig), *options_of(ToolArguments)):
        if each.value is not MISSING and each.is_named:
            assert read_value(each, write_value(each.value)) == each.value
    changed = with_values(TrainConfig(), {"task.laser.noise": 1.0})
    assert (changed.task.laser.noise, TrainConfig().task.laser.noise) == (1.0, 0.0)
    assert "FILES…" in help_text("Tool.", ToolArguments)
