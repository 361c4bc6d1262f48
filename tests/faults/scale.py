"""How much of it is done: ASDDPG_FAULTS=0.1 makes a tenth, to try whether it works."""

import os


def scaled(count: int, least: int = 1) -> int:
    return max(least, round(count * float(os.environ.get("ASDDPG_FAULTS", "1"))))
