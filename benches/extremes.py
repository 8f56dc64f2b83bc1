"""What happens at the extremes: each case is run, and holds, is refused with an error, or diverges with a report."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable

import numpy as np
from measure import markdown

import physcore as pc

STEPS = 100_000
LONG = 10_000_000
FACTORS = (0.5, 0.95, 1.0, 1.05, 2.0, 10.0, 100.0)
"""Time steps, as multiples of the limit of stability."""


def table() -> str:
    """Every case as a row of Markdown."""
    rows = ((name, _outcome(case)) for name, case in CASES.items())
    return "\n".join(["## The extremes", "", *markdown(("case", "what happens"), rows)])


def _outcome(case: Callable[[], str]) -> str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = case()
    except pc.SimulationDiverged as error:
        return f"diverges, and says so: {_line(error)}"
    except pc.PhyscoreError as error:
        return f"is refused: {_line(error)}"
    return f"holds: {found}"


def _line(error: Exception) -> str:
    return str(error).replace("\n", " ").replace("|", "¦")


def _drift(run: pc.Simulation, steps: int) -> str:
    """How the energy fares, looked at a hundred times."""
    start = run.energy()
    largest, scale = 0.0, start.kinetic
    for _ in range(100):
        run.step(steps // 100)
        energy = run.energy()
        largest = max(largest, abs(energy.balance - start.balance))
        scale = max(scale, energy.kinetic)
    return f"{steps:.0e} steps, energy off by {largest / scale:.1e} of the motion at most"


def _chain(stiffness: float, masses: list[float], offset: float = 0.0) -> pc.Scene:
    """Springs in a row, the first one pulled."""
    count = len(masses)
    places = np.stack([offset + np.arange(count, dtype=float), np.zeros(count)], axis=1)
    places[0, 0] -= 0.05
    pairs = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    return pc.Scene(pc.SpringNetwork(places, pairs, stiffness, rest_length=1.0, mass=masses))


def _stiff() -> str:
    return _drift(pc.Simulation(_chain(1e8, [1.0] * 8)), STEPS)


def _heavy() -> str:
    return _drift(pc.Simulation(_chain(100.0, [1.0, 1e6] * 4)), STEPS)


def _far(precision: str) -> Callable[[], str]:
    return lambda: _drift(pc.Simulation(_chain(100.0, [1.0] * 8, offset=1e7), precision=precision), STEPS)  # type: ignore[arg-type]


def _at(factor: float) -> Callable[[], str]:
    def run() -> str:
        scene = _chain(100.0, [1.0] * 8)
        limit = pc.stability_limit(scene, pc.VelocityVerlet())
        return _drift(pc.Simulation(scene, pc.VelocityVerlet(), dt=factor * limit), STEPS)

    return run


def _coincident() -> str:
    spring = pc.SpringNetwork([[0.0, 0.0], [0.0, 0.0]], [[0, 1]], 100.0, rest_length=1.0)
    run = pc.Simulation(pc.Scene(spring), dt=1e-3)
    run.step(STEPS)
    return f"a spring without a direction pulls nowhere; after {STEPS:.0e} steps they are at {run.positions.tolist()}"


def _coincident_atoms() -> str:
    atoms = pc.Particles([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]])
    return _drift(pc.Simulation(pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0)), dt=1e-3), STEPS)


def _denormal() -> str:
    tiny = 1e-310
    run = pc.Simulation(pc.Scene(pc.Particles([[tiny, 0.0]], velocities=[[tiny, 0.0]])), dt=0.5)
    run.step(2)
    return f"{tiny:g} m at {tiny:g} m/s is at {run.positions[0, 0]:g} m after a second"


def _light() -> str:
    run = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]], mass=1e-310), pc.Gravity((0.0, -1.0))), dt=0.1)
    run.step(10)
    return f"it falls like others, {run.positions[0, 1]:.3g} m"


def _fast() -> str:
    run = pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]], velocities=[[1e300, 0.0]])), dt=1e10)
    run.step(STEPS)
    return f"it is at {run.positions[0, 0]:g} m"


def _nothing() -> str:
    run = pc.Simulation(pc.Scene(pc.Particles(np.empty((0, 3))), pc.Gravity((0.0, 0.0, -1.0))))
    run.step(10)
    return "nobody falls"


def _not_a_number() -> str:
    pc.Particles([[0.0, math.nan]])
    return "not a number is a place"


def _crowd() -> str:
    atoms = pc.Particles(1e-3 * np.random.default_rng(1).random((2000, 2)), radius=1.0)
    run = pc.Simulation(pc.Scene(atoms, pc.SoftSpheres(stiffness=1e-3)))
    run.step(100)
    return f"all {len(run.positions)} are neighbors of all, and 100 steps are taken"


def _long(integrator: pc.Integrator) -> Callable[[], str]:
    def run() -> str:
        e = 0.6
        planet = pc.Particles([[1.0 - e, 0.0]], velocities=[[0.0, math.sqrt((1.0 + e) / (1.0 - e))]])
        scene = pc.Scene(planet, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))
        return _drift(pc.Simulation(scene, integrator, dt=2.0 * math.pi / 500), LONG)

    return run


CASES: dict[str, Callable[[], str]] = {
    "stiffness 1e8 N/m": _stiff,
    "masses of 1 and 1e6 kg in turn": _heavy,
    "1e7 m from the origin, f64": _far("f64"),
    "1e7 m from the origin, f32": _far("f32"),
    **{f"dt at {factor:g} of the limit, VelocityVerlet": _at(factor) for factor in FACTORS},
    "both ends of a spring in one place": _coincident,
    "two atoms in one place": _coincident_atoms,
    "denormal places and speeds": _denormal,
    "a mass of 1e-310 kg": _light,
    "a speed of 1e300 m/s for 1e15 s": _fast,
    "no particle at all": _nothing,
    "a place that is not a number": _not_a_number,
    "2000 spheres in a thousandth of their radius": _crowd,
    "ten million steps on an ellipse, VelocityVerlet": _long(pc.VelocityVerlet()),
    "ten million steps on an ellipse, PEFRL": _long(pc.PEFRL()),
    "ten million steps on an ellipse, RungeKutta4": _long(pc.RungeKutta4()),
}
