"""What speed costs in accuracy, on six scenes, in demos and at the extremes: writes out/tradeoff.md and its diagrams.

make tradeoff, or python benches/tradeoff.py [FOLDER] [--seconds N]; --only "Stiff cloth" measures that scene alone, and
puts it in its place in the report. docs/tradeoff.md quotes a report; it is edited by hand, and never written here.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

import extremes
import numpy as np

import physcore as pc
from physcore.gallery import caption, demo

DECADES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10)
"""The errors for which the cheapest row is looked for, as fractions of the scene's size."""
QUOTED = Path(__file__).resolve().parents[1] / "docs" / "tradeoff.md"
"""The page that quotes figures of a report."""
SECTION, RULE = "\n\n## ", "|---|" + "---|" * len(DECADES) + "\n"
"""What stands before each section of the report, and before the rows of its tables of advice."""

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
    precisions: tuple[Literal["f32", "f64"], ...] = ("f64", "f32")
    advice: Callable[[pc.Tradeoff], str] | None = None
    """What to choose when, in words, from what was measured."""
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
        (12, 10), 0.05, 2e4, 0.5, mass=0.004, axes=((1.0, 0.0, 0.0), (0.0, 0.5, 0.8660254037844386)), pinned="top"
    )
    scene = pc.Scene(sheet, pc.Gravity((0.0, 0.0, -9.81)), pc.Drag(linear=2e-3))
    about = (
        "A cloth in space, a hundred times as stiff, that swings about its upper edge from 30° off the vertical. "
        "Explicit methods begin at their limit, all others with a step of a 32nd of a second; XPBD is compared by "
        "its substeps, projective dynamics by its iterations, in double precision."
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
    return Study(
        "Stiff cloth", about, scene, 1.0, 0.5, share=2.0, integrators=methods, precisions=("f64",), advice=stiff_advice
    )


def stiff_advice(trade: pc.Tradeoff) -> str:
    """When to take which method, with the rows that say so."""
    ok = [row for row in trade.rows if row.status == "ok"]
    frame = max(row.dt for row in ok)

    def told(integrator: pc.Integrator, dt: float = math.inf) -> str:
        row = next(row for row in ok if row.integrator == integrator and row.dt <= dt)
        return (
            f"{row.label} in steps of {1e3 * row.dt:.2g} ms is off by {1e3 * row.error:.3g} mm, with an energy drift "
            f"of {row.energy_drift:.2g}, and takes {1e3 * row.seconds:.3g} ms"
        )

    return f"""Which method when, for a second of this cloth of half a meter:

- *Where the motion itself is wanted*, explicit methods, as long as their limit can be paid for:
  {told(pc.VelocityVerlet())}; {told(pc.RungeKutta4())}.
  They alone resolve how springs swing. Their limit falls with the root of stiffness over mass: a cloth 100 times as
  stiff takes them ten times as long, while the steps of all others do not depend on it.
- *Where steps are far above that limit, and energy counts*, implicit methods of order 2:
  {told(pc.ImplicitMidpoint(1e-6), 0.5 * frame)}; {told(pc.BDF2(1e-6), 0.5 * frame)}.
  Backward Euler damps the swing itself: {told(pc.BackwardEuler(1e-6), 0.5 * frame)}.
- *For a picture*, XPBD with as many substeps as can be paid for. Its curves lie on each other, so that only the number
  of substeps in a second matters: {told(pc.XPBD(20))}.
  With few of them cloth is soft, and its energy means nothing: {told(pc.XPBD(1))}.
- *Projective dynamics* comes to backward Euler's solution with its iterations, the sooner the shorter the step:
  {told(pc.ProjectiveDynamics(20))}; {told(pc.ProjectiveDynamics(20), 0.15 * frame)}.
  Its matrix is stiff across springs too, where this cloth is not, so that with few iterations in long steps the swing
  is damped more than by backward Euler: {told(pc.ProjectiveDynamics(5))}."""


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
    """Measure everything, or some scenes, and write the report."""
    studies = [kepler(), pendulum(), cloth(), stiff_cloth(), gas(), dam(), *map(demonstration, DEMOS)]
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("out"), help="default: out")
    parser.add_argument("--seconds", type=float, default=420.0, help="for all scenes together (default: 420)")
    parser.add_argument(
        "--only", action="append", metavar="NAME", choices=[study.name for study in studies], help="a scene; repeatable"
    )
    options = parser.parse_args()
    path = options.folder / "tradeoff.md"
    if path.resolve() == QUOTED:
        parser.error(f"{path} is edited by hand: name another folder")
    (options.folder / "images").mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    chosen = [study for study in studies if options.only is None or study.name in options.only]
    whole = sum(study.share for study in studies)
    trades = {study.name: _measured(study, options.seconds * study.share / whole) for study in chosen}
    if options.only is None or not path.exists():
        command = "make tradeoff" if options.only is None else _command(*options.only)
        parts = [_head(next(iter(trades.values())), command), _advice(chosen, trades)]
        parts += [_section(study, trades[study.name], options.folder) for study in chosen]
        if options.only is None:
            print("Extremes …", flush=True)
            parts.append(extremes.table())
        report = "\n\n".join(parts) + "\n"
    else:
        report = path.read_text(encoding="utf-8")
        for study in chosen:
            report = _replaced(report, study, trades[study.name], [each.name for each in studies], options.folder)
    path.write_text(report, encoding="utf-8")
    print(f"{path} written in {time.perf_counter() - begin:.0f} s")


