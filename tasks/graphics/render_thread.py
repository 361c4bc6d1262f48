"""One thread of a process for all of its pictures: an OpenGL context belongs to one thread, and to one process.

Any thread may ask for a picture, and no thread's own context is touched. A forked process starts a thread of its own.
"""

import atexit
import ctypes
import os
import threading
from collections.abc import Callable
from concurrent import futures
from queue import SimpleQueue
from typing import Any, Protocol, TypeVar

from tasks.errors import TaskError
from tasks.graphics.gl_context import forget_contexts

T = TypeVar("T")

STOP_TIMEOUT = 10.0  # s that the interpreter's exit waits for a picture in progress


class Freeable(Protocol):
    """What needs the render thread to be freed."""

    def free(self) -> None:
        """Free it; called once, in the render thread."""


class RenderThread:
    """Runs functions one after the other in one thread, until the interpreter exits."""

    def __init__(self) -> None:
        self._jobs: SimpleQueue[tuple[futures.Future[Any], Callable[[], Any]] | None] = SimpleQueue()
        self._open: list[Freeable] = []
        self._thread = threading.Thread(target=self._work, name="asddpg-render", daemon=True)
        self._thread.start()

    def call(self, function: Callable[[], T]) -> T:
        """What the function returns or raises in the thread.

        Raises:
            TaskError: the interpreter is exiting.
        """
        if threading.current_thread() is self._thread:
            return function()
        if not self._thread.is_alive():
            if threading.current_thread().daemon:
                raise SystemExit  # it would be stopped a moment later, without a message
            raise TaskError("the interpreter is exiting: there are no more pictures")
        future = self.post(function)
        try:
            return future.result()
        except BaseException:
            futures.wait([future])  # an interrupt ends no picture halfway, whose data may change afterwards
            raise

    def post(self, function: Callable[[], T]) -> "futures.Future[T]":
        """Run the function in the thread, later."""
        future: futures.Future[T] = futures.Future()
        self._jobs.put((future, function))
        return future

    def keep(self, opened: Freeable) -> None:
        """Keep it until it is freed, since it must not be collected in another thread."""
        self._open.append(opened)

    def free(self, opened: Freeable) -> None:
        """Free what was kept, later; from any thread, and in a forked process without effect."""
        self.post(lambda: self._free(opened))

    def _free(self, opened: Freeable) -> None:
        if opened in self._open:
            self._open.remove(opened)
            opened.free()

    def stop(self) -> None:
        """End the thread after the picture in progress; what it keeps is left to the operating system."""
        self._jobs.put(None)
        self._thread.join(STOP_TIMEOUT)
        self.abandon()

    def abandon(self) -> None:
        """Leave everything as it is for ever: to free it would fail or hang."""
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self))

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            future, function = job
            with _lock:
                try:
                    future.set_result(function())
                except BaseException as error:  # raised in the thread that called
                    future.set_exception(error)
            del job, future, function  # or what they hold would live until the next picture


_lock = threading.RLock()  # held while something is drawn: a process is forked between two pictures
_thread: RenderThread | None = None


def render_thread() -> RenderThread:
    """The process's render thread, started when it is first needed."""
    global _thread
    with _lock:
        if _thread is None:
            _thread = RenderThread()
        return _thread


def _stop() -> None:
    if _thread is not None:
        _thread.stop()


def _start_anew() -> None:
    """In a forked process, which has none of its parent's threads."""
    global _thread
    if _thread is not None:
        _thread.abandon()
        _thread = None
    forget_contexts()
    _lock.release()


atexit.register(_stop)
os.register_at_fork(before=_lock.acquire, after_in_parent=_lock.release, after_in_child=_start_anew)
