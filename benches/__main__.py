"""Every speed that physcore promises, beside NumPy, Numba and others in one run: `make bench`, or `python benches`."""

from __future__ import annotations

import os

# One thread for each opponent that does not say otherwise; read when NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from dataclasses import dataclass

import accuracy
import charges
import fluids
import gravitation
import hardware
import numpy as np
import overheads
import particles
import reactions
import rigid
import rods
import self_contact
import springs
import stiff
import tracers
import wave_functions
import waves
from measure import cell, judge, machine
from rivals.jit import clock, numba

import film
import physcore as pc


@dataclass(frozen=True)
class Target:
    """A promise: at least, or at most, so much."""

    figure: str
    bound: float
    unit: str
    at_most: bool = False


TARGETS = (
    Target("Verlet f64", 1.1, "G particle-steps/s"),
    Target("Verlet f32", 2.2, "G particle-steps/s"),
    Target("RK4 f64", 0.16, "G particle-steps/s"),
    Target("RK4 f32", 0.38, "G particle-steps/s"),
    Target("grid f64", 0.3, "G spring-updates/s"),
    Target("grid f32", 0.6, "G spring-updates/s"),
    Target("network f64", 0.13, "G spring-updates/s"),
    Target("network f32", 0.24, "G spring-updates/s"),
    Target("small cloth f32", 300_000, "steps/s"),
    Target("two threads, Verlet f64", 1.8, "times one"),
    Target("two threads, Verlet f32", 1.8, "times one"),
    Target("two threads, RK4 f64", 1.8, "times one"),
    Target("two threads, RK4 f32", 1.8, "times one"),
    Target("two threads, grid f64", 1.8, "times one"),
    Target("two threads, grid f32", 1.8, "times one"),
    Target("two threads, network f64", 1.8, "times one"),
    Target("two threads, network f32", 1.8, "times one"),
    Target("50 rods", 50_000, "steps/s"),
    Target("XPBD sweep f32", 0.55, "ms", at_most=True),
    Target("XPBD ten sweeps f32", 6.0, "ms", at_most=True),
    Target("projective dynamics f32", 15.0, "ms", at_most=True),
    Target("implicit step f64", 70.0, "ms", at_most=True),
    Target("self-contact f32", 25.0, "ms", at_most=True),
    Target("self-contact f64", 25.0, "ms", at_most=True),
    Target("fluid 3D, no walls", 5.0, "M particle-steps/s"),
    Target("fluid 3D", 3.5, "M particle-steps/s"),
    Target("fluid 2D", 10.0, "M particle-steps/s"),
    Target("fluid 3D, f64 over f32", 0.45, "times f32"),
    Target("fluid 2D, f64 over f32", 0.45, "times f32"),
    Target("two threads, fluid 3D", 1.7, "times one"),
    Target("two threads, fluid 2D", 1.7, "times one"),
    Target("memory, fluid 3D", 500, "bytes per particle", at_most=True),
    Target("memory, fluid 2D", 500, "bytes per particle", at_most=True),
    Target("wave f32", 2.6, "G cell-updates/s"),
    Target("wave f64", 1.4, "G cell-updates/s"),
    Target("two threads, wave f32", 1.7, "times one"),
    Target("two threads, wave f64", 1.7, "times one"),
    Target("wave f32, 8192² over 1024²", 1.3, "times as long", at_most=True),
    Target("wave f64, 8192² over 1024²", 1.3, "times as long", at_most=True),
    Target("small wave f32", 100_000, "steps/s"),
    Target("small wave f64", 100_000, "steps/s"),
    Target("reaction f32", 1.3, "G cell-updates/s"),
    Target("reaction f64", 0.7, "G cell-updates/s"),
    Target("two threads, reaction f32", 1.7, "times one"),
    Target("two threads, reaction f64", 1.7, "times one"),
    Target("split step f32", 11.0, "ms", at_most=True),
    Target("split step f64", 20.0, "ms", at_most=True),
    Target("two threads, split step f32", 1.7, "times one"),
    Target("two threads, split step f64", 1.7, "times one"),
    Target("gravitation f64", 1.0, "G pairs/s"),
    Target("gravitation f32", 3.0, "G pairs/s"),
    Target("two threads, gravitation f64", 1.8, "times one"),
    Target("two threads, gravitation f32", 1.8, "times one"),
    Target("tree f32, 10⁵ stars", 0.04, "s", at_most=True),
    Target("tree f64, 10⁵ stars", 0.07, "s", at_most=True),
    Target("tree f32, 10⁶ stars", 0.5, "s", at_most=True),
    Target("tree f64, 10⁶ stars", 0.75, "s", at_most=True),
    Target("tracers f64", 0.5, "G point-steps/s"),
    Target("tracers f32", 1.0, "G point-steps/s"),
    Target("two threads, tracers f64", 1.8, "times one"),
    Target("two threads, tracers f32", 1.8, "times one"),
    Target("Boris f64", 0.3, "G particle-steps/s"),
    Target("two threads, Boris f64", 1.8, "times one"),
    Target("discs", 0.8, "times the best peer", at_most=True),
    Target("pyramid", 1.0, "times the best peer that stands", at_most=True),
    Target("pyramid, displacement", rigid.STANDING, "sides", at_most=True),
    Target("heap", 1.0, "times the best peer", at_most=True),
    Target("tumbling, sin and cos", 0.85, "of Numba's speed"),
    Target("two threads, 20 piles in 3D", 1.7, "times one"),
    Target("two threads, 20 piles in 2D", 1.7, "times one"),
    Target("import", 0.15, "s", at_most=True),
    Target("accuracy=, cost", 6.0, "returned runs", at_most=True),
    Target("accuracy=, share used", 0.1, "of what was allowed"),
    Target("accuracy=, promises broken", 0.0, "calls", at_most=True),
)


def main() -> None:
    """Run everything, then hold it against the targets."""
    simd = pc.Simulation(particles.falling(2), dt=1e-3).plan.simd
    where = f"{machine(simd)}, {cell(clock())} GHz"
    print(where)
    print(f"physcore {pc.__version__}, NumPy {np.__version__}, Numba {getattr(numba, '__version__', 'not installed')}")
    print("physcore audits and watches for divergence in every run; its opponents do neither.")
    drops, networks = dict(particles.readings()), dict(springs.readings())
    figures = particles.figures(drops) | springs.figures(networks) | fluids.main() | waves.main()
    figures |= reactions.main() | wave_functions.main() | gravitation.main()
    figures |= (
        rods.main()
        | stiff.main()
        | self_contact.main()
        | tracers.main()
        | charges.main()
        | rigid.main()
        | overheads.main()
        | accuracy.main()
    )
    film.main()
    hardware.show(drops, networks)
    judge(
        f"Targets, as set on a Zen 4 core of about 3.6 GHz; measured here, not scaled: {where}\n"
        "Rates are medians per CPU second on one thread; two threads over one are the fastest turns on the wall clock, "
        "and not measured where the machine was too busy for two threads.",
        ((f"{one.figure} [{one.unit}]", one.bound, figures[one.figure], one.at_most) for one in TARGETS),
    )


if __name__ == "__main__":
    main()
