"""Contact of a cloth that is folded on itself: `python benches/self_contact.py`."""

from __future__ import annotations

import math
import time

import numpy as np
from measure import table

import physcore as pc
from physcore.numerics.choices import Precision

SHAPE = (72, 71)
SPACING = 0.02
PLEAT = 11.3
"""Width of a pleat, in units of the spacing: no row of particles lies on a fold."""
STEP = 1.0 / 60.0
STEPS, RUNS = 90, 3
"""Steps of a run, in which the pleats meet, collapse and come to rest; the least time of each step in some runs."""


def folded() -> pc.SpringNetwork:
    """A cloth in pleats askew to its rows, of an opening angle of 24°, whose halves move together with the velocity
    −2 x [m/s] at the distance x [m] from the middle.
    """
    flat = pc.cloth(SHAPE, SPACING, 200.0, 0.02, mass=1e-4, origin=(0.0, 0.0, 0.0))
    across = np.array([math.cos(0.4), math.sin(0.4), 0.0])
    along = np.cross((0.0, 0.0, 1.0), across)
    u, v = flat.positions @ across / (PLEAT * SPACING), flat.positions @ along
    height = np.abs((u % 2.0) - 1.0)
    width, depth = PLEAT * SPACING * math.sin(math.radians(12.0)), PLEAT * SPACING * math.cos(math.radians(12.0))
    points = np.outer(width * u, across) + np.outer(v, along) + np.outer(depth * height, (0.0, 0.0, 1.0))
    inward = -np.outer(2.0 * (u - u.mean()) * width, across)
    return pc.SpringNetwork(
        points,
        flat.pairs,
        flat.stiffness,
        flat.damping,
        flat.rest_length,
        flat.mass,
        velocities=inward,
        faces=flat.faces,
    )


FLOORS: dict[str, tuple[pc.Floor, ...]] = {
    "in free fall": (),
    "on a floor": (pc.Floor(-0.05, friction=0.3, restitution=0.0),),
    "on an elastic floor": (pc.Floor(-0.05, friction=0.3),),
}
"""Where the cloth folds; on an elastic floor it never comes to rest, and its particles bounce many times in a step."""


def ours(precision: Precision, floor: str) -> pc.Simulation:
    """physcore on one thread; energies and the monitor are on as always."""
    cloth = folded()
    items = (pc.Gravity((0.0, 0.0, -9.81)), pc.SelfContact(cloth, SPACING / 4), *FLOORS[floor])
    return pc.Simulation(pc.Scene(cloth, *items), pc.XPBD(1, 10), dt=STEP, precision=precision, threads=1)


def costs(precision: Precision, floor: str) -> np.ndarray:
    """The CPU time of each step [ms]."""
    runs = []
    for _ in range(RUNS):
        simulation, clock = ours(precision, floor), [time.process_time()]
        for _ in range(STEPS):
            simulation.step()
            clock.append(time.process_time())
        runs.append(1e3 * np.diff(clock))
    return np.min(runs, axis=0)


def main() -> dict[str, float]:
    """Print the costs of steps; give the figures that have a target, those of the costliest floor."""
    precisions: tuple[Precision, ...] = ("f64", "f32")
    times = {(floor, precision): costs(precision, floor) for floor in FLOORS for precision in precisions}
    rows = [
        (f"{floor}, {precision}", np.median(each), each.mean(), each.max(), int(each.argmax()) + 1)
        for (floor, precision), each in times.items()
    ]
    title = f"A folded cloth of {len(folded().faces)} triangles, XPBD of ten sweeps at 1/60 s, one thread [ms per step]"
    table(title, ("", "median", "mean", "worst", "its step"), rows)
    return {
        f"self-contact {each}": max(float(np.median(times[floor, each])) for floor in FLOORS) for each in precisions
    }


if __name__ == "__main__":
    main()
