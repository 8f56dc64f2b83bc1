"""Scenes: what may be in one, and how their parts are found."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.boundaries import BOUNDARIES
from physcore.constraints import CONSTRAINTS
from physcore.forces import FORCES
from physcore.integrators import INTEGRATORS
from physcore.scene.records import Record

ONE = pc.Particles([[0.0, 1.0]], name="one")
TWO = pc.Particles([[0.0, 1.0], [2.0, 3.0]], name="two")
DOWN = pc.Gravity((0.0, -9.81))


def test_the_dimension_follows_from_the_positions():
    assert pc.Scene(ONE).dimension == 2
    assert pc.Scene(pc.Particles([[0.0, 0.0, 0.0]])).dimension == 3


def test_bodies_are_found_by_themselves_by_index_and_by_name():
    scene = pc.Scene(ONE, DOWN, TWO)
    for key in (TWO, 1, -1, np.int64(1), "two"):
        assert scene.index(key) == 1
        assert scene.slice(key) == slice(1, 3)
    assert scene.particles == 3
    for key in (pc.Particles([[0.0, 1.0]]), 2, "three", True):
        with pytest.raises(KeyError):
            scene.index(key)


def test_a_key_of_another_kind_names_no_body():
    scene = pc.Scene(ONE, TWO)
    for key in (np.timedelta64(1, "s"), np.array([0, 1]), [0], None, True, 10**400, "\ud800"):
        with pytest.raises(KeyError, match="no body"):
            scene.slice(key)


def test_items_come_in_any_order():
    scene = pc.Scene(pc.Floor(), DOWN, ONE, pc.Drag(0.1))
    assert (scene.bodies, len(scene.forces), len(scene.boundaries)) == ((ONE,), 2, 1)


def test_values_compare_by_value():
    assert pc.Gravity([0, -1]) == pc.Gravity((0.0, -1.0))
    assert pc.PEFRL() == pc.PEFRL()
    assert pc.PEFRL() != pc.RungeKutta4()
    assert hash(pc.Floor(1)) == hash(pc.Floor(1.0))


def test_pair_forces_fill_in_what_follows_from_the_rest():
    assert pc.LennardJones(1.0, 2.0).cutoff == 5.0
    assert pc.LennardJones(1.0, 2.0) == pc.LennardJones(1.0, 2.0, cutoff=5.0)
    assert pc.SoftSpheres(1.0, 0.5).tangential_damping == 0.5
    assert pc.SoftSpheres(1.0, 0.5, tangential_damping=0.25).tangential_damping == 0.25
    assert Record.of(pc.SoftSpheres(10, 1, exponent=1.5)).described() == {
        "kind": "SoftSpheres",
        "name": None,
        "on": None,
        "members": None,
        "values": {
            "stiffness": 10.0,
            "damping": 1.0,
            "friction": 0.0,
            "tangential_damping": 1.0,
            "exponent": 1.5,
            "restitution": None,
        },
    }
    told = Record.of(pc.LennardJones(1, 2)).described()
    assert told["values"] == {"epsilon": 1.0, "sigma": 2.0, "cutoff": 5.0}


def test_a_floor_is_a_plane_with_all_that_it_says():
    floor = pc.Floor(2.0, restitution=0.5, friction=0.1, no_slip=True)
    plane = pc.Plane((0.0, 0.0, 2.0), (0.0, 0.0, 1.0), restitution=0.5, friction=0.1, no_slip=True)
    assert floor.resolved(3) == plane == plane.resolved(3)
    on_one = pc.Floor(on=ONE)
    assert on_one.resolved(2).bodies() == (ONE,)


def test_one_radius_is_enough_for_repulsion():
    pc.Scene(ONE, pc.Particles([[1.0, 1.0]], radius=0.1), pc.SoftSpheres(1.0))
    pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 0.0]], radius=[0.0, 0.1]), pc.SoftSpheres(1.0))
    pc.Scene(pc.Particles(np.empty((0, 2))), pc.SoftSpheres(1.0))


def test_a_force_acts_on_one_body_or_several():
    assert pc.Gravity((0, -1), on=ONE).bodies() == (ONE,)
    assert pc.Gravity((0, -1), on=[ONE, TWO]).bodies() == (ONE, TWO)
    assert pc.Gravity((0, -1)).bodies() is None


@pytest.mark.parametrize("kind", [*FORCES, *BOUNDARIES, *CONSTRAINTS, *INTEGRATORS])
def test_everything_registered_is_public_and_explains_itself(kind):
    assert getattr(pc, kind.__name__) is kind
    assert kind.__name__ in pc.__all__
    assert kind.__doc__ is not None


@pytest.mark.parametrize("kind", INTEGRATORS)
def test_every_integrator_names_its_order_and_its_source(kind):
    assert kind().order in range(1, 16)
    assert "Source:" in kind.__doc__


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Scene(), "Scene: must have at least one body"),
        (lambda: pc.Scene(DOWN), "Scene: must have at least one body"),
        (lambda: pc.Scene([ONE, DOWN]), r"items\[0\]: .*unpack it: Scene\(\*items\)"),
        (lambda: pc.Scene(ONE, pc.Gravity), r"items\[1\]: .*write Gravity\(…\)"),
        (lambda: pc.Scene(ONE, ONE), r"bodies\[1\]: the same body is in the scene twice"),
        (lambda: pc.Scene(ONE, pc.Particles([[1.0, 1.0]], name="one")), r"bodies\[1\].name: 'one' is already"),
        (
            lambda: pc.Scene(ONE, pc.Particles([[0.0, 0.0, 0.0]])),
            r"bodies\[1\].positions: 3D, but the first body is 2D",
        ),
        (lambda: pc.Scene(ONE, pc.Drag(), pc.Gravity((0, 0, -1))), r"forces\[1\].acceleration: .* 2 components"),
        (lambda: pc.Scene(ONE, pc.Drag(wind=(1, 0, 0))), r"forces\[0\].wind: Drag must have 2 components"),
        (lambda: pc.Scene(ONE, pc.Sphere((0, 0, 0), 1.0)), r"boundaries\[0\].center: Sphere must have 2 components"),
        (
            lambda: pc.Scene(ONE, pc.Gravity((0, -1), on=TWO)),
            r"forces\[0\].on: Particles\('two', .* is not in the scene",
        ),
        (lambda: pc.Gravity((0, -1), on=1.0), "Gravity.on: must be a body, its name, or several"),
        (lambda: pc.Gravity(-9.81), "Gravity.acceleration: must be 2 or 3 numbers"),
        (lambda: pc.Gravity((0, float("nan"))), r"Gravity.acceleration\[1\]: must be finite"),
        (lambda: pc.Drag(-1.0), "Drag.linear: must be ≥ 0, got -1"),
        (lambda: pc.Drag(quadratic="fast"), "Drag.quadratic: must be a number, got 'fast'"),
        (lambda: pc.CentralForce((0, 0), 1.0, softening=-1.0), "CentralForce.softening: must be ≥ 0"),
        (lambda: pc.SoftSpheres(0.0), "SoftSpheres.stiffness: must be > 0"),
        (lambda: pc.SoftSpheres(1.0, -1.0), "SoftSpheres.damping: must be ≥ 0"),
        (
            lambda: pc.SoftSpheres(1.0, exponent=2.0),
            r"SoftSpheres.exponent: must be 1 \(linear\) or 1.5 \(Hertzian\), got 2",
        ),
        (
            lambda: pc.SoftSpheres(1.0, friction=0.5),
            "SoftSpheres.tangential_damping: must be > 0 where there is friction",
        ),
        (
            lambda: pc.SoftSpheres(1.0, 1.0, friction=0.5, tangential_damping=0.0),
            "SoftSpheres.tangential_damping: must be > 0 where there is friction",
        ),
        (
            lambda: pc.Scene(ONE, pc.Particles([[1.0, 1.0]], radius=0.1), DOWN, pc.SoftSpheres(1.0, on=ONE)),
            r"forces\[1\]: SoftSpheres acts .* radius 0; give them a size: Particles\(…, radius=…\)",
        ),
        (lambda: pc.LennardJones(0.0, 1.0), "LennardJones.epsilon: must be > 0"),
        (lambda: pc.LennardJones(1.0, -1.0), "LennardJones.sigma: must be > 0"),
        (lambda: pc.LennardJones(1.0, 1.0, cutoff=0.0), "LennardJones.cutoff: must be > 0"),
        (lambda: pc.CustomForce(3), "CustomForce.function: must be a function"),
        (
            lambda: pc.CustomForce(lambda x: x),
            r"CustomForce.function: must take \(time, positions, velocities\), .*\(x\)",
        ),
        (
            lambda: pc.CustomForce(lambda t, x, v: x, lambda x, v: 0.0),
            r"CustomForce.potential: must take \(positions\)",
        ),
        (lambda: pc.Floor(restitution=1.5), "Floor.restitution: must be ≤ 1, got 1.5"),
        (lambda: pc.Floor(friction=-0.5), "Floor.friction: must be ≥ 0"),
        (lambda: pc.Floor(np.complex128(1.0)), "Floor.height: must be a number, got np.complex128"),
        (lambda: pc.Floor(np.ma.masked), "Floor.height: must be a number, got masked"),
        (lambda: pc.Floor(no_slip=1), "Floor.no_slip: must be True or False, got 1"),
        (lambda: pc.Plane((0, 0), (0, 0)), "Plane.normal: must not be zero"),
        (lambda: pc.Plane((0, 0), (0, 0, 1)), "Plane.normal: must have 2 components"),
        (lambda: pc.Box((0, 0), (1, 0)), "Box.upper: must be above the lower corner"),
        (lambda: pc.Box((0, 0), (1, 1, 1)), "Box.upper: must have 2 components"),
        (lambda: pc.Sphere((0, 0), 0.0), "Sphere.radius: must be > 0"),
        (lambda: pc.Sphere((0, 0), 1.0, inside=1), "Sphere.inside: must be True or False"),
    ],
)
def test_bad_input_is_refused_with_its_path(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()
