"""Loads untrusted files safely: they may not run code, link elsewhere, read the environment or exhaust memory."""

import os
import shlex
import zipfile
from collections.abc import Sequence
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
    """YAML without aliases: ten lines of them can expand beyond any memory."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("an alias")
        return super().compose_node(parent, index)


def plain_values(text: str | bytes) -> Any:
    """The literal values in a YAML file.

    Raises:
        ValueError: it is not YAML, is too long, or has aliases.
    """
    if len(text) > LARGEST_CONFIG:
        raise ValueError("no configuration is so long")
    try:
        return yaml.load(text, Loader=_PlainLoader)
    except (yaml.YAMLError, RecursionError) as error:
        raise ValueError("no YAML") from error


def check_controller(config: TrainConfig, named: str | None, title: str) -> None:
    """Check that a stored configuration's controller, which is code, is ours or the one that the user has named.

    With `named` None, no controller is made and any is accepted.

    Raises:
        UserError: it is another one; the title names the configuration.
    """
    kind = config.controller.type
    if named is not None and kind not in CONTROLLERS and kind != named:
        raise UserError(
            f"{title} names a controller that is code of its own, {truncated_repr(kind)}; if you trust that "
            f"code, pass controller.type={kind}"
        )


def controller_named_in(arguments: Sequence[str]) -> str:
    """The controller.type that a user has named on the command line; OURS by default."""
    return next((argument.removeprefix(CONTROLLER) for argument in arguments if argument.startswith(CONTROLLER)), OURS)


def controller_argument(config: TrainConfig) -> str:
    """The argument that makes the configuration's controller, with a space before it; often empty."""
    kind = config.controller.type
    return "" if kind in CONTROLLERS else f" {CONTROLLER}{shlex.quote(kind)}"


def check_links(folder: Path) -> None:
    """UserError where something in a run's folder is a link that leads out of it: it could be read or overwritten."""
    inside = os.path.realpath(folder)
    for parent, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = os.path.join(parent, name)
            if os.path.islink(path) and os.path.commonpath([inside, os.path.realpath(path)]) != inside:
                raise UserError(f"the run's folder holds a link that leads out of it, {path}; put a copy in its place")


def check_packed(file: Path | IO[bytes], largest: int) -> None:
    """Check the unpacked size of a zip archive.

    Raises:
        ValueError: it is larger than `largest`, bytes.
        zipfile.BadZipFile: it is no archive.
    """
    with zipfile.ZipFile(file) as archive:
        if sum(entry.file_size for entry in archive.infolist()) > largest:
            raise ValueError("it unpacks to more than is allowed")
