"""Workers of a sweep: an executor of the user's, or processes of this machine."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import Executor, as_completed
from typing import TypeAlias

from physcore.checks import shown
from physcore.errors import PhyscoreError, SceneError, WorkerError
from physcore.studies.sweep.task import Outcome, Task

Work: TypeAlias = Callable[[Task], Outcome]
Finished: TypeAlias = Generator[tuple[int, Outcome], None, None]
"""Numbers of tasks with their outcomes, in the order in which they are finished."""

UNPICKLED = "; build and measure are sent to other processes: define them with def at the top level of a module"


def check_executor(executor: object) -> Executor | None:
    """The executor of a sweep.

    Raises:
        SceneError: the value is no executor.
    """
    if executor is None or isinstance(executor, Executor):
        return executor
    hint = "; write executor=client.get_executor()" if hasattr(executor, "get_executor") else ""
    raise SceneError(f"executor: must be a concurrent.futures.Executor, got {shown(executor)}{hint}")


def finished(executor: Executor, work: Work, tasks: Mapping[int, Task]) -> Finished:
    """Run tasks on an executor. Tasks that have not begun are cancelled at an error.

    Raises:
        WorkerError: the executor failed.
        PhyscoreError: an error that concerns the whole sweep.
    """
    futures = {}
    try:
        for index, task in tasks.items():
            futures[executor.submit(work, task)] = index
        for future in as_completed(list(futures)):
            yield futures.pop(future), future.result()
    except PhyscoreError:
        raise
    except Exception as error:
        raise failed(error) from error
    finally:
        for future in futures:
            future.cancel()


def failed(error: Exception) -> WorkerError:
    """The error of an executor that failed with an exception."""
    words = f"{type(error).__name__}: {error}"
    return WorkerError(f"executor: {words}{UNPICKLED if 'pickle' in words.lower() else ''}")


def cores() -> int:
    """The number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def forks() -> bool:
    """Whether processes are started by a fork, which needs no pickling. Systems on which it is not safe spawn them."""
    return sys.platform.startswith("linux")
