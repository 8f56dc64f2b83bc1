"""Stiff cloth by projections beside Numba, PositionBasedDynamics, Newton and Warp: `python benches/stiff.py`.

Rows say which libraries are not installed: pip install "physcore[bench-cloth]".
"""

from __future__ import annotations

from typing import Any

import numpy as np
from measure import Contender, race, rate, results, table
from rivals.jit import FASTMATH, numba_best
from rivals.pbd_libraries import LIBRARIES, SWEEPS, Newton, installed
from rivals.sweeps import Sheet

import physcore as pc
from physcore.numerics.choices import Precision

SIDE = 100
STEP = 1.0 / 600.0
DTYPES: dict[Precision, type[np.floating[Any]]] = {"f32": np.float32, "f64": np.float64}


def cloth(side: int = SIDE) -> pc.SpringNetwork:
    """A sheet of side² particles with structural, shear and bending springs, in motion, held at two corners."""
    sheet = pc.cloth((side, side), 1.0 / side, 1e4, mass=1e-4, pinned="top corners", axes=((1, 0, 0), (0, 1, 0)))
    x, y = sheet.positions[:, 0], sheet.positions[:, 1]
    velocities = np.stack([0.0 * x, 0.0 * x, 0.3 * np.sin(6.0 * x) * np.cos(5.0 * y)], axis=1) * ~sheet.fixed[:, None]
    return pc.SpringNetwork(
        sheet.positions, sheet.pairs, sheet.stiffness, mass=sheet.mass, fixed=sheet.fixed, velocities=velocities
    )


def ours(integrator: pc.Integrator, precision: Precision, dt: float = STEP, side: int = SIDE) -> pc.Simulation:
    """physcore on one thread; energies and the monitor are on as always."""
    scene = pc.Scene(cloth(side), pc.Gravity((0.0, 0.0, -9.81)))
    return pc.Simulation(scene, integrator, dt=dt, precision=precision, threads=1)


def agree(precision: Precision) -> None:
    """Refuse an opponent that does other work: sweeps in another order of colors part slowly at small steps."""
    simulation, rival = ours(pc.XPBD(1), precision, 1e-4, 20), Sheet(False, cloth(20), DTYPES[precision], 1e-4)
    simulation.step(20)
    rival.step(20)
    moved = np.abs(rival.x - cloth(20).positions).max()
    np.testing.assert_allclose(simulation.positions, rival.x, rtol=0.0, atol=0.02 * moved)


def libraries_agree(library: Any) -> None:
    """The same of another library: Newton's relaxed sweeps over all springs at once are other work, and are not."""
    simulation, rival = ours(pc.XPBD(1, SWEEPS), library.precision, 1e-4, 20), library(cloth(20), 1e-4)
    simulation.step(20)
    rival.step(20)
    moved = np.abs(rival.x - cloth(20).positions).max()
    apart = np.abs(simulation.positions - rival.x).max() / moved
    print(f"{library.name} is {apart:.1%} of the way from physcore after 20 small steps")
    if library is not Newton:
        assert apart < 0.02


def numba(precision: Precision, dt: float, sweeps: int = 1) -> Contender:
    """The fastest version."""
    versions = {kind: (fastmath, 1) for kind, fastmath in FASTMATH.items()}
    return numba_best(lambda fastmath: Sheet(fastmath, cloth(), DTYPES[precision], dt, sweeps).step, versions)


def ten_sweeps(precision: Precision) -> list[Contender]:
    """Steps of ten sweeps, physcore's first."""
    contenders = [Contender("physcore, ten sweeps", ours(pc.XPBD(1, SWEEPS), precision, 10 * STEP).step)]
    contenders.append(numba(precision, 10 * STEP, SWEEPS))
    for library in LIBRARIES:
        if library.precision == precision:
            if there := installed(library):
                libraries_agree(library)
            contenders.append(Contender(library.name, library(cloth(), 10 * STEP).step if there else None))
    return race(contenders)


def main() -> dict[str, float]:
    """Print the tables; give the figures that have targets."""
    figures: dict[str, float] = {}
    springs = len(cloth().pairs)
    for precision in DTYPES:
        if FASTMATH:
            agree(precision)
        contenders = [
            Contender("physcore, one sweep", ours(pc.XPBD(1), precision).step),
            numba(precision, STEP),
            Contender("physcore, projective, ten", ours(pc.ProjectiveDynamics(10), precision, 10 * STEP).step),
        ]
        results(f"Cloth of {SIDE}², {springs} springs, {precision}", "spring-steps", springs, race(contenders))
        sweep, _, projective = (1e-6 / rate(each, 1.0) for each in contenders)
        sweepers = ten_sweeps(precision)
        results(f"Ten sweeps in a step, {precision}", "spring-steps", springs, sweepers)
        ten = 1e-6 / rate(sweepers[0], 1.0)
        figures |= {f"XPBD sweep {precision}": sweep, f"XPBD ten sweeps {precision}": ten}
        figures[f"projective dynamics {precision}"] = projective
        explicit = pc.stability_limit(pc.Scene(cloth(), pc.Gravity((0.0, 0.0, -9.81))), pc.VelocityVerlet())
        implicit = Contender("physcore, backward Euler", ours(pc.BackwardEuler(1e-6), precision, 10 * explicit).step)
        results(f"At ten times the explicit limit, {precision}", "spring-steps", springs, race([implicit]))
        figures[f"implicit step {precision}"] = 1e-6 / rate(implicit, 1.0)
    table("Time of a step [ms]", ("", "figure"), figures.items())
    return figures


if __name__ == "__main__":
    main()
