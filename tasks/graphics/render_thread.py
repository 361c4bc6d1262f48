"""One thread of a process for all of its pictures: an OpenGL context belongs to one thread, and to one process.

Any thread may draw, and no thread's own context is touched. A forked process starts a thread of its own.
"""

import atexit
import ctypes
import os
import threading
from collections.abc import Callable
from concurrent import futures
from queue import SimpleQueue
from typing import Any, TypeVar

from tasks.errors import TaskError
from tasks.graphics.gl_context import forget_contexts

T = TypeVar("T")

STOP_TIMEOUT = 10.0  # s that the interpreter's exit waits for a picture in progress


class RenderThread(threading.Thread):
    """Runs functions one after the other, until the interpreter exits.

    Attributes:
        kept: contexts in use, which must not be collected in another thread.
    """

    def __init__(self) -> None:
        super().__init__(name="asddpg-render", daemon=True)
        self.kept: list[Any] = []
        self._jobs: SimpleQueue[tuple[futures.Future[Any], Callable[[], Any]] | None] = SimpleQueue()
        self.start()

    def run(self) -> None:
        """Work in the thread."""
        while (job := self._jobs.get()) is not None:
            future, function = job
            with _lock:
                try:
                    future.set_result(function())
                except BaseException as error:  # raised in the thread that called
                    future.set_exception(error)
            del job, future, function  # or what they hold would live until the next picture

    def call(self, function: Callable[[], T]) -> T:
        """What the function returns or raises in the thread; TaskError while the interpreter exits."""
        if threading.current_thread() is self:
            return function()
        if not self.is_alive():
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

    def abandon(self) -> None:
        """End the thread; what it keeps is left to the operating system, since to free it now would fail or hang."""
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self))
        self._jobs.put(None)


_lock = threading.RLock()  # held while something is drawn: a process is forked between two pictures
_thread: RenderThread | None = None


def render_thread() -> RenderThread:
    """The process's render thread, started when it is first needed."""
    global _thread
    with _lock:
        _thread = _thread or RenderThread()
        return _thread


def _stop() -> None:
    if _thread is not None:
        _thread.abandon()
        _thread.join(STOP_TIMEOUT)


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
