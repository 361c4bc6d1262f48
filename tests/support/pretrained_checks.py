"""What holds for every pretrained policy, one that a test has published or one that is shipped."""

import dataclasses
import json
import re
import shlex
from itertools import pairwise
from typing import Any

import yaml

from asddpg.command_line import train_config
from asddpg.config import TrainConfig
from asddpg.runs.pretrained import PretrainedFolder
from asddpg.runs.run_folder import read_training

LARGEST = 3_000_000  # bytes


def check_nothing_but_tensors(folder: PretrainedFolder) -> None:
    """The file is a length, a header of JSON and float32 numbers, byte for byte: no room for a pickle or an archive."""
    content = folder.weights.read_bytes()
    assert len(content) < LARGEST
    length = int.from_bytes(content[:8], "little")
    header = json.loads(content[8 : 8 + length])
    assert set(header.pop("__metadata__")) == {"asddpg_policy"}
    spans = sorted(tensor["data_offsets"] for tensor in header.values())
    assert {tensor["dtype"] for tensor in header.values()} == {"F32"}
    assert spans[0][0] == 0
    assert all(one[1] == other[0] for one, other in pairwise(spans))
    assert spans[-1][1] == len(content) - 8 - length
    assert not [name for name in header if name.startswith("critic")]


def check_files(folder: PretrainedFolder) -> None:
    """Four files that everybody may read, and nothing of the machine in them."""
    paths = sorted(folder.path.iterdir())
    assert [path.name for path in paths] == ["card.md", "config.yaml", "policy.safetensors", "test.json"]
    assert all(path.stat().st_mode & 0o044 == 0o044 for path in paths)
    values = yaml.safe_load(folder.config.read_text())
    assert values["run_dir"] is None
    assert values["device"] == "cpu"
    texts = [path.read_text() for path in (folder.card, folder.config, folder.test)]
    assert not [text for text in texts if re.search(r"/(home|root|tmp|Users|work)/", text)]


def check_front_matter(folder: PretrainedFolder) -> None:
    """What model hubs read of a card: the policy's name and its figures."""
    _, front, _ = folder.card.read_text().split("---\n", 2)
    content = yaml.safe_load(front)
    (index,) = content["model-index"]
    found = {metric["type"]: metric["value"] for metric in index["results"][0]["metrics"]}
    tested = json.loads(folder.test.read_text())["actor"]
    assert index["name"] == folder.path.name
    assert found == {rate: round(tested[rate]["value"], 4) for rate in ("success_rate", "collision_rate")}
    assert (content["license"], content["library_name"]) == ("mit", "asddpg")


def config_by_the_cards_command(folder: PretrainedFolder) -> TrainConfig:
    """What the command on the card composes to."""
    (command,) = re.findall(r"^python -m asddpg\.train .*$", folder.card.read_text(), re.MULTILINE)
    return train_config(shlex.split(command)[3:])


def check_the_cards_command(folder: PretrainedFolder) -> None:
    """The card's command makes the stored configuration, but for the device, which is stored as the processor."""
    config = dataclasses.replace(config_by_the_cards_command(folder), device="cpu")
    assert config == read_training(folder.config)[0]


def run_the_cards_snippet(folder: PretrainedFolder) -> dict[str, Any]:
    """Run the card's Python; gives its names."""
    (snippet,) = re.findall(r"```python\n(.*?)```", folder.card.read_text(), re.DOTALL)
    assert len([line for line in snippet.splitlines() if line]) <= 12
    names: dict[str, Any] = {}
    exec(compile(snippet, str(folder.card), "exec"), names)
    assert names["info"]["outcome"] in {"reached", "crashed", "timeout"}
    return names
