"""What speed costs in accuracy, on six scenes, in demos and at the extremes: writes docs/tradeoff.md and its figures.

make tradeoff, or python benches/tradeoff.py [FOLDER] [--seconds N]
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import extremes
import numpy as np

import physcore as pc
from physcore.gallery import caption, demo

DECADES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
"""The errors for which the cheapest row is looked for, as fractions of the scene's size."""


DEMOS = ("cloth", "rope", "jelly", "orbits")
"""The demos that can be run a hundred times in a minute."""


@dataclass(frozen=True)
class Study:
    """A scene of the report."""

    name: str
    about: str
    scene: pc.Scene | Callable[[float], pc.Scene]
    duration: float
    size: float
    """What errors are a fraction of [m]."""
    resolutions: tuple[float, ...] | None = None
    observe: Callable[[pc.Simulation], np.ndarray] | None = None
    share: float = 1.0
    """Of the budget, beside the others."""
    integrators: tuple[pc.Integrator, ...] | None = None
    """What is compared; None: all explicit ones."""
    fluids: tuple[pc.FluidMethod, ...] | None = None
    """How fluids are computed; None: by default."""


def kepler() -> Study:
    e = 0.6
    planet = pc.Particles([[1.0 - e, 0.0]], velocities=[[0.0, math.sqrt((1.0 + e) / (1.0 - e))]])
    scene = pc.Scene(planet, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0))
    about = "One planet on an ellipse of eccentricity 0.6, ten revolutions from perihelion; G M = a = 1."
    return Study("Kepler", about, scene, 20.0 * math.pi, 1.0)


def pendulum() -> Study:
    bob = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 100.0, fixed=[0])
    about = "A mass on a stiff spring, let go from the horizontal: a fast oscillation on a slow swing."
    return Study("Elastic pendulum", about, pc.Scene(bob, pc.Gravity((0.0, -1.0))), 20.0, 1.0)


def cloth() -> Study:
    sheet = pc.cloth((24, 16), 0.05, 200.0, damping=0.02, mass=0.002, pinned="top")
    scene = pc.Scene(sheet, pc.Gravity((0.0, -9.81)), pc.Drag(linear=2e-4))
    about = "A damped cloth of 384 particles that hangs by its upper edge and is let go: forces depend on velocity."
    return Study("Cloth", about, scene, 1.0, 0.75)


def stiff_cloth() -> Study:
    sheet = pc.cloth(
        (12, 10), 0.05, 2e4, 0.5, mass=0.004, axes=((1.0, 0.0, 0.0), (0.0, 0.5, -0.8660254037844386)), pinned="top"
    )
    scene = pc.Scene(sheet, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(linear=2e-3))
    about = (
        "A cloth a hundred times as stiff, swinging about its upper edge: explicit, implicit and projective methods, "
        "XPBD by its substeps and projective dynamics by its iterations."
    )
    methods = (
        pc.SemiImplicitEuler(),
        pc.VelocityVerlet(),
        pc.RungeKutta4(),
        pc.BackwardEuler(1e-6),
        pc.ImplicitMidpoint(1e-6),
        pc.BDF2(1e-6),
        *(pc.XPBD(substeps) for substeps in (1, 5, 20)),
        *(pc.ProjectiveDynamics(iterations) for iterations in (5, 20)),
    )
    return Study("Stiff cloth", about, scene, 1.0, 0.5, share=2.0, integrators=methods)


def gas() -> Study:
    corner = (8.0, 8.0)
    places = pc.block((0.0, 0.0), corner, 4 / 3)
    velocities = np.random.default_rng(1).normal(size=places.shape)
    atoms = pc.Particles(places, velocities - velocities.mean(axis=0))
    scene = pc.Scene(atoms, pc.LennardJones(epsilon=1.0, sigma=1.0), pc.Periodic((0.0, 0.0), corner))
    about = "36 Lennard-Jones atoms in a periodic square: a hot, dense gas, and chaos."
    return Study("Lennard-Jones gas", about, scene, 10.0, 1.0, share=4.0)


def dam() -> Study:
    def scene(resolution: float) -> pc.Scene:
        spacing = 1.0 / resolution
        water = pc.Fluid(pc.block((0.0, 0.0), (1.0, 2.0), spacing), spacing)
        return pc.Scene(water, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (4.0, 3.0)))

    def middle(simulation: pc.Simulation) -> np.ndarray:
        return simulation.positions.mean(axis=0)

    about = (
        "A column of water collapses; what is compared is its center of mass, with 10, 20 and 40 particles along a "
        "meter. The column of errors has that of the resolution in it."
    )
    return Study("Dam break", about, scene, 0.6, 1.0, (10, 20, 40), middle, share=3.0)


