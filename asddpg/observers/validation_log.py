"""A row a validation, to validation.csv, and the same figures to TensorBoard."""

import csv
from pathlib import Path

from asddpg.observers.metrics_log import ScalarWriter

COLUMNS = ("step", "success_rate", "collision_rate", "metric")


def write_validation(path: Path, tensorboard: ScalarWriter, row: dict[str, float]) -> None:
    """Add a row of COLUMNS."""
    is_new = not path.exists()
    with path.open("a", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        if is_new:
            table.writeheader()
        table.writerow(row)
    for name in COLUMNS[1:]:
        tensorboard.add_scalar(f"validation/{name}", row[name], int(row["step"]))
