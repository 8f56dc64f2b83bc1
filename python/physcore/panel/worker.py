"""Thread that does the requests of other threads one by one, and work of its own in between."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

from physcore.errors import PhyscoreError

T = TypeVar("T")


class Worker:
    """Thread that does requests in the order in which they come.

    Args:
        idle: work between two requests; returns the seconds until it is to be called again, or None: after the next
            request.
        daemon: whether the interpreter may end while the thread runs.
    """

    def __init__(self, idle: Callable[[], float | None], *, daemon: bool) -> None:
        self._idle = idle
        self._requests: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._open = True
        self._thread = threading.Thread(target=self._run, name="physcore-panel-physics", daemon=daemon)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def ask(self, job: Callable[[], T]) -> T:
        """Have a job done between two pieces of work, wait for it, and return its result.

        Raises:
            PhyscoreError: the thread has ended.
            Exception: what the job raised.
        """
        if threading.current_thread() is self._thread:
            return job()
        result: T = self.post(job).result()
        return result

    def post(self, job: Callable[[], T]) -> Future[T]:
        """Have a job done, without waiting.

        Raises:
            PhyscoreError: the thread has ended.
        """
        future: Future[T] = Future()
        with self._lock:
            if not self._open:
                raise PhyscoreError("this panel is closed; open another one by pc.live(…)")
            self._requests.put((job, future))
        return future

    def stop(self) -> None:
        """End the thread after all requests so far, and wait for its end unless this is the thread itself."""
        with self._lock:
            if self._open:
                self._open = False
                self._requests.put(None)
        if threading.current_thread() is not self._thread and self._thread.ident is not None:
            self._thread.join()

    def _run(self) -> None:
        wait: float | None = 0.0
        while True:
            try:
                request = self._requests.get(block=wait != 0.0, timeout=wait)
            except queue.Empty:
                wait = self._idle()
                continue
            if request is None:
                return
            _do(*request)
            wait = 0.0


def _do(job: Callable[[], T], future: Future[T]) -> None:
    """Do a job, and pass on its result or its exception."""
    try:
        result = job()
    except BaseException as error:
        future.set_exception(error)
    else:
        future.set_result(result)
