"""How everything here is measured.

Opponents take turns in one process, because the speed of a machine wanders: only ratios within one race mean much.
Each turn is timed by two clocks. The wall clock says how long somebody waits. The clock of CPU time, which all threads
of the process add to, says what the work costs, and does not count the time in which other programs had the processor;
so it is the better judge of work on one thread where the machine is not idle.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain
from math import isnan, nan
from pathlib import Path
from statistics import median

REPETITIONS = 7
SECONDS = 0.25
"""How long one turn takes, about."""
BOTH = 1.7
"""Processors that two threads must have had, on average, for their speed to mean anything."""
NOISE = 0.05
"""Spread (median above minimum) from which a reading is marked as noisy."""


@dataclass
class Contender:
    """One way to do the work, and how long its turns took."""

    name: str
    step: Callable[[int], object] | None
    """Takes a number of steps, a multiple of `multiple`; None where the opponent cannot be imported."""
    threads: int = 1
    multiple: int = 1
    steps: int = 0
    wall: list[float] = field(default_factory=list)
    """Seconds per step of each turn."""
    cpu: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.step is None:
            self.name, self.wall, self.cpu = f"{self.name}, not installed", [nan], [nan]

    def calibrate(self) -> None:
        """Warm up (compilers, caches), and find how many steps make a turn."""
        self.step(self.multiple)
        steps, taken = self.multiple, 0.0
        while taken < SECONDS / 5:
            steps *= 2
            taken = self._time(steps)[1]
        self.steps = max(1, round(steps * SECONDS / taken / self.multiple)) * self.multiple

    def turn(self) -> None:
        """Take one turn."""
        wall, cpu = self._time(self.steps)
        self.wall.append(wall / self.steps)
        self.cpu.append(cpu / self.steps)

    def _time(self, steps: int) -> tuple[float, float]:
        wall, cpu = time.perf_counter(), time.process_time()
        self.step(steps)
        return time.perf_counter() - wall, time.process_time() - cpu

    @property
    def noise(self) -> float:
        """By how much the median turn took longer than the fastest, of the CPU's time."""
        return median(self.cpu) / min(self.cpu) - 1.0


def race(contenders: list[Contender], repetitions: int = REPETITIONS) -> list[Contender]:
    """Let all take turns that are installed; give all."""
    racing = [contender for contender in contenders if contender.step]
    for contender in racing:
        contender.calibrate()
    for _ in range(repetitions):
        for contender in racing:
            contender.turn()
    return contenders


def fastest(variants: list[Contender]) -> Contender:
    """The best of several versions of the same opponent, found in a short race; its readings are discarded."""
    if len(variants) == 1:
        return variants[0]
    race(variants, repetitions=3)
    best = min(variants, key=lambda variant: min(variant.cpu))
    return Contender(best.name, best.step, best.threads, best.multiple)


def cell(value: object) -> str:
    """Text of a table: four digits of figures, and a dash for those that are missing."""
    if isinstance(value, str | int):
        return str(value)
    return "—" if isnan(value) else f"{value:.0f}" if abs(value) >= 1e4 else f"{value:.4g}"


def markdown(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> Iterator[str]:
    """Lines of a table, each as soon as its row is there."""
    widths = [40, *(max(len(column), 8) for column in columns[1:])]
    for row in chain([columns, ["-" * width for width in widths]], rows):
        sides = ("<" if isinstance(value, str) else ">" for value in row)
        cells = (f"{cell(value):{side}{width}}" for value, side, width in zip(row, sides, widths, strict=True))
        yield f"| {' | '.join(cells)} |"


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table in Markdown, row by row as they come."""
    for line in chain([f"\n{title}\n"], markdown(columns, rows)):
        print(line, flush=True)


def judge(title: str, rows: Iterable[tuple[str, float, float, bool]]) -> None:
    """Print targets beside figures; each row has a name, both of them, and whether the target is an upper bound."""

    def judged(name: str, target: float, found: float, at_most: bool) -> tuple[object, ...]:
        sign, met = ("≤", found <= target) if at_most else ("≥", found >= target)
        verdict = "not measured" if isnan(found) else "met" if met else "missed"
        part = f": {found / target:.2f} of it" if verdict == "missed" and target else ""
        return name, f"{sign} {cell(target)}", found, verdict + part

    table(title, ("", "target", "measured", "verdict"), (judged(*row) for row in rows))


def results(title: str, unit: str, work: float, contenders: list[Contender]) -> list[Contender]:
    """Print the rates of a race: `work` units per step, in millions per second; the first line is physcore's."""
    ours = {one.threads: median(one.cpu) for one in reversed(contenders) if one.name.startswith("physcore")}

    def row(one: Contender) -> tuple[object, ...]:
        times = (summary(clock) for clock in (one.wall, one.cpu) for summary in (median, min))
        mark = f"noisy: {one.noise:.0%}" if one.noise > NOISE else ""
        return one.name, one.threads, *(work / time / 1e6 for time in times), median(one.cpu) / ours[one.threads], mark

    clocks = ("wall clock, median", "best", "per CPU second, median", "best")
    columns = ("", "threads", *clocks, "physcore is [times, CPU]", "")
    table(f"{title} [million {unit}/s]", columns, map(row, contenders))
    return contenders


def rate(contender: Contender, work: float) -> float:
    """Units of work per CPU second, in billions: the median."""
    return work / median(contender.cpu) / 1e9


def speedup(contenders: Sequence[Contender]) -> float:
    """physcore on two threads over physcore on one, from the fastest turns on the wall clock.

    Not a number where other programs left it less than most of two processors.
    """
    one, two = (next(c for c in contenders if c.name == "physcore" and c.threads == threads) for threads in (1, 2))
    fastest_turn = min(range(len(two.wall)), key=two.wall.__getitem__)
    return min(one.wall) / two.wall[fastest_turn] if two.cpu[fastest_turn] > BOTH * two.wall[fastest_turn] else nan


def machine(simd: str) -> str:
    """What this runs on."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        models = [line.partition(":")[2].strip() for line in cpuinfo.read_text().splitlines() if "model name" in line]
        model = models[0] if models else model
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    load = os.getloadavg()[0]
    busy = " (busy with other work: trust the CPU's time)" if load > 0.5 else ""
    return f"{model}, {cores} cores, {simd}; load {load:.1f}{busy}"
