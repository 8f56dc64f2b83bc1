"""Chains of rods beside Numba: `python benches/rods.py`."""

from __future__ import annotations

import math

import numpy as np
from measure import Contender, race, rate, results
from rivals.jit import FASTMATH, numba_best
from rivals.rods import Chain

import physcore as pc

LINKS = 50
STEP = 2.5e-4


def chain(links: int) -> pc.SpringNetwork:
    """A chain of a meter that hangs askew and swings."""
    along = np.linspace(0.0, 1.0, links + 1)
    positions = np.column_stack([math.sin(0.4) * along, -math.cos(0.4) * along])
    pairs = np.column_stack([np.arange(links), np.arange(1, links + 1)])
    return pc.SpringNetwork(positions, pairs, math.inf, mass=0.01, fixed=[0])


def ours(links: int) -> pc.Simulation:
    """physcore, by RATTLE; energies and the monitor are on as always."""
    return pc.Simulation(pc.Scene(chain(links), pc.Gravity((0.0, -9.81))), dt=STEP, threads=1)


def rival(links: int, fastmath: bool) -> Chain:
    """The chain in Numba."""
    body = chain(links)
    return Chain(fastmath, body.positions, body.rest_length, body.mass, STEP)


def main() -> dict[str, float]:
    """Print the table; give the figure that has a target."""
    figures: dict[str, float] = {}
    for links in (LINKS, 20 * LINKS):
        simulation = ours(links)
        simulation.step(400)
        for fastmath in FASTMATH.values():
            other = rival(links, fastmath)
            other.step(400)
            # Both solve the same equations to rounding, which grows tenfold in a tenth of a second.
            np.testing.assert_allclose(simulation.positions, other.x, rtol=0.0, atol=1e-9)
        versions = {kind: (fastmath, 1) for kind, fastmath in FASTMATH.items()}
        numba = numba_best(lambda fastmath, links=links: rival(links, fastmath).step, versions)
        contenders = race([Contender("physcore", ours(links).step), numba])
        results(f"RATTLE, a chain of {links} rods, f64", "rod-steps", links, contenders)
        if links == LINKS:
            figures["50 rods"] = 1e9 * rate(contenders[0], 1)
    return figures


if __name__ == "__main__":
    main()
