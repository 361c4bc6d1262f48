"""Programs a person runs on models, runs and recordings: `python -m tools.<name>`."""

import sys
from pathlib import Path

_ROOT = str(Path(__file__).resolve().parents[1])
sys.path.insert(0, _ROOT)  # an asddpg.py of the user's stays out of the way
import asddpg  # noqa: E402

sys.path.remove(_ROOT)
asddpg.prepare_path()