def demonstration(name: str) -> Study:
    """A demo of the gallery."""
    scene = demo(name).scene()
    size = max(float(np.ptp(body.positions, axis=0).max()) for body in scene.bodies)
    method = getattr(demo(name), "METHOD", None)
    fluids = None if method is None else (method,)
    return Study(f"Demo {name}", caption(name), scene, demo(name).DURATION, size or 1.0, fluids=fluids)


def main() -> None:
    """Measure everything and write the report."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("docs"))
    parser.add_argument("--seconds", type=float, default=420.0, help="for all scenes together (default: 420)")
    options = parser.parse_args()
    (options.folder / "images").mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    studies = [kepler(), pendulum(), cloth(), stiff_cloth(), gas(), dam(), *map(demonstration, DEMOS)]
    whole = sum(study.share for study in studies)
    trades = {}
    for study in studies:
        print(f"{study.name} …", flush=True)
        trades[study.name] = pc.tradeoff(
            study.scene,
            study.duration,
            integrators=study.integrators,
            resolutions=study.resolutions,
            fluids=study.fluids,
            observe=study.observe,
            budget=options.seconds * study.share / whole,
            threads=1,
        )
    parts = [_head(next(iter(trades.values()))), _advice(studies, trades)]
    parts += [_section(study, trades[study.name], options.folder) for study in studies]
    print("Extremes …", flush=True)
    parts.append(extremes.table())
    path = options.folder / "tradeoff.md"
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    print(f"{path} written in {time.perf_counter() - begin:.0f} s")


def _head(trade: pc.Tradeoff) -> str:
    machine = trade.machine
    day = datetime.now(UTC).strftime("%Y-%m-%d")
    return (
        "# What speed costs in accuracy\n\n"
        f"Measured on {day} by `make tradeoff`, on one thread of {machine['processor']} "
        f"({machine['vector instructions']}), physcore {machine['physcore']}. Do not edit.\n\n"
        "Every figure is of one call, `pc.tradeoff(scene, duration)`: errors are largest distances from a reference, "
        "times are medians of five whole runs in random order with the audit on, evaluations those of the forces. A "
        "question mark stands behind a time whose median is 5 % above the least of its repetitions."
    )


def _advice(studies: list[Study], trades: dict[str, pc.Tradeoff]) -> str:
    """What to choose when: the cheapest row of each scene for each error."""
    lines = ["## What to choose", "", "The fastest row within an error, as a fraction of the scene's size:", ""]
    lines += ["| scene | " + " | ".join(f"{decade:.0e}" for decade in DECADES) + " |"]
    lines += ["|---|" + "---|" * len(DECADES)]
    for study in studies:
        cells = [_cell(trades[study.name], decade * study.size) for decade in DECADES]
        lines.append(f"| {study.name} | " + " | ".join(cells) + " |")
    lines += ["", "The same in evaluations of the forces, which no noise of the machine touches:", ""]
    lines += ["| scene | " + " | ".join(f"{decade:.0e}" for decade in DECADES) + " |"]
    lines += ["|---|" + "---|" * len(DECADES)]
    for study in studies:
        cells = [_cheapest(trades[study.name], decade * study.size) for decade in DECADES]
        lines.append(f"| {study.name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _cell(trade: pc.Tradeoff, error: float) -> str:
    try:
        row = trade.best(error=error)
    except pc.PhyscoreError:
        return "—"
    at = "" if row.resolution is None else f", 1/{row.resolution:g} m"
    return f"{type(row.integrator).__name__} {row.precision}{at}, {row.seconds:.2g} s{'?' if row.noisy else ''}"


def _cheapest(trade: pc.Tradeoff, error: float) -> str:
    within = [row for row in trade.rows if row.status == "ok" and row.total_error <= error]
    if not within:
        return "—"
    row = min(within, key=lambda row: row.pair_interactions or row.evaluations)
    return f"{type(row.integrator).__name__} {row.precision}, {row.evaluations}"


def _section(study: Study, trade: pc.Tradeoff, folder: Path) -> str:
    """One scene: what it is, the figure, what was found, and the table."""
    image = f"images/tradeoff-{study.name.lower().replace(' ', '-')}.png"
    trade.plot(folder / image)
    sentences = "\n".join(f"- {sentence}" for sentence in trade.explain().splitlines())
    return (
        f"## {study.name}\n\n{study.about} {study.duration:.3g} s are simulated.\n\n"
        f"![Error against time in {study.name}]({image})\n\n{sentences}\n\n"
        f"<details><summary>Every row</summary>\n\n```\n{trade}\n```\n\n</details>"
    )


if __name__ == "__main__":
    main()
