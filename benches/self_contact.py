"""Contact of a cloth that is folded on itself: `python benches/self_contact.py`."""

from __future__ import annotations

import math

import numpy as np
from measure import Contender, race, rate, table

import physcore as pc
from physcore.numerics.choices import Precision

SHAPE = (72, 71)
SPACING = 0.02
PLEAT = 11.3
"""Width of a pleat, in units of the spacing: no row of particles lies on a fold."""
STEP = 1.0 / 60.0


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


def ours(precision: Precision) -> pc.Simulation:
    """physcore on one thread; energies and the monitor are on as always."""
    cloth = folded()
    scene = pc.Scene(
        cloth, pc.Gravity((0.0, 0.0, -9.81)), pc.Floor(-0.05, friction=0.3), pc.SelfContact(cloth, SPACING / 4)
    )
    return pc.Simulation(scene, pc.XPBD(1, 10), dt=STEP, precision=precision, threads=1)


def main() -> dict[str, float]:
    """Print the table; give the figure that has a target."""
    figures: dict[str, float] = {}
    faces = len(folded().faces)
    precisions: tuple[Precision, ...] = ("f64", "f32")
    for precision in precisions:
        contender = Contender("physcore, XPBD of ten sweeps and contacts", ours(precision).step)
        race([contender])
        table(f"A folded cloth of {faces} triangles, {precision}", "triangle-steps", faces, [contender])
        figures[f"self-contact {precision}"] = 1e-6 / rate(contender, 1.0)
    print({name: f"{value:.3g} ms" for name, value in figures.items()})
    return figures


if __name__ == "__main__":
    main()
