"""The words of a command line that name recordings."""

from collections.abc import Sequence
from pathlib import Path

from asddpg.errors import UserError
from asddpg.recording.files.reading import Recording, open_recording
from tools.option_arguments import options_in
from tools.recordings.files import files_named

EXAMPLE = "evaluated_episodes/00100000_00001_reached.mcap"


def files_and_options(arguments: Sequence[str], known: Sequence[str]) -> tuple[list[Path], dict[str, str]]:
    """Recordings by their files or folders, and options by name.

    Raises:
        UserError: an option that does not exist, no recording, or a folder without any.
    """
    named = [argument for argument in arguments if "=" not in argument or Path(argument).exists()]
    options = options_in([argument for argument in arguments if argument not in named], known)
    if not named:
        raise UserError(f"name a recording, such as {EXAMPLE}")
    return files_named(named), options


def single(arguments: Sequence[str], known: Sequence[str]) -> tuple[Recording, dict[str, str]]:
    """The one recording that is named, and options; UserError as above, or where there are several."""
    files, options = files_and_options(arguments, known)
    if len(files) > 1:
        raise UserError(f"name one recording, not {len(files)}: {files[0]}, {files[1]}{', …' * (len(files) > 2)}")
    return open_recording(files[0]), options
