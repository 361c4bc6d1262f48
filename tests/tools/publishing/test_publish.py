"""From a run to a pretrained policy that is evaluated by name: the same actions, whole files, sentences."""

import copy
import dataclasses
import io
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.torch import load_file, save, save_file

from asddpg import evaluate, train
from asddpg.build import make_agent, make_environment
from asddpg.command_line import train_config
from asddpg.config import TaskConfig
from asddpg.errors import UserError
from asddpg.runs import pretrained, weights_file
from asddpg.runs.loading import open_trained
from asddpg.runs.pretrained import PretrainedFolder, load_policy, open_pretrained
from asddpg.runs.run_folder import RunFolder, read_training
from tasks.registry import ROOM_TASKS
from tasks.rooms.changing_room import GENERATED
from tests.support import pretrained_checks
from tools import publish
from tools.publishing.card import _snippet, arguments_of

ARGUMENTS = ["task=nav_empty", "agent=asddpg_paper", "reward=sparse", "network=fc2x100", "controller.gains=[2,1.5]"]
ARGUMENTS += ["agent.actor_learning_rate=1e-05", "agent.annealing=0.5", "exploration.decay=0"]
SHORT = ["total_steps=300", "agent.learning_starts=100", "test_episodes=3", "validation.every=200"]
SHORT += ["validation.episodes=1", "seed=3"]


