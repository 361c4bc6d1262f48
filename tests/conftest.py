from collections.abc import Iterator
from pathlib import Path

import pytest
import torch

from asddpg.build import prepare_torch

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(autouse=True, scope="session")
def _torch_as_in_training() -> Iterator[None]:
    threads = torch.get_num_threads()
    prepare_torch()
    yield
    torch.set_num_threads(threads)
