"""Processes of this machine that run the tasks of a sweep.

A process that dies is replaced, and the task that it had fails. Processes end with their caller, also when it is
killed. Those of `concurrent.futures` would wait forever then.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import warnings
from collections.abc import Mapping
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Self

from physcore.errors import PhyscoreError, WorkerError
from physcore.studies.sweep.task import Failure, Outcome, Task
from physcore.studies.sweep.workers import Finished, Work, cores, failed, forks

THREADS = "PHYSCORE_NUM_THREADS"
"""Environment variable with the number of threads of simulations."""
GUARD = '; a script that starts processes needs `if __name__ == "__main__":` on this system'
KILLED = 9
"""SIGKILL, by which Linux ends processes when memory is exhausted."""

PATIENCE = 5.0
"""Time for a process to end after it has closed its connection [s]."""


class Team:
    """As many processes as this process may use cores, or PHYSCORE_NUM_THREADS if that is set.

    Args:
        work: the function of a task.
        tasks: the tasks by their numbers.

    Raises:
        WorkerError: no process can be started.
    """

    def __init__(self, work: Work, tasks: Mapping[int, Task]) -> None:
        self._context = multiprocessing.get_context("fork" if forks() else "spawn")
        self._work, self._tasks = work, tasks
        self._waiting = list(tasks)[::-1]
        self._workers: list[_Worker] = []
        given = os.environ.get(THREADS, "")
        threads = int(given) if given.isdecimal() and int(given) > 0 else cores()
        self._count = min(threads, len(tasks))
        self._threads = max(1, threads // max(1, self._count))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for worker in self._workers:
            worker.end()

    def finished(self) -> Finished:
        """The outcomes of all tasks.

        Raises:
            PhyscoreError: an error that concerns the whole sweep.
        """
        for _ in range(self._count):
            self._add()
        while self._workers:
            for connection in wait([each.connection for each in self._workers]):
                worker = next(each for each in self._workers if each.connection is connection)
                index = worker.task
                outcome = self._heard(worker)
                if isinstance(outcome, PhyscoreError):
                    raise outcome
                if index is not None and outcome is not None:
                    yield index, outcome

    def _heard(self, worker: _Worker) -> Outcome | PhyscoreError | None:
        """A message of a worker, which receives the next task. A dead worker is replaced."""
        try:
            outcome = worker.take()
        except EOFError:
            self._workers.remove(worker)
            worker.end(PATIENCE)
            if not worker.ready:
                return WorkerError(f"executor: no process can be started: one {worker.cause}{GUARD}")
            if self._waiting:
                self._add()
            return Outcome(failure=Failure.of(WorkerError(f"the process {worker.cause} during this point")))
        if self._waiting:
            worker.give(self._waiting.pop())
        else:
            self._workers.remove(worker)
            worker.end()
        return outcome

    def _add(self) -> None:
        """Start a process.

        Raises:
            WorkerError: it cannot be sent what it needs.
        """
        own, end = self._context.Pipe()
        # A fork copies all open connections, at whose other ends processes would otherwise wait.
        inherited = [own, *(each.connection for each in self._workers)] if forks() else []
        arguments = (self._work, self._tasks, end, inherited, self._threads)
        process = self._context.Process(target=_serve, args=arguments, daemon=True)  # type: ignore[attr-defined]
        try:
            with warnings.catch_warnings():
                # Python warns of forks beside threads. The engine starts its threads anew after a fork.
                warnings.simplefilter("ignore", DeprecationWarning)
                process.start()
        except Exception as error:  # What cannot be pickled, or a process that may not start others.
            raise failed(error) from error
        end.close()
        self._workers.append(_Worker(process, own))


class _Worker:
    """Process that runs one task at a time."""

    def __init__(self, process: BaseProcess, connection: Connection) -> None:
        self._process, self.connection = process, connection
        self.task: int | None = None
        """Number of its task."""
        self.ready = False
        """Whether the process has begun to serve."""

    def give(self, index: int) -> None:
        """Give the worker a task. If the process is dead, `take` tells."""
        self.task = index
        with suppress(OSError):
            self.connection.send(index)

    def take(self) -> Outcome | PhyscoreError | None:
        """The outcome of the task, or an error that concerns the whole sweep; None when the process begins.

        Raises:
            EOFError: the process died.
        """
        try:
            found: Outcome | PhyscoreError | None = self.connection.recv()
        except OSError as error:
            raise EOFError from error
        self.ready, self.task = True, None
        return found

    def end(self, patience: float = 0.0) -> None:
        """Kill the process if it does not end by itself within a time [s], and wait for its end."""
        self.connection.close()
        self._process.join(patience)
        self._process.kill()
        self._process.join()

    @property
    def cause(self) -> str:
        """A phrase on the end of the process."""
        code = self._process.exitcode or 0
        if code >= 0:
            return f"ended with exit code {code}"
        advice = ", as the system does when memory is exhausted" if -code == KILLED else ""
        return f"was killed by signal {-code}{advice}"


def _serve(
    work: Work, tasks: Mapping[int, Task], connection: Connection, inherited: list[Connection], threads: int
) -> None:
    """The main function of a process: runs the tasks whose numbers it receives, and sends their outcomes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes; the caller ends this one.
    for each in inherited:
        each.close()
    _end_with_caller()
    os.environ[THREADS] = str(threads)
    connection.send(None)
    while True:
        try:
            index = connection.recv()
        except (EOFError, OSError):
            return
        try:
            found: Outcome | PhyscoreError = work(tasks[index])
        except PhyscoreError as error:
            found = error
        connection.send(found)


def _end_with_caller() -> None:
    """End this process when its caller ends, however it does."""
    caller = multiprocessing.parent_process()
    assert caller is not None
    sentinel = caller.sentinel

    def watch() -> None:
        wait([sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
