"""What to write in place of arguments in the syntax of other programs, Hydra's and argparse's."""

import re

_SEVERAL = re.compile(r".+,.+|(range|choice|interval|glob)\(.*\)")
_LOOP = "for several runs, a loop of the shell: for value in {1}; do python -m … {0}=$value; done"
_HYDRA = {
    "-m|--multirun": _LOOP.format("seed", "1 2 3"),
    "--config-.*|-c[ndp]": "no file of options is read: --help lists the options, and the presets of some of them",
    "--cfg|-c|--info|--resolve": "--help lists the options with their defaults, a run's config.yaml those of the run",
    "[-+~]*hydra[./-].*": "there is no Hydra: run_dir= names the folder of a run, and --help lists the options",
}


def sweep_hint(name: str, text: str) -> str:
    """How to give an option several values, where a text looks like them; it begins with a semicolon, or is empty."""
    values = "1 2 3" if "(" in text else text.replace(",", " ")
    return f"; {_LOOP.format(name, values)}" if _SEVERAL.fullmatch(text) else ""


def hydra_sentence(name: str) -> str:
    """What to do in the place of an argument of Hydra's; empty for any other."""
    return next((sentence for form, sentence in _HYDRA.items() if re.fullmatch(form, name)), "")
