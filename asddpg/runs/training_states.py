"""Training states, from which a training resumes, `<run>/resume/step_<n>/`: the newest and the one before it."""

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from asddpg.errors import UserError
from asddpg.runs import state_files
from asddpg.runs.state_files import INVALID, DamagedStateError

FORMAT = "asddpg-training-3"
KEPT = 2


class TrainingStates:
    """Written atomically, beside the one before; read with their checksums."""

    def __init__(self, folder: Path) -> None:
        """Keep them in a folder, made with the first."""
        self._folder = folder

    def write(self, step: int, state: Mapping[str, Any]) -> None:
        """Write the state after `step` training steps, then drop all but the newest two.

        Raises:
            OSError: it could not be written; those before it are as they were.
        """
        path = self._folder / f"step_{step:08d}"
        part = path.with_name(path.name + ".part")
        for left in self._folder.glob("*.part"):  # of processes that were killed
            shutil.rmtree(left, ignore_errors=True)
        try:
            part.mkdir(parents=True)
            state_files.write(part, {"format": FORMAT, "step": step, **state})
            if path.exists():  # of a process that was killed before it could use this one
                shutil.rmtree(path)
            part.rename(path)
            state_files.to_disk(self._folder)
        except OSError as error:
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        finally:
            shutil.rmtree(part, ignore_errors=True)  # what is left of it takes disk space that others need
        for old in self.paths()[:-KEPT]:
            shutil.rmtree(old)

    def paths(self) -> list[Path]:
        """Their folders, oldest first, by the step in their names: clocks may be set back."""
        return sorted(path for path in self._folder.glob("step_*") if path.name[5:].isdigit())

    def newest(self, check: Callable[[Mapping[str, Any]], None]) -> tuple[dict[str, Any] | None, list[str]]:
        """The newest state that is whole, None if none was ever written, and a sentence for each damaged one.

        Args:
            check: raises DamagedStateError for a state that does not go with other files.

        Raises:
            UserError: there are some, and none is whole.
        """
        damaged: list[str] = []
        for path in reversed(self.paths()):
            try:
                state = self._read(path)
                check(state)
                return state, damaged
            except (DamagedStateError, OSError, *INVALID) as error:
                damaged.append(f"the training state {path} is damaged: {error}")
        if damaged:
            raise UserError(f"{'; '.join(damaged)}; there is no other one to resume from")
        return None, []

    def forget_after(self, step: int) -> None:
        """Rename those of later steps, which are damaged and would be in the way."""
        for path in self.paths():
            if path.name > f"step_{step:08d}":
                aside = path.with_name(path.name + ".damaged")
                shutil.rmtree(aside, ignore_errors=True)
                path.rename(aside)

    def _read(self, path: Path) -> dict[str, Any]:
        state = state_files.read(path)
        if state.get("format") != FORMAT or state.get("step") != int(path.name[5:]):
            raise DamagedStateError("it is not a training state of this version, or not of the step in its name")
        return state
