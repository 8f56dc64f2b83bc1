"""The function `sweep`: builds, simulates and measures every point of a grid of parameters."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import replace
from typing import Any, Unpack, cast

from physcore.checks import flag, shown, span
from physcore.entrance import entrance
from physcore.errors import FileError, SceneError, SceneWarning, WorkerError, warn
from physcore.numerics.choices import FRAMES_PER_SECOND, Options, require_options
from physcore.progress import Progress
from physcore.scene.scene import Scene
from physcore.simulation.cache import FREE, check_key
from physcore.simulation.provenance import version
from physcore.simulation.recording import Recording
from physcore.storage.archive import Tree
from physcore.storage.identity import identity
from physcore.studies.sweep.folder import Folder
from physcore.studies.sweep.grid import ParameterGrid
from physcore.studies.sweep.result import SweepRow
from physcore.studies.sweep.table import Sweep
from physcore.studies.sweep.task import Outcome, Task, compute, identify
from physcore.studies.sweep.team import Team
from physcore.studies.sweep.workers import Finished, Work, check_executor, finished


@entrance
def sweep(
    build: Callable[..., Scene],
    parameters: Mapping[str, Any],
    duration: float,
    *,
    measure: Callable[[Recording], Any] | None = None,
    executor: Executor | None = None,
    folder: str | os.PathLike[str] | None = None,
    keep: bool = False,
    fps: float = FRAMES_PER_SECOND,
    channels: tuple[str, ...] | None = None,
    key: str | None = None,
    progress: bool | None = True,
    **numerics: Unpack[Options],
) -> Sweep:
    """Simulate a scene for every combination of some parameters, and measure each recording.

        table = pc.sweep(
            lambda pull: pc.Scene(cloth, pc.Gravity((0.0, -pull))),
            {"pull": [5.0, 10.0], "dt": [1e-3, 2e-3]},
            duration=0.1,
            measure=lambda recording: recording.positions.min(),
        )
        table.best().parameters

    A point that fails is a row with its exception. With a folder, each finished point is kept in a file, which is
    written as a whole. After Ctrl-C or a kill, the same call computes the other points only. Diverged points are kept
    too, and other failed points are tried again. See docs/sweeps.md, also for clusters.

    A folder belongs to one sweep. It is recognized by parameters, duration, numerics, fps, channels, the version of
    physcore, the scene of each point, and the source of `measure`.

    Args:
        build: function that returns the scene for some parameters, which are its arguments.
        parameters: the values of each parameter by name. Names that `build` does not take are numerical choices, such
            as "dt" or "integrator".
        duration: the simulated duration of each point [s].
        measure: function of the recording that gives the value of a row: a number, or texts, arrays, lists and mappings
            of these. None: nothing, which needs keep=True.
        executor: a `concurrent.futures.Executor`, such as those of processes, threads, loky, dask or MPI. None: as many
            processes as there are cores, each with one thread.
        folder: a folder for the files, which is created if necessary.
        keep: whether to keep the recordings, for `row.recording` and `Sweep.film`: in the folder, or in memory.
        fps: frames per second of simulated time of the recordings.
        channels: the recorded fields, as in `simulate`.
        key: a text that stands for the functions of scenes, as in `simulate`.
        progress: whether to show a progress bar; None: on a terminal, after one second.
        numerics: numerical choices of all points, as in Simulation.

    Raises:
        SceneError: an argument is not valid, or the folder belongs to another sweep. Nothing is then changed in it.
        FileError: a file cannot be written.
        WorkerError: the executor failed. The error has the rows so far, and the folder the files of these.
        KeyboardInterrupt: Ctrl-C. The files of the finished points remain.

    Warns:
        FileWarning: a file of the folder is damaged, and its point is computed anew.
        SceneWarning: every point failed.
    """
    require_options(numerics, "sweep")
    grid = ParameterGrid.of(build, parameters, numerics)
    pool, shown_bar = check_executor(executor), None if progress is None else flag(progress, "progress")
    kept, name = flag(keep, "keep"), check_key(key, used=folder is not None)
    if measure is not None and not callable(measure):
        raise SceneError(f"measure: must be a function of a recording, got {shown(measure)}")
    if measure is None and not kept:
        raise SceneError("measure: give a function of the recording, or keep=True")
    lengths = {"duration": span(duration, "duration", empty=True), "fps": span(fps, "fps")}
    tasks = [
        Task(
            build=build,
            measure=measure,
            arguments={each: value for each, value in point.items() if each in grid.built},
            numerics=cast(Options, {**numerics, **{each: point[each] for each in point if each not in grid.built}}),
            channels=channels,
            keep=kept,
            filed=folder is not None,
            key=name,
            **lengths,
        )
        for point in grid.points()
    ]
    about = {**lengths, "channels": channels, "keep": kept, "key": name, "measure": measure}
    own = None if folder is None else Folder.opened(folder, _content(grid, about, numerics), len(tasks))
    return _Run(grid.points(), tasks, pool, own, lengths["duration"], shown_bar).table()


def _content(grid: ParameterGrid, about: Mapping[str, Any], numerics: Options) -> dict[str, Tree]:
    """The description of a sweep, as values for JSON.

    Raises:
        SceneError: a part of it cannot be recognized in another process.
    """
    return {
        "physcore": version(),
        "order": list(grid.axes),
        "parameters": {name: identity(values, f"parameters[{name!r}]") for name, values in grid.axes.items()},
        **{name: identity(each, name) for name, each in about.items()},
        "numerics": {name: identity(each, name) for name, each in sorted(numerics.items()) if name not in FREE},
    }


class _Run:
    """A sweep while it is computed."""

    def __init__(
        self,
        points: list[dict[str, Any]],
        tasks: list[Task],
        pool: Executor | None,
        folder: Folder | None,
        duration: float,
        progress: bool | None,
    ) -> None:
        self._points, self._tasks, self._pool = points, tasks, pool
        self._folder, self._duration, self._progress = folder, duration, progress
        self._outcomes: dict[int, Outcome] = {}

    def table(self) -> Sweep:
        """The table, after all points are computed."""
        with Progress(len(self._tasks), "sweeping", self._progress) as bar:
            try:
                if self._folder is not None:
                    self._resume(self._folder)
                missing = [index for index in range(len(self._tasks)) if index not in self._outcomes]
                bar.update(len(self._outcomes))
                with closing(self._finished(compute, missing)) as found:
                    for index, outcome in found:
                        self._add(index, outcome)
                        bar.update(len(self._outcomes))
            except WorkerError as error:
                raise WorkerError(f"{error}; {self._so_far}", table=self._rows()) from error.__cause__
            except (FileError, KeyboardInterrupt) as error:
                error.add_note(f"sweep: {self._so_far}")
                raise
        table = self._rows()
        assert table is not None
        if len(table.failed) == len(table):
            warn(f"sweep: every point failed, the first one with {table[0]}", SceneWarning)
        return table

    def _resume(self, folder: Folder) -> None:
        """Find the points of the folder that need not be computed again. Their scenes are built, and compared.

        Raises:
            SceneError: a file is that of another scene.
        """
        present = folder.present(len(self._tasks))
        with closing(self._finished(identify, list(present))) as found:
            for index, now in found:
                before = present[index]
                if before.scene is not None and now.scene != before.scene:
                    cause = "another scene" if now.failure is None else f"an error: {now.failure.exception()}"
                    raise SceneError(
                        f"folder: {folder.file(index)} belongs to another sweep: build gives {cause}; take another "
                        "folder, and if build takes random numbers, give it a seed"
                    )
                failed_again = before.scene is None and now.failure is not None
                if before.failure is None or before.failure.lasting or failed_again:
                    self._outcomes[index] = before

    def _finished(self, work: Work, indices: list[int]) -> Finished:
        """The outcomes of some tasks, in the order in which they are finished."""
        tasks = {index: self._tasks[index] for index in indices}
        if not tasks:
            return
        if self._pool is not None:
            yield from finished(self._pool, work, tasks)
            return
        with Team(work, tasks) as team:
            yield from team.finished()

    def _add(self, index: int, outcome: Outcome) -> None:
        """Keep the outcome of a point, in the folder if there is one."""
        if self._folder is not None:
            self._folder.write(index, outcome)
            outcome = replace(outcome, recording=None)
        self._outcomes[index] = outcome

    def _rows(self) -> Sweep | None:
        """The table of the points so far; None if there are none."""
        rows = tuple(self._row(index, outcome) for index, outcome in sorted(self._outcomes.items()))
        return Sweep(rows, self._duration) if rows else None

    def _row(self, index: int, outcome: Outcome) -> SweepRow:
        error = None if outcome.failure is None else outcome.failure.exception()
        row = SweepRow(self._points[index], outcome.value, error, outcome.seconds)
        task = self._tasks[index]
        if not task.keep or error is not None:
            return row
        return replace(row, task=task, kept=outcome if self._folder is None else (self._folder, index))

    @property
    def _so_far(self) -> str:
        """A phrase on the points that are finished."""
        done = f"{len(self._outcomes)} of {len(self._tasks)} points are finished"
        return done if self._folder is None else f"{done}, and the next call goes on from {self._folder.path}"
