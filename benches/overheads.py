"""What is not the work itself: the import, the audit, the way from Python: `python benches/overheads.py`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from statistics import median

from measure import Contender, race, table
from particles import COUNT, STEP, falling
from springs import GRAVITY, LARGE, SMALL, grid

import physcore as pc

IMPORTS = 7
PROBE = (
    "import time, numpy; wall, cpu = time.perf_counter(), time.process_time(); import physcore; "
    "print(time.perf_counter() - wall, time.process_time() - cpu)"
)
EVERY = 100
"""Steps from one reading of the energy to the next."""


def importing() -> tuple[float, float]:
    """What `import physcore` takes once NumPy is there [s]: wall and CPU, the medians of fresh processes."""
    readings = []
    for _ in range(IMPORTS + 1):
        answer = subprocess.run([sys.executable, "-c", PROBE], capture_output=True, text=True, check=True).stdout
        readings.append([float(number) for number in answer.split()])
    wall, cpu = zip(*readings[1:], strict=True)  # The first one warms the file cache.
    return median(wall), median(cpu)


def audited(scene: pc.Scene) -> tuple[float, float]:
    """What reading the energy every so many steps adds to a run, as a fraction, and the noise of that fraction."""
    plain, read = (pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, threads=1) for _ in range(2))

    def with_readings(steps: int) -> None:
        for _ in range(steps // EVERY):
            read.step(EVERY)
            read.energy()

    def without(steps: int) -> None:
        for _ in range(steps // EVERY):
            plain.step(EVERY)

    pair = [Contender("plain", without, 1, EVERY), Contender("read", with_readings, 1, EVERY)]
    race(pair)
    return median(pair[1].cpu) / median(pair[0].cpu) - 1.0, max(one.noise for one in pair)


def per_call(scene: pc.Scene) -> float:
    """What `step(1)` costs beyond a step of a long call [s]."""
    single, long = (pc.Simulation(scene, pc.VelocityVerlet(), dt=STEP, threads=1) for _ in range(2))
    pair = [Contender("one by one", _repeat(lambda: single.step())), Contender("in one call", long.step)]
    race(pair)
    return median(pair[0].cpu) - median(pair[1].cpu)


def _repeat(once: Callable[[], object]) -> Callable[[int], None]:
    def run(steps: int) -> None:
        for _ in range(steps):
            once()

    return run


def main() -> dict[str, float]:
    """Print the overheads; give the figure that has a target."""
    wall, cpu = importing()
    large, small = (pc.Scene(grid(shape), pc.Gravity((0.0, GRAVITY))) for shape in (LARGE, SMALL))
    title = "Overheads; meters of dissipated energy and the check for divergence are always on, and in all figures"
    rows = [
        ("import physcore beyond NumPy, wall clock [s]", wall, ""),
        ("import physcore beyond NumPy, CPU [s]", cpu, ""),
        (f"energy() every {EVERY} steps, {COUNT:.0e} particles [share of CPU time]", *audited(falling(COUNT))),
        (f"energy() every {EVERY} steps, 316×316 cloth [share of CPU time]", *audited(large)),
        ("step(1) on the 15×10 cloth, beyond a step of a long call [µs]", 1e6 * per_call(small), ""),
    ]
    table(title, ("", "figure", "noise"), rows)
    return {"import": cpu}


if __name__ == "__main__":
    main()