@pytest.fixture(scope="module")
def finished_run(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    folder = tmp_path_factory.mktemp("runs") / "run"
    train.main([*ARGUMENTS, *SHORT, f"run_dir={folder}"])
    return RunFolder(folder)


@pytest.fixture(autouse=True)
def shelf(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty place for pretrained policies, and an empty present folder."""
    monkeypatch.setattr(pretrained, "FOLDER", tmp_path / "models" / "pretrained")
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "models" / "pretrained"


@pytest.fixture(scope="module")
def published_once(finished_run: RunFolder, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pretrained")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pretrained, "FOLDER", folder)
        publish.main([f"run={finished_run.path}", "name=mine", "episodes=3"])
    return folder


@pytest.fixture
def published(published_once: Path, shelf: Path) -> PretrainedFolder:
    """A published policy of this test's own."""
    shutil.copytree(published_once, shelf)
    return open_pretrained("mine")


@pytest.mark.usefixtures("published")
def test_a_published_policy_does_what_the_checkpoint_does(finished_run: RunFolder) -> None:
    config, _ = read_training(finished_run.config)
    environment = make_environment(config.task, config.reward)
    trained, shipped = make_agent(config, environment), make_agent(config, environment)
    assert weights_file.load_into(finished_run.checkpoint("last"), trained.networks) == 300
    assert weights_file.load_into(open_trained("pretrained:mine").weights, shipped.networks) == 300
    policy = load_policy("mine")
    assert policy.step == 300
    for observation in np.random.default_rng(0).uniform(-1.0, 1.0, (200, 124)).astype(np.float32):
        action = policy.act(observation)
        assert action.dtype == np.float32
        np.testing.assert_array_equal(action, trained.act(observation))
        one, other = trained.decide_greedily(observation), shipped.decide_greedily(observation)
        assert (one.q_policy, one.q_controller, one.value) == (other.q_policy, other.q_controller, other.value)


def test_its_files(published: PretrainedFolder) -> None:
    pretrained_checks.check_files(published)
    pretrained_checks.check_front_matter(published)
    pretrained_checks.check_nothing_but_tensors(published)
    pretrained_checks.check_the_cards_command(published)
    assert pretrained_checks.run_the_cards_snippet(published)["policy"].config.seed == 3


def test_its_figures_are_the_runs_and_its_weights_the_same_bytes_again(
    finished_run: RunFolder, published: PretrainedFolder
) -> None:
    tested, of_the_run = json.loads(published.test.read_text()), json.loads(finished_run.test.read_text())
    assert tested["actor"] == of_the_run["last"]
    assert set(tested) >= {"switch", "controller", "model_hash", "failures"}
    assert len(tested["outcomes"]) == 3
    assert f"| {tested['actor']['success_rate']['value']:.3f} [" in published.card.read_text()
    publish.main([f"run={finished_run.path}", "name=again", "episodes=1"])
    assert open_pretrained("again").weights.read_bytes() == published.weights.read_bytes()


@pytest.mark.parametrize("arguments", [[], ["driver=switch"], ["task=nav_simple"], ["seed=1"]])
def test_evaluating_by_name(
    published: PretrainedFolder, arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    evaluate.main(["run=pretrained:mine", "episodes=2", *arguments])
    printed = capsys.readouterr().out
    assert "pretrained:mine (step 300)" in printed
    assert "note:" not in printed
    assert json.loads(Path("evaluation.json").read_text())["episodes"] == 2
    assert len(list(published.path.iterdir())) == 4


def test_another_scene_is_noted(published: PretrainedFolder, capsys: pytest.CaptureFixture[str]) -> None:
    _, provenance = read_training(published.config)
    published.config.write_text(published.config.read_text().replace(provenance["model_hash"], "0123456789abcdef"))
    evaluate.main(["run=pretrained:mine", "episodes=1"])
    assert "note: the scene's model is not the one" in capsys.readouterr().out


@pytest.mark.usefixtures("published")
@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run=pretrained:yours"], "no pretrained policy 'yours'; there are mine"),
        (["run=pretrained:../mine"], "there are mine"),
        (["run=pretrained:mine", "checkpoint=best"], "one set of weights"),
        (["run=pretrained:mine", "controller.gains=[1,2]"], "brings its own controller"),
    ],
)
def test_wrong_names(arguments: list[str], sentence: str) -> None:
    with pytest.raises(UserError, match=sentence):
        evaluate.main([*arguments, "episodes=1"])
    assert not list(Path.cwd().iterdir())
    shutil.rmtree(pretrained.FOLDER)
    with pytest.raises(UserError, match="there are none yet"):
        load_policy("nav_complex")


def test_damaged_weights(published: PretrainedFolder) -> None:
    weights, content = load_file(published.weights), published.weights.read_bytes()
    pickled, bare = io.BytesIO(), save(weights)
    torch.save(weights, pickled)
    for damaged in (b"", b"nonsense", content[: len(content) // 2], content + b"more", bare, pickled.getvalue()):
        published.weights.write_bytes(damaged)
        with pytest.raises(UserError, match="damaged or not a file of weights"):
            load_policy("mine")


@pytest.mark.parametrize(
    ("stored", "changed", "sentence"),
    [
        ("- 100\n  - 100\n", "- 64\n  - 64\n", "another shape"),
        # The weights would fit: how fast they drive is not in them.
        (
            "max_linear_velocity: 0.5",
            "max_linear_velocity: 0.4",
            r"another shape .*action_high \[0\.5, 1\.04\d+\] instead of \[0\.4\d+, 1\.04",
        ),
    ],
)
def test_weights_of_another_agent(stored: str, changed: str, sentence: str, published: PretrainedFolder) -> None:
    published.config.write_text(published.config.read_text().replace(stored, changed))
    with pytest.raises(UserError, match=sentence):
        evaluate.main(["run=pretrained:mine", "episodes=1"])


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("widths", [[], [-1, 5], ["a", "b"], 3, [64, 64]]),
        ("scan_shape", [[3, 2], [3]]),
        ("observation_size", [None]),
        ("action_low", [[0.0]]),
    ],
)
def test_a_header_that_describes_no_network(name: str, values: list[object], published: PretrainedFolder) -> None:
    with safe_open(published.weights, framework="pt") as file:
        header = json.loads(file.metadata()["asddpg_policy"])
    weights = load_file(published.weights)
    for value in values:
        changed = header | {"shape": header["shape"] | {name: value}}
        save_file(weights, published.weights, {"asddpg_policy": json.dumps(changed)})
        with pytest.raises(UserError, match="damaged|another shape") as caught:
            load_policy("mine")
        assert "\n" not in str(caught.value)


@pytest.mark.usefixtures("published")
def test_a_policy_checks_its_observation_and_leaves_the_global_generator_alone() -> None:
    before = torch.random.get_rng_state()
    policy = load_policy("mine")
    assert torch.equal(before, torch.random.get_rng_state())
    with pytest.raises(ValueError, match=r"\(124,\), not \(1, 124\)"):
        policy.act(np.zeros((1, 124), dtype=np.float32))


def test_nothing_is_overwritten_unasked_or_left_half_written(
    finished_run: RunFolder, published: PretrainedFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = published.card.read_text()
    arguments = [f"run={finished_run.path}", "name=mine", "episodes=1", "checkpoint=best"]
    with pytest.raises(UserError, match="overwrite=true"):
        publish.main(arguments)
    assert published.card.read_text() == before
    publish.main([*arguments, "overwrite=true"])
    assert "`best`" in published.card.read_text()
    assert [path.name for path in published.path.parent.iterdir()] == ["mine"]
    before = published.card.read_text()
    monkeypatch.setattr(publish, "MAX_WEIGHT_BYTES", 1000)
    with pytest.raises(UserError, match=r"0\.\d MB"):
        publish.main([*arguments, "overwrite=true"])
    assert published.card.read_text() == before
    assert [path.name for path in published.path.parent.iterdir()] == ["mine"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["run={run}"], "name= is missing"),
        (["run={run}", "name=../x"], "small letters"),
        (["run={run}", "name=x", "checkpoint=first"], "last or best"),
        (["run={run}", "name=x", "episodes=1001"], "from 1 to 1000"),
        (["run=nowhere", "name=x"], "not the folder of a run"),
        (["run=pretrained:x", "name=y"], "not the folder of a run"),
    ],
)
def test_invalid_arguments(arguments: list[str], sentence: str, finished_run: RunFolder, shelf: Path) -> None:
    with pytest.raises(UserError, match=sentence):
        publish.main([argument.format(run=finished_run.path) for argument in arguments])
    assert not shelf.exists()


