"""What files that somebody else wrote may not do: run code, lead elsewhere, read the environment, take all memory."""

import os
import shlex
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, Any

import yaml

from asddpg.algorithm.controllers import CONTROLLERS
from asddpg.config import ControllerConfig, TrainConfig
from asddpg.errors import UserError, truncated_repr

OURS = ControllerConfig.type  # a controller that needs no code but the project's
CONTROLLER = "controller.type="
LARGEST_CONFIG = 10**6  # bytes; written by asddpg.train it has 3000


class _PlainLoader(yaml.SafeLoader):
    """YAML without aliases: ten lines of them stand for more than any memory holds."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("an alias")
        return super().compose_node(parent, index)


def plain_values(text: str | bytes) -> Any:
    """What stands in a YAML file, no more than that.

    Raises:
        ValueError: it is no YAML, too much of it, or stands for something else.
    """
    if len(text) > LARGEST_CONFIG:
        raise ValueError("no configuration is so long")
    try:
        values = yaml.load(text, Loader=_PlainLoader)
    except (yaml.YAMLError, RecursionError) as error:
        raise ValueError("no YAML") from error
    if any(isinstance(value, str) and ("${" in value or value == "???") for value in _leaves(values)):
        raise ValueError("a reference")  # OmegaConf would put in what the environment holds
    return values


def _leaves(values: Any) -> Iterator[Any]:
    if isinstance(values, dict):
        values = [*values, *values.values()]
    if not isinstance(values, list):
        yield values
        return
    for value in values:
        yield from _leaves(value)


def beginning_of(path: Path) -> bytes:
    """A configuration's bytes, or more than there may be of them."""
    with path.open("rb") as file:
        return file.read(LARGEST_CONFIG + 1)


def check_controller(config: TrainConfig, named: str | None, title: str) -> None:
    """Hold the controller of a stored configuration against the one that the user has named: a controller is code.

    Args:
        config: as stored.
        named: by the user, OURS where he has said nothing; None where no controller is going to be made.
        title: of the configuration.

    Raises:
        UserError: it is another one, and none of this project's.
    """
    kind = config.controller.type
    if named is not None and kind not in CONTROLLERS and kind != named:
        raise UserError(
            f"{title} names a controller that is code of its own, {truncated_repr(kind)}; if you trust that "
            f"code, say so by controller.type={kind}"
        )


def controller_named_in(arguments: Sequence[str]) -> str:
    """The controller that a user has named among the words of a command line; OURS if none."""
    return next((argument.removeprefix(CONTROLLER) for argument in arguments if argument.startswith(CONTROLLER)), OURS)


def controller_argument(config: TrainConfig) -> str:
    """What a command line that makes a configuration's agent needs besides, with a space before it; often nothing."""
    kind = config.controller.type
    return "" if kind in CONTROLLERS else f" {CONTROLLER}{shlex.quote(kind)}"


def check_links(folder: Path) -> None:
    """UserError where something in a run's folder is a link that leads out of it: it would be read, or written over."""
    inside = os.path.realpath(folder)
    for parent, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = os.path.join(parent, name)
            if os.path.islink(path) and os.path.commonpath([inside, os.path.realpath(path)]) != inside:
                raise UserError(f"the run's folder holds a link that leads out of it, {path}; put a copy in its place")


def check_packed(file: Path | IO[bytes], largest: int) -> None:
    """Hold what a zip archive unpacks to against the most that it may.

    Raises:
        ValueError: it is more.
        zipfile.BadZipFile: it is no archive.
    """
    with zipfile.ZipFile(file) as archive:
        if sum(entry.file_size for entry in archive.infolist()) > largest:
            raise ValueError("it unpacks to more than it may")
