"""YAML files with nothing but mappings, lists and text."""

from pathlib import Path
from typing import Any

import yaml

from tasks.errors import TaskError
from tasks.rooms.limits import read_bytes

MAX_YAML_BYTES = 500_000  # PyYAML reads some 100 kB a second, 30 kB at worst


def read_mapping(path: Path) -> dict[str, Any]:
    """The mapping that a YAML file holds, every scalar as text.

    Merge keys, dates and numbers to the base of 60 are text too: a short file cannot grow by them.

    Raises:
        TaskError: the file is missing, too large, no YAML, or no mapping.
    """
    try:
        content = yaml.load(read_bytes(path, MAX_YAML_BYTES), yaml.BaseLoader)  # makes text, lists and mappings alone
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise TaskError(f"{path} is not a YAML file that can be read") from error
    if not isinstance(content, dict):
        raise TaskError(f"{path} is a YAML file without names: it holds no room")
    return content