@pytest.mark.parametrize("text", [None, "", "{", "[]", "{}", '{"training_seconds": null}', '{"training_seconds": "x"}'])
def test_a_run_that_is_not_finished_or_damaged(
    text: str | None, finished_run: RunFolder, tmp_path: Path, shelf: Path
) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run/config.yaml").write_bytes(finished_run.config.read_bytes())
    if text is not None:
        (tmp_path / "run/resources.json").write_text(text)
    with pytest.raises(UserError, match=r"not finished" if text is None else r"resources\.json is damaged"):
        publish.main([f"run={tmp_path / 'run'}", "name=x"])
    assert not shelf.exists()


def test_the_card_says_how_the_seed_was_chosen_and_the_training_is_left_as_it_was(
    finished_run: RunFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = open_trained(str(finished_run.path))
    monkeypatch.setattr(publish, "open_trained", lambda *_: opened)
    before = copy.deepcopy(opened.config)
    publish.main([f"run={finished_run.path}", "name=noted", "episodes=1", "note=Seed 3 of five,  mean 0.95."])
    assert "\n\nSeed 3 of five, mean 0.95.\n" in open_pretrained("noted").card.read_text()
    assert opened.config == before
    assert before.run_dir is not None


@pytest.mark.slow
def test_a_policy_of_changing_rooms_has_a_row_for_each_generator_and_each_task(tmp_path: Path) -> None:
    arguments = ["task=nav_anywhere", "total_steps=160", "agent.learning_starts=64", "validation.every=0"]
    train.main([*arguments, "test_episodes=0", "robots=2", f"run_dir={tmp_path / 'run'}"])
    publish.main([f"run={tmp_path / 'run'}", "name=anywhere", "episodes=3"])
    card = open_pretrained("anywhere").card.read_text()
    rows = [line for line in card.splitlines() if line.startswith("| ")]
    assert [row.split()[1] for row in rows if row.split()[1] in (*GENERATED, *ROOM_TASKS)] == [
        "clutter",
        "cylinders",
        *ROOM_TASKS,
    ]
    assert "in generated rooms" in card
    assert "goal in" not in card


def test_arguments_name_what_differs_and_no_more() -> None:
    config = train_config([*ARGUMENTS, *SHORT, "run_dir=somewhere"])
    arguments = arguments_of(config)
    assert dataclasses.replace(config, run_dir=None) == train_config(arguments)
    assert arguments[:4] == ["task=nav_empty", "agent=asddpg_paper", "reward=sparse", "network=fc2x100"]
    assert set(arguments[4:]) >= {"controller.gains=[2.0,1.5]", "agent.actor_learning_rate=1e-05", "seed=3"}
    assert arguments_of(train_config(["task=nav_complex"])) == ["task=nav_complex"]
    assert arguments_of(train_config(["task=nav_complex", "device=cuda:0"])) == ["task=nav_complex", "device=cuda:0"]


def test_a_task_of_ones_own_settings_has_its_own_snippet() -> None:
    snippet = _snippet("mine", TaskConfig(name="nav_empty", time_limit_steps=40))
    assert "make_environment(policy.config.task, policy.config.reward)" in snippet
    compile(snippet, "card", "exec")
