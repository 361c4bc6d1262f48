"""The words of a command line that name recordings."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from asddpg.errors import UserError
from asddpg.recording.reading import Recording, open_recording
from tools.option_words import options_in

EXAMPLE = "evaluated_episodes/00100000_00001_reached.mcap"
_INNER = ("episodes", "evaluated_episodes")  # where a run's folder has its recordings


def files_and_options(words: Sequence[str], known: Sequence[str]) -> tuple[list[Path], dict[str, str]]:
    """Recordings by their files or folders, and options by name.

    Raises:
        UserError: an option that does not exist, no recording, or a folder without any.
    """
    named = [word for word in words if "=" not in word or Path(word).exists()]
    options = options_in([word for word in words if word not in named], known)
    if not named:
        raise UserError(f"name a recording, such as {EXAMPLE}")
    return [file for name in named for file in _files(Path(name))], options


def single(words: Sequence[str], known: Sequence[str]) -> tuple[Recording, dict[str, str]]:
    """The one recording that is named, and options; UserError as above, or where there are several."""
    files, options = files_and_options(words, known)
    if len(files) > 1:
        raise UserError(f"name one recording, not {len(files)}: {files[0]}, {files[1]}{', …' * (len(files) > 2)}")
    return open_recording(files[0]), options


def _files(path: Path) -> Iterator[Path]:
    if not path.is_dir():
        yield path
        return
    found = sorted(path.glob("*.mcap")) or sorted(file for inner in _INNER for file in path.glob(f"{inner}/*.mcap"))
    if not found:
        raise UserError(f"the folder {path} holds no recordings, *.mcap")
    yield from found
