"""Finished runs, found by the digest of what they were trained with.

A run belongs to every group with its options, and to no other.
"""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from asddpg.errors import UserError
from asddpg.messages import print_line
from asddpg.runs.lock import RunLock
from asddpg.runs.provenance import PROLONGED, RESUMED, versions
from asddpg.runs.run_folder import RunFolder, read_config
from tools.experiments.run_metrics import Metrics, read_metrics
from tools.experiments.runs import Group, Run, digest


@dataclass(frozen=True)
class FinishedRun:
    """The metrics of a run, its provenance, and the folder that holds or held it."""

    metrics: Metrics
    provenance: Mapping[str, str]
    folder: str


Results = Mapping[str, Mapping[int, FinishedRun]]  # by group and seed


@dataclass(frozen=True)
class RunStore:
    """The finished runs of a folder and, by digest, published ones."""

    folder: Path
    published: Mapping[str, FinishedRun] = field(default_factory=dict)

    def find(self, run: Run) -> FinishedRun | None:
        """A finished run; UserError where a file of its folder is damaged."""
        folder = RunFolder(self.folder / run.name)
        provenance = _read_provenance(folder, run)
        if provenance is None or not folder.resources.is_file():  # which is written last
            return self.published.get(run.digest)
        return FinishedRun(read_metrics(folder, run.config), provenance, str(folder.path))

    def results(self, groups: Mapping[str, Group]) -> Results:
        """The finished runs of each group."""
        return {
            name: {seed: found for seed in group.seeds if (found := self.find(group.run(seed)))}
            for name, group in groups.items()
        }

    def missing(self, groups: Mapping[str, Group]) -> list[Run]:
        """The runs still to be trained, each once, with the title of the first group that has it."""
        runs: dict[str, Run] = {}
        for group in groups.values():
            for seed in group.seeds:
                run = group.run(seed)
                runs.setdefault(run.digest, run)
        return [run for run in runs.values() if not self.find(run)]


def can_resume(run: Run, path: Path) -> bool:
    """Whether an unfinished run lies there that today's versions can go on with."""
    folder = RunFolder(path)
    provenance = _read_provenance(folder, run)
    return provenance is not None and not folder.resources.is_file() and versions().items() <= provenance.items()


def _read_provenance(folder: RunFolder, run: Run) -> Mapping[str, str] | None:
    """The provenance of a run; None where the folder does not hold one that had its options from begin to end.

    The schedules of a prolonged run ended before it did; one resumed in another scene or with other versions is half
    of each.
    """
    try:
        options, provenance = read_config(folder.config)
    except (UserError, OSError):
        return None
    is_whole = digest(options) == run.digest and not {PROLONGED, RESUMED} & provenance.keys()
    return provenance if is_whole else None


def archive_existing(path: Path) -> None:
    """Free the folder of a run to train: what lies there is kept under another name.

    Raises:
        UserError: a process is writing it.
    """
    if not path.exists():
        return
    if (path / "config.yaml").is_file():
        with RunLock(path):  # a process that writes it would go on under the new name
            pass
    kept = next(old for n in itertools.count(1) if not (old := path.with_name(f"{path.name}.old{n}")).exists())
    path.rename(kept)
    print_line(f"{path} holds no run of these options and versions; it is kept as {kept} and trained anew")
