"""Random piles of rigid bodies, which settle in their box without gaining energy, and scenes turned and mirrored."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import physcore as pc
from contracts.comparison import RIGID, difference, grown, state
from contracts.scenes import STEPS, Case
from contracts.transforms import Transform, moved, transformed
from test_rigid_properties import CELL, DT, MOST_GAIN, REACH, placed, shapes, sizes, units

G = 9.81
CLOSED = 1e-6
"""Gap at which a contact counts as closed, over the size of the bodies: `island::CLOSED` in the engine."""
SETTLED = 3.0
"""Time after which a pile is at rest, but for what rolls [s]: it falls by less than 2 m, in 0.6 s."""


@st.composite
def piles(draw: st.DrawFn) -> pc.Scene:
    """Bodies of three shapes above each other in any orientation, enough for a large group, in a box."""
    dimension = draw(st.sampled_from([2, 3]))
    across, layers = (4, 9) if dimension == 2 else (3, 3)
    width = CELL * across
    cells = np.array(list(np.ndindex(*[across] * (dimension - 1), layers)))
    generator = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    generator.shuffle(cells)
    bodies = []
    for rows in np.array_split(cells, 3):
        turns: dict[str, Any] = {"angles": generator.uniform(-np.pi, np.pi, len(rows))}
        if dimension == 3:
            turns = {"orientations": generator.normal(size=(len(rows), 4))}
        bodies.append(
            pc.RigidBodies(
                draw(shapes(dimension)),
                CELL * (rows + 0.5),
                velocities=generator.uniform(-1.0, 1.0, rows.shape),
                mass=generator.uniform(0.3, 1.0, len(rows)),
                friction=draw(st.floats(0.2, 1.0)),
                restitution=draw(st.floats(0.0, 0.5)),
                rolling_friction=0.1 * REACH,
                **turns,
            )
        )
    sides = []
    for axis in range(dimension - 1):
        for place, sign in ((0.0, 1.0), (width, -1.0)):
            point, normal = np.zeros((2, dimension))
            point[axis], normal[axis] = place, sign
            sides.append(pc.Plane(tuple(point), tuple(normal), restitution=0.0, friction=0.5))
    return pc.Scene(
        *bodies, *sides, pc.Floor(0.0, restitution=0.0, friction=0.5), pc.Gravity(-G * np.eye(dimension)[-1])
    )


@settings(phases=(Phase.explicit, Phase.reuse, Phase.generate))  # smaller piles are no simpler
@given(piles())
def test_piles_settle_in_their_box_without_gaining_energy(scene):
    """No body sinks into another by more than a tenth of its half thickness, at most `REACH`, in a sweep, and what
    lifts all out of such an overlap is the largest gain of the balance. What is left at the end rolls slowly.
    """
    recording = pc.simulate(scene, SETTLED, fps=30, dt=1 / 120, contacts=pc.ContactSolver(sequential=8))
    energy, start = recording.energy, recording.energy.total[0]
    assert energy.total.max() <= start * (1.0 + MOST_GAIN)
    weight = G * sum(float(body.mass.sum()) for body in scene.bodies)
    assert (energy.balance - energy.balance[0]).max() <= 0.1 * REACH * weight
    assert (np.diff(energy.dissipated) >= -1e-12 * start).all()
    assert energy.kinetic[-1] <= 1e-2 * start
    width = CELL * (4 if scene.dimension == 2 else 3)
    for body in scene.bodies:
        x = recording[body].positions
        assert x[..., :-1].min() > 0.0
        assert x[..., :-1].max() < width
        assert x[..., -1].min() > 0.0


@st.composite
def turns(draw: st.DrawFn) -> tuple[pc.Scene, Transform]:
    """Bodies that fall and meet on two planes, and a rotation, with or without a reflection."""
    dimension = draw(st.sampled_from([2, 3]))
    bodies = draw(placed(dimension, draw(st.integers(2, 4))))
    up = np.eye(dimension)[-1]
    slope = np.eye(dimension)[0] + up
    planes = [
        pc.Plane((0.0,) * dimension, tuple(normal), restitution=draw(st.floats(0.0, 1.0)), friction=draw(sizes))
        for normal in (up, slope)
    ]
    # A rotation by any angle, or in space about any axis: the Q of a matrix of random entries.
    turn = np.linalg.qr(
        np.reshape([draw(units) for _ in range(dimension**2)], (dimension, dimension)) + 2.0 * np.eye(dimension)
    )[0]
    if draw(st.booleans()):
        turn[0] *= -1.0
    return pc.Scene(*bodies, *planes, pc.Gravity(tuple(-G * up))), Transform(turn)


@given(turns())
def test_turned_and_mirrored_scenes_have_the_turned_and_mirrored_motion(pair):
    """To rounding, and to the tolerance of contacts, which grow as any small difference does; `grown` measures that.
    Rounding also decides whether contacts count as closed that are so nearly.
    """
    scene, t = pair
    case, other = (Case(lambda scene=each: scene, DT) for each in (scene, transformed(scene, t)))
    run, turned = (each.advance(each.simulation()) for each in (case, other))
    tolerance = CLOSED + 10.0 * grown(case) * (np.sqrt(STEPS) * np.finfo(float).eps + RIGID)
    assert difference(turned.scene, moved(t, scene, state(run)), state(turned)) <= tolerance
