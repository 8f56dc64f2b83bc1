"""Temporary storage of simulated frames between two passes, if reading is faster than a second simulation."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from typing import IO, Any

import numpy as np

from physcore.checks import FloatArray
from physcore.simulation.energy import Energy
from physcore.simulation.sources import Source, SourceFrame

SHARE = 0.25
"""Largest fraction of the free disk that the frames may take."""
TRIAL = 0.05
"""Time after which the durations of simulating and of writing are compared [s]."""
TERMS = ("by_term", "dissipated_by")
NUMBERS = ("kinetic", "internal", "dissipated", "work", "time")
"""Names of the parts of an energy budget."""


class FrameCache:
    """The frames of a source, written to an unnamed file in the first pass and read back in later ones.

    Every number is stored exactly, so that both ways give films with the same bytes. The source is simulated again if
    writing and reading take longer than simulating. The same holds if the frames would take more than a quarter of the
    free disk, or if writing fails.

    Args:
        source: the source of the frames.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._file: IO[bytes] | None = None
        self._layout: list[tuple[str, tuple[int, ...]]] = []
        self._terms: dict[str, list[str]] = {}
        self.whole = False
        """Whether all frames are in the file."""

    def first(self) -> Iterator[SourceFrame]:
        """All frames from the source, written to the file as long as this is faster than a second simulation."""
        simulated = written = 0.0
        last = time.perf_counter()
        for index, frame in enumerate(self._source.frames()):
            now = time.perf_counter()
            simulated += now - last
            if index == 0:
                self._open(frame)
            if self._file is not None:
                self._write(frame)
                written += time.perf_counter() - now
                # Factor 2: the frames are read back too.
                if simulated + written > TRIAL and 2.0 * written > simulated:
                    self.close()
            yield frame
            last = time.perf_counter()
        if self._file is not None:
            try:
                self._file.flush()
                self.whole = True
            except OSError:
                self.close()

    def again(self) -> Iterator[SourceFrame]:
        """All frames a second time, from the file or from the source."""
        read = 0
        if self.whole and self._file is not None:
            self._file.seek(0)
            for _ in range(self._source.count):
                frame = self._read(self._file)
                if frame is None:  # the file was truncated by another program
                    break
                yield frame
                read += 1
        if read < self._source.count:
            yield from islice(self._source.frames(), read, None)

    def close(self) -> None:
        """Delete the file."""
        self.whole = False
        if self._file is not None:
            file, self._file = self._file, None
            with suppress(OSError):  # closing writes the buffer, which fails again on a full disk
                file.close()

    def _open(self, frame: SourceFrame) -> None:
        """Open the file, if there is room for `count` frames like this one."""
        import shutil  # the import of these two takes longer than that of the rest of film
        import tempfile

        self._layout = [(name, values.shape) for name, values in frame.fields.items()]
        self._terms = {name: list(getattr(frame.energy, name, ())) for name in TERMS}
        with suppress(OSError):
            needed = self._source.count * sum(part.nbytes for part in self._parts(frame))
            if needed <= SHARE * shutil.disk_usage(tempfile.gettempdir()).free:
                self._file = tempfile.TemporaryFile(prefix="physcore-", buffering=1 << 20)  # noqa: SIM115 - see close

    def _parts(self, frame: SourceFrame) -> list[FloatArray]:
        """All numbers of a frame."""
        arrays = [frame.fields[name] for name, _ in self._layout]
        assert frame.energy is not None  # frames of a simulation have energies
        numbers = [getattr(frame.energy, name) for name in NUMBERS]
        numbers += [getattr(frame.energy, kind)[name] for kind in TERMS for name in self._terms[kind]]
        return [np.array([frame.time, frame.dt, *numbers]), *arrays]

    def _write(self, frame: SourceFrame) -> None:
        assert self._file is not None  # the caller has checked this
        try:
            for part in self._parts(frame):
                self._file.write(np.ascontiguousarray(part, dtype=np.float64).data)
        except OSError:
            self.close()

    def _read(self, file: IO[bytes]) -> SourceFrame | None:
        """The next frame; None at an early end of the file."""
        names = [(kind, name) for kind in TERMS for name in self._terms[kind]]
        shapes = [(2 + len(NUMBERS) + len(names),), *(shape for _, shape in self._layout)]
        parts = [np.empty(shape) for shape in shapes]
        for part in parts:
            if part.size and file.readinto(part.data.cast("B")) != part.nbytes:  # type: ignore[attr-defined]
                return None
        (when, dt, *numbers), *rest = parts
        values = [float(value) for value in numbers]
        budget: dict[str, Any] = dict(zip(NUMBERS, values, strict=False)) | {kind: {} for kind in TERMS}
        for (kind, name), value in zip(names, values[len(NUMBERS) :], strict=True):
            budget[kind][name] = value
        fields = {name: part for (name, _), part in zip(self._layout, rest, strict=True)}
        return SourceFrame(float(when), fields, Energy(**budget), float(dt))