def _measured(study: Study, budget: float) -> pc.Tradeoff:
    print(f"{study.name} …", flush=True)
    return pc.tradeoff(
        study.scene,
        study.duration,
        integrators=study.integrators,
        resolutions=study.resolutions,
        fluids=study.fluids,
        observe=study.observe,
        precisions=study.precisions,
        budget=budget,
        threads=1,
    )


def _command(*names: str) -> str:
    """The command that measures these scenes alone."""
    return " ".join(["python benches/tradeoff.py", *(f'--only "{name}"' for name in names)])


def _head(trade: pc.Tradeoff, command: str) -> str:
    return (
        "# What speed costs in accuracy\n\n"
        f"{_measured_where(trade, command)} Do not edit.\n\n"
        "Every figure is of one call, `pc.tradeoff(scene, duration)`: errors are largest distances from a reference, "
        "times are medians of five whole runs in random order with the audit on, evaluations those of the forces. A "
        "question mark stands behind a time whose median is 5 % above the least of its repetitions."
    )


def _measured_where(trade: pc.Tradeoff, command: str) -> str:
    machine, day = trade.machine, datetime.now(UTC).strftime("%Y-%m-%d")
    return (
        f"Measured on {day} by `{command}`, on one thread of {machine['processor']} "
        f"({machine['vector instructions']}), physcore {machine['physcore']}."
    )


def _advice(studies: list[Study], trades: dict[str, pc.Tradeoff]) -> str:
    """What to choose when: the cheapest row of each scene for each error."""
    head = ["| scene | " + " | ".join(f"{decade:.0e}" for decade in DECADES) + " |", "|---|" + "---|" * len(DECADES)]
    fastest, cheapest = zip(*(_choices(study, trades[study.name]) for study in studies), strict=True)
    lines = ["## What to choose", "", "The fastest row within an error, as a fraction of the scene's size:", ""]
    lines += [*head, *fastest]
    lines += ["", "The same in evaluations of the forces, which no noise of the machine touches:", ""]
    return "\n".join([*lines, *head, *cheapest])


def _choices(study: Study, trade: pc.Tradeoff) -> tuple[str, str]:
    """The lines of a scene in both tables of advice."""
    fastest, cheapest = ([cell(trade, decade * study.size) for decade in DECADES] for cell in (_cell, _cheapest))
    return f"| {study.name} | {' | '.join(fastest)} |", f"| {study.name} | {' | '.join(cheapest)} |"


def _replaced(report: str, study: Study, trade: pc.Tradeoff, names: list[str], folder: Path) -> str:
    """A report with what was found of one scene in its place, among those of all `names`."""
    before = names[: names.index(study.name)]
    head, advice, *sections = report.rstrip("\n").split(SECTION)
    note = _measured_where(trade, _command(study.name))
    new = _section(study, trade, folder, note).removeprefix("## ")
    titles = [section.partition("\n")[0] for section in sections]
    first = next((at for at, title in enumerate(titles) if title not in before), len(sections))
    last = first + (study.name in titles)
    sections[first:last] = [new]
    tables = advice.split(RULE)
    for at, line in enumerate(_choices(study, trade), start=1):
        rows = [row for row in tables[at].split("\n") if not row.startswith(f"| {study.name} |")]
        place = sum(row.startswith(tuple(f"| {name} |" for name in before)) for row in rows)
        tables[at] = "\n".join([*rows[:place], line, *rows[place:]])
    return SECTION.join([head, RULE.join(tables), *sections]) + "\n"


def _cell(trade: pc.Tradeoff, error: float) -> str:
    try:
        row = trade.best(error=error)
    except pc.PhyscoreError:
        return "—"
    at = "" if row.resolution is None else f", 1/{row.resolution:g} m"
    return f"{row.label} {row.precision}{at}, {row.seconds:.2g} s{'?' if row.noisy else ''}"


def _cheapest(trade: pc.Tradeoff, error: float) -> str:
    within = [row for row in trade.rows if row.status == "ok" and row.total_error <= error]
    if not within:
        return "—"
    row = min(within, key=lambda row: row.pair_interactions or row.evaluations)
    return f"{row.label} {row.precision}, {row.evaluations}"


def _section(study: Study, trade: pc.Tradeoff, folder: Path, note: str = "") -> str:
    """One scene: what it is, a note on how it was measured, the figure, what was found, and the table."""
    image = f"images/tradeoff-{study.name.lower().replace(' ', '-')}.png"
    trade.plot(folder / image)
    sentences = "\n".join(f"- {sentence}" for sentence in trade.explain().splitlines())
    advice = "" if study.advice is None else f"{study.advice(trade)}\n\n"
    return (
        f"## {study.name}\n\n{f'{study.about} {study.duration:.3g} s are simulated. {note}'.rstrip()}\n\n"
        f"![Error against time in {study.name}]({image})\n\n{advice}{sentences}\n\n"
        f"<details><summary>Every row</summary>\n\n```\n{trade}\n```\n\n</details>"
    )


if __name__ == "__main__":
    main()
