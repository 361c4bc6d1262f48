"""Sentences that lead on from the command lines of other programs: Hydra's and argparse's."""

import re
from collections.abc import Collection

_SEVERAL = re.compile(r".+,.+|(range|choice|interval|glob)\(.*\)")
_LOOP = "for several runs, a loop of the shell: for value in {1}; do python -m … {0}=$value; done"
_HYDRA = {
    ("-m", "--multirun"): _LOOP.format("seed", "1 2 3"),
    ("--config-name", "-cn", "--config-path", "-cp", "--config-dir", "-cd"): (
        "no file of options is read: options are written as name=value, and --help lists them, with their presets"
    ),
    ("--cfg", "-c", "--info", "-i", "--resolve", "--package", "-p"): (
        "--help lists the options with their defaults, and the config.yaml of a run has them as it was trained"
    ),
}


def sweep_hint(name: str, text: str) -> str:
    """How to give an option several values, where a text looks like them; it begins with a semicolon, or is empty."""
    if not _SEVERAL.fullmatch(text):
        return ""
    values = "1 2 3" if "(" in text else " ".join(text.split(","))
    return f"; {_LOOP.format(name, values)}"


def plain_name(name: str, known: Collection[str]) -> str:
    """The option that is meant by a name with other programs' marks, such as --run-dir or ++seed; else the name."""
    plain = name.lstrip("-+~").replace("-", "_").lower()
    return plain if plain in known else name


def hydra_sentence(name: str) -> str:
    """What to do here in the place of an argument of Hydra's; empty for any other."""
    if name.startswith(("hydra.", "hydra/", "+hydra", "--hydra")):
        return "these programs do without Hydra: run_dir= names the folder of a run, and --help lists all options"
    return next((sentence for names, sentence in _HYDRA.items() if name in names), "")
