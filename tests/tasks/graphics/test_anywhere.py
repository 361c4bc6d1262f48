"""Pictures in every thread and process, and beside other users of OpenGL: equal pictures, no hang, no noise at exit.

Each scenario runs in a process of its own: `python -m tests.tasks.graphics.test_anywhere <scenario>`.
"""

import copy
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import tasks
from tasks.errors import TaskError

SIZE: dict[str, Any] = {"render_mode": "rgb_array", "width": 64, "height": 48}


def make_env() -> Any:
    env = gymnasium.make("asddpg/NavEmpty-v0", **SIZE)
    env.reset(seed=1)
    return env


def threads() -> None:
    env = make_env()
    with ThreadPoolExecutor(8) as pool:
        first = pool.submit(env.render).result()  # made in one thread, first rendered in another
        pictures = [env.render(), *pool.map(lambda _: env.render(), range(16))]
        pictures += pool.map(lambda _: make_env().render(), range(4))  # collected without close()
        pool.submit(env.close).result()
    assert all(np.array_equal(picture, first) for picture in [*pictures, env.render()])


def copies() -> None:
    env = make_env()
    first = env.render()
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert np.array_equal(other.render(), first)
    task = tasks.load("nav_empty", random=0)
    task.reset()
    first = task.physics.render(48, 64)
    for physics in (copy.deepcopy(task).physics, pickle.loads(pickle.dumps(task.physics)), task.physics.copy()):
        assert np.array_equal(physics.render(48, 64), first)


def forked_workers() -> None:
    fork = multiprocessing.get_context("fork")
    env = make_env()
    first = env.render()
    stopped = threading.Event()

    def render_until_stopped() -> None:
        while not stopped.is_set():
            env.render()

    def check(then: Callable[[], None] = lambda: None) -> None:
        assert all(np.array_equal(each.render(), first) for each in (env, make_env()))
        then()

    def refused() -> None:
        with pytest.raises(TaskError, match="context.*spawn"):
            env.render()

    def run(function: Callable[..., None], *arguments: Any) -> None:
        process = fork.Process(target=function, args=arguments)
        process.start()
        process.join()
        assert process.exitcode == 0

    thread = threading.Thread(target=render_until_stopped)
    thread.start()
    run(check)
    run(check)
    stopped.set()
    thread.join()
    env.close()
    run(check)
    run(run, check)
    run(check, lambda: run(refused))  # a third display is not to be had
    vector = gymnasium.make_vec("asddpg/NavEmpty-v0", 2, vectorization_mode="async", **SIZE)  # forks
    vector.reset(seed=1)
    assert np.array_equal((vector.render() or ())[0], first)
    vector.close()


def bare_fork() -> None:
    warnings.simplefilter("ignore", DeprecationWarning)  # Python 3.12's own, of a fork beside threads
    env = make_env()
    env.render()
    for is_rendering in (False, True):
        child = os.fork()
        if child == 0:
            if is_rendering:
                with pytest.raises(TaskError, match="context.*spawn"):
                    env.render()
            env.close()
            sys.exit(0)  # with all exit handlers
        assert os.waitpid(child, 0)[1] == 0


def exit_in_the_midst() -> None:
    env = make_env()

    def render_for_ever() -> None:
        while True:
            env.render()

    for _ in range(2):
        threading.Thread(target=render_for_ever, daemon=True).start()
    time.sleep(0.3)


def interrupts() -> None:
    env = make_env()
    first = env.render()
    signal.signal(signal.SIGALRM, signal.default_int_handler)

    def render_for_ever() -> None:
        while True:
            assert np.array_equal(env.render(), first)

    for _ in range(10):
        signal.setitimer(signal.ITIMER_REAL, 0.01)
        with pytest.raises(KeyboardInterrupt):
            render_for_ever()


def neighbours() -> None:
    import mujoco
    from dm_control import suite
    from dm_control.suite.wrappers import pixels

    theirs = suite.load("cartpole", "swingup", task_kwargs={"random": 1})
    theirs.reset()
    renderer = mujoco.Renderer(theirs.physics.model.ptr, 48, 64)

    def picture() -> Any:
        renderer.update_scene(theirs.physics.data.ptr)
        return np.stack([theirs.physics.render(48, 64), renderer.render()])

    first, env = picture(), make_env()
    ours = env.render()
    for _ in range(2):
        assert np.array_equal(picture(), first)
        assert np.array_equal(env.render(), ours)
    wrapped = pixels.Wrapper(tasks.load("nav_empty"), render_kwargs={"depth": True})
    assert wrapped.reset().observation["pixels"].dtype == np.float32
    renderer.close()


SCENARIOS: tuple[Callable[[], None], ...] = (
    threads,
    copies,
    forked_workers,
    bare_fork,
    exit_in_the_midst,
    interrupts,
    neighbours,
)


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda scenario: scenario.__name__)
def test_pictures_are_equal_and_nothing_is_printed(scenario: Callable[[], None]) -> None:
    done = subprocess.run(
        [sys.executable, "-m", __name__, scenario.__name__],
        cwd=Path(__file__).parents[3],
        env=os.environ | {"MUJOCO_GL": "egl"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


if __name__ == "__main__":
    globals()[sys.argv[1]]()
