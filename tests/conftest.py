import signal
import socket
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent

TINY = ["total_steps=400", "agent.learning_starts=100", "network=fc2x100", "test_episodes=0", "seed=101"]
TINY += ["robots=1", "agent.batch_size=32", "agent.samples_per_step=32"]
TINY += ["validation.every=200", "validation.episodes=1", "task.time_limit_steps=40"]


def free_port() -> int:
    """A port of this machine that nobody has."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port: int = found.getsockname()[1]
        return port


@pytest.fixture(autouse=True, scope="session")
def _torch_as_in_training() -> Iterator[None]:
    if find_spec("torch") is None:  # .ci/versions runs the tests of the tasks without
        yield
        return
    from asddpg.build import prepare_torch

    with prepare_torch():
        yield


@pytest.fixture(autouse=True, scope="session")
def _signals_are_heard() -> Iterator[None]:
    """A shell that starts the tests in the background, or nohup, has some ignored, here and in processes begun here."""
    before = [signal.signal(signal.SIGINT, signal.default_int_handler), signal.signal(signal.SIGHUP, signal.SIG_DFL)]
    yield
    for number, handler in zip((signal.SIGINT, signal.SIGHUP), before, strict=True):
        signal.signal(number, handler)


@pytest.fixture(scope="session")
def tiny_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run of 400 steps with two snapshots; to be read, not written to."""
    from asddpg import train

    folder = tmp_path_factory.mktemp("tiny") / "run"
    train.main(["task=nav_complex", *TINY, f"run_dir={folder}"])
    return folder
