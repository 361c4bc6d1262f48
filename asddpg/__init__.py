"""AsDDPG (Xie et al., ICRA 2018): DDPG whose critic also switches between the policy and a simple controller."""

import sys
from importlib.util import find_spec
from pathlib import Path

__version__ = "0.1.0"

_ROOT = Path(__file__).resolve().parents[1]
_PROGRAMS = ("asddpg", "tools")  # packages with programs


def prepare_path() -> None:
    """Let imports find what they mean, whatever the user's files are called.

    Python puts the present folder first for `python -m asddpg.train`, and asddpg/ for `python asddpg/train.py`. The
    former becomes the last, where a user's controller is still found. In somebody else's program nothing moves.

    Raises:
        ImportError: `tasks` is not the one beside this package.
    """
    first = sys.path[0] if sys.path else ""
    command = sys.orig_argv[-len(sys.argv) :][:1] if sys.argv[:1] == ["-m"] else []  # asddpg.train, or -masddpg.train
    is_module = any(name.removeprefix("-m").partition(".")[0] in _PROGRAMS for name in command)
    is_script = bool(first) and Path(first).resolve() in [_ROOT / name for name in _PROGRAMS]
    if is_script:
        del sys.path[0]
    elif is_module and not sys.flags.safe_path and Path(first).resolve() != _ROOT:
        sys.path.append(sys.path.pop(0))
    if not _finds_tasks() and (is_script or is_module):
        sys.path.insert(0, str(_ROOT))
    if not _finds_tasks():
        found = find_spec("tasks")
        raise ImportError(
            f"asddpg needs the package {_ROOT / 'tasks'}, and `import tasks` finds "
            f"{found.origin if found else 'nothing'}: rename that, or put {_ROOT} before it in PYTHONPATH"
        )


def _finds_tasks() -> bool:
    spec = find_spec("tasks")
    folders = (spec and spec.submodule_search_locations) or ()
    return any(Path(folder).resolve() == _ROOT / "tasks" for folder in folders)


prepare_path()
