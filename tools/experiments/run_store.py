"""Finished runs in a folder, found by what they were trained with and not by their name.

So one run serves every group that asks for the same, and a run whose options have changed since serves none.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from asddpg.errors import UserError
from asddpg.runs.lock import RunLock
from asddpg.runs.provenance import PROLONGED, RESUMED, versions
from asddpg.runs.run_folder import RunFolder, read_config

Settings = dict[str, Any]
SHOWN_DIFFERENCES = 3
# What changes nothing that is learned: where a run lies, how often it is kept, what is recorded, and who watches.
WITHOUT_EFFECT = ("run_dir", "checkpoint_every", "record", "live", "port", "speed")


class FinishedRun(Protocol):
    """What a table says of a run beside its figures."""

    @property
    def settings(self) -> Settings:
        """Every option that bears on the learning."""

    @property
    def provenance(self) -> Mapping[str, str]:
        """Versions, and the hash of the scene."""

    @property
    def place(self) -> str:
        """Where it lies."""


R = TypeVar("R", bound=FinishedRun)


@dataclass(frozen=True)
class StoredRun:
    """A finished run in a folder."""

    folder: RunFolder
    settings: Settings
    provenance: dict[str, str]

    @property
    def place(self) -> str:
        """Where it lies."""
        return str(self.folder.path)


def stored_runs(folder: Path) -> list[StoredRun]:
    """The finished runs in a folder, but for those whose configuration cannot be read, and prolonged ones.

    The schedules of a prolonged run ended before it did, and one that went on in another scene or with other versions
    is half of each: they are not what their options say.
    """
    runs = []
    for path in sorted(folder.glob("*/")):
        run = RunFolder(path)
        if is_finished(run) and (read := _read(run)) and is_unmodified(read[1]):
            runs.append(StoredRun(run, *read))
    return runs


def is_finished(run: RunFolder) -> bool:
    """Whether a run came to its end: what it took is written last."""
    return run.resources.is_file() and run.config.is_file()


def is_begun(path: Path, settings: Settings) -> bool:
    """Whether a run with these settings was begun there and can go on."""
    run = RunFolder(path)
    if not run.config.is_file() or is_finished(run):
        return False
    read = _read(run)
    today = versions()
    return (
        read is not None
        and read[0] == settings
        and is_unmodified(read[1])
        and all(read[1].get(name) == version for name, version in today.items())
    )


def is_unmodified(provenance: Mapping[str, str]) -> bool:
    """Whether a run was made from beginning to end with what it began with, and with its schedules."""
    return PROLONGED not in provenance and RESUMED not in provenance


def find(settings: Settings, runs: Sequence[R]) -> R | None:
    """The run that was trained with these settings."""
    return next((run for run in runs if run.settings == settings), None)


def archive_existing(path: Path, settings: Settings) -> str:
    """Free the folder of a run to train: what is there is kept under another name.

    Returns:
        What was kept and why, or nothing.

    Raises:
        UserError: a process is writing it.
    """
    run = RunFolder(path)
    if not path.exists():
        return ""
    if run.config.is_file():
        with RunLock(path):  # whoever writes it would go on under the new name
            pass
    read = _read(run)
    reason = _named(differences(read[0], settings), read[1]) if read else "is no run that can be read"
    kept = next(old for number in range(1, 10_000) if not (old := path.with_name(f"{path.name}.old{number}")).exists())
    path.rename(kept)
    return f"{path} {reason}; it is kept as {kept} and trained anew"


def differences(old: Settings, new: Settings) -> list[str]:
    """Options that differ, each as `name was … and is …`."""
    flat_old, flat_new = dict(flat(old)), dict(flat(new))
    return [
        f"{name} was {flat_old.get(name, 'not there')} and is {flat_new.get(name, 'not there')}"
        for name in [*flat_new, *(name for name in flat_old if name not in flat_new)]
        if flat_old.get(name) != flat_new.get(name) or (name in flat_old) != (name in flat_new)
    ]


def _named(found: Sequence[str], provenance: Mapping[str, str]) -> str:
    if PROLONGED in provenance:
        return "was prolonged after its schedules had ended"
    if not found:
        return "was begun with other versions, or in another scene"
    more = f" and {len(found) - SHOWN_DIFFERENCES} more" if len(found) > SHOWN_DIFFERENCES else ""
    return f"was trained with other options ({', '.join(found[:SHOWN_DIFFERENCES])}{more})"


def flat(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Every option by its full name, such as agent.gamma."""
    for name, value in settings.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _read(run: RunFolder) -> tuple[Settings, dict[str, str]] | None:
    try:
        settings, provenance = read_config(run.config)
    except (UserError, OSError):
        return None
    return with_effect(settings), provenance


def with_effect(settings: Settings) -> Settings:
    """The options that bear on what is learned."""
    return {name: value for name, value in settings.items() if name not in WITHOUT_EFFECT}
