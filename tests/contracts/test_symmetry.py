"""What the laws of motion do not care about, the numbers do not either: coordinates, units, the order of particles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import physcore as pc
from contracts import rigid
from contracts.comparison import difference, plain, state, tolerance
from contracts.scenes import SCENES, Case
from contracts.transforms import Array, Transform, moved, transformed
from physcore.systems.flows import FLOWS
from physcore.systems.kinetics import KINETICS


def is_resting(force: object) -> bool:
    """Whether a force is not the same for who moves along."""
    if isinstance(force, pc.ElectromagneticField):
        return not all(isinstance(field, (float, tuple)) for field in (force.electric, force.magnetic))
    return isinstance(force, (pc.CentralForce, pc.CustomForce)) or getattr(force, "by_place", False)


def rescaled(case: Case, t: Transform) -> Case:
    """The numerics of a case in other units."""
    numerics = dict(case.numerics)
    rule = numerics.get("dt")
    if isinstance(rule, pc.AdaptiveStep) and rule.tolerance is not None:
        unit = 1.0 if any(isinstance(system, pc.ReactionDiffusion) for system in case.shared.systems) else t.m
        numerics["dt"] = pc.AdaptiveStep(rule.safety, rule.tolerance * unit)
    method = numerics.get("fluids")
    if method is not None and method.sound_speed != "auto":
        numerics["fluids"] = replace(method, sound_speed=method.sound_speed * t.m / t.s)
    return replace(case, dt=case.dt * t.s, numerics=numerics)


def compare(name: str, t: Transform, shuffle: bool = False, size: float = 1.0) -> None:
    """Transforming a scene transforms its motion, within rounding."""
    case = SCENES[name]
    scene = case.shared
    rng = np.random.default_rng(3)
    orders = [rng.permutation(len(body)) if shuffle else np.arange(len(body)) for body in scene.bodies]
    other = rescaled(case, t).simulation(transformed(scene, t, orders))
    rescaled(case, t).advance(other)
    order = rigid.rows(scene, orders) if scene.bodies else np.zeros(0, dtype=int)
    x, v = moved(t, scene, state(plain(name)), order)
    expected = x + np.asarray(t.boost) * case.duration if scene.bodies else x, v
    assert difference(other.scene, expected, state(other)) <= tolerance(name, plain(name), size)


def axes(name: str) -> Array:
    return np.eye(SCENES[name].shared.dimension)


@pytest.mark.parametrize("name", SCENES)
def test_moving_a_scene_moves_its_motion(name):
    """Numbers of up to 16 m are rounded where those of about 1 m were."""
    compare(name, Transform(axes(name), shift=np.array([8.0, -16.0, 4.0])[: len(axes(name))]), size=16.0)


@pytest.mark.parametrize("name", SCENES)
def test_turning_a_scene_by_a_quarter_turns_its_motion(name):
    """In space by a third of a turn about (1, 1, 1): all three axes change their roles."""
    turn = np.roll(axes(name), 1, axis=0)
    if len(turn) == 1:
        pytest.skip("a line cannot be turned")
    if any(isinstance(boundary, pc.HeightField) for boundary in SCENES[name].shared.boundaries):
        pytest.skip("up is the last axis")
    if len(turn) == 2:
        turn[0] *= -1.0
    assert np.linalg.det(turn) == pytest.approx(1.0)
    compare(name, Transform(turn))


@pytest.mark.parametrize("name", SCENES)
def test_a_mirror_changes_signs(name):
    mirror = axes(name)
    mirror[0, 0] = -1.0
    compare(name, Transform(mirror))


@pytest.mark.parametrize("name", [name for name in SCENES if SCENES[name].shared.bodies and name != "heap"])
def test_the_order_of_particles_does_not_matter(name):
    """A permutation changes the order of sums, so rounding, and nothing else; results keep the caller's order.

    But sweeps over contacts, which end before they converge, take them in the order of the bodies.
    """
    compare(name, Transform(axes(name)), shuffle=True)


def moves_along(name: str) -> bool:
    """Whether nothing in a scene stands still by itself."""
    scene = SCENES[name].shared
    if isinstance(SCENES[name].numerics.get("integrator"), pc.ProjectiveDynamics):
        return False  # Its iterations start from the positions of the step before, and end before they converge.
    held = (
        isinstance(each, pc.Wire) or (each.element == "joints" and None in (each.one, each.other))
        for each in scene.constraints
    )
    stands = scene.boundaries or any(held)
    return bool(scene.bodies) and not stands and not any(map(is_resting, scene.forces))


@pytest.mark.filterwarnings("ignore::physcore.MachWarning")
@pytest.mark.parametrize("name", [name for name in SCENES if moves_along(name)])
def test_a_uniform_motion_of_all_changes_nothing_else(name):
    """Galilei's principle. Limits of the time step are those of relative motion: adaptive steps are the same too."""
    compare(name, Transform(axes(name), boost=np.array([1.0, -2.0, 0.5])[: len(axes(name))]), size=4.0)


BUILT_IN = tuple(kind for kind in KINETICS if kind is not pc.Reaction)
READY = tuple(kind for kind in FLOWS if kind is not pc.Flow)
LENGTH, TIME, MASS = 10, -7, 16
"""Exponents of 2. No product of small powers of the units is 1, so that a constant of any unit stands out: of a length
as well as of a pressure. Powers of a law's exponents are powers of two as well.
"""


def direction(name: str) -> int:
    """Whether the numbers of a scene grow or shrink: in turns, so that thresholds on either side stand out."""
    return 1 if list(SCENES).index(name) % 2 == 0 else -1


@pytest.mark.parametrize("name", [name for name in SCENES if name != "swarm power"])
def test_other_units_change_no_bit(name):
    """Powers of two scale every number exactly, away from underflow: nothing has a scale of its own.

    But a power of r whose exponent, −2.7, is itself rounded.
    """
    case = SCENES[name]
    scene = case.shared
    has_rate = any(isinstance(getattr(system, "reaction", None), BUILT_IN) for system in scene.systems)
    if any(isinstance(getattr(system, "flow", None), READY) for system in scene.systems):
        pytest.skip("its flow has lengths and a rate of 1/s in it")
    m, s, kg = (2.0 ** (direction(name) * power) for power in (LENGTH, 0 if has_rate else TIME, MASS))
    t = Transform(np.eye(scene.dimension), m=m, s=s, kg=kg)
    run, scaled = plain(name), rescaled(case, t).simulation(transformed(scene, t))
    # The stiffness of Hertz's contact takes a root.
    assert scaled.plan.dt_limit == pytest.approx(case.simulation(scene).plan.dt_limit * t.s, rel=1e-14)
    rescaled(case, t).advance(scaled)
    assert scaled.steps == run.steps
    for found, wanted in zip(state(scaled), moved(t, scene, state(run)), strict=True):
        assert np.array_equal(found, wanted)
    for part in ("balance", "dissipated", "work"):
        assert getattr(scaled.energy(), part) == getattr(run.energy(), part) * t.unit(2, -2, 1), part
