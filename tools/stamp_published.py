"""`python -m tools.stamp_published`: published runs are those of today's options again, after an option was added.

Only for an option that by default changes nothing in them; after any other change they are trained anew. Rewrites the
digests in docs/runs and says how many have changed.
"""

import csv
import io
import shlex
from collections.abc import Sequence
from pathlib import Path

from asddpg.atomic_write import write_whole
from asddpg.errors import UserError
from asddpg.program import run
from tools.experiments import run_csv
from tools.experiments.run_csv import COLUMNS, DIGEST, digest, outdated
from tools.experiments.run_groups import settings_of


def stamp(path: Path) -> int:
    """Give each run of a published file the digest of what its words mean today.

    Returns:
        How many had another.

    Raises:
        UserError: the file is damaged, or a run has words that mean nothing any more; nothing is written then.
    """
    changed = outdated(path)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row[DIGEST] = digest(settings_of(shlex.split(row["arguments"])))
    stamped = io.StringIO(newline="")
    writer = csv.DictWriter(stamped, COLUMNS)
    writer.writeheader()
    writer.writerows(rows)
    write_whole(path, stamped.getvalue().encode())
    return changed


def main(arguments: Sequence[str]) -> None:
    """Stamp all published files."""
    if arguments:
        raise UserError(f"tools.stamp_published takes no words, not {arguments[0]!r}")
    for path in sorted(run_csv.PUBLISHED.glob("*.csv")):
        print(f"{path}: {stamp(path)} runs of other options are now taken for those of today's")


if __name__ == "__main__":
    run(main, __doc__)
