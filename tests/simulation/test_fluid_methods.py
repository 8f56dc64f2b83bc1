"""Methods for fluids are given beside the scene, saved and compared."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import physcore as pc
from physcore.numerics.choices import check
from physcore.numerics.fluids import FLUID_METHODS
from work import counted

CELLS = pc.block((0.0, 0.0), (0.4, 0.4), 0.1)
METHOD = pc.WeaklyCompressible(sound_speed=30.0, kernel=pc.CubicSpline(1.3), artificial_viscosity=0.05, shifting=1.0)
TANK = pc.Box((0.0, 0.0), (0.8, 0.8))
DOWN = pc.Gravity((0.0, -9.81))


def pool() -> pc.Scene:
    return pc.Scene(pc.Fluid(CELLS, 0.1, name="water"), DOWN, TANK)


def bits(scene: pc.Scene, **numerics: object) -> str:
    run = pc.Simulation(scene, dt=1e-3, **numerics)
    run.step(50)
    return run.state_hash()


@pytest.mark.parametrize("given", [METHOD, {"water": METHOD}, {0: METHOD}])
def test_a_method_is_for_all_fluids_or_for_those_that_are_named(given):
    scene = pool()
    assert bits(scene, fluids=given) == bits(scene, fluids=METHOD) != bits(scene)
    assert bits(scene, fluids={scene.bodies[0]: METHOD}) == bits(scene, fluids=METHOD)
    assert bits(scene, fluids="WeaklyCompressible") == bits(scene, fluids="auto") == bits(scene)


def test_a_method_is_saved_pickled_and_named(tmp_path):
    run = pc.Simulation(pool(), dt=1e-3, fluids=METHOD)
    run.step(10)
    run.save(tmp_path / "run.npz")
    others = [pc.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run))]
    run.step(10)
    for other in others:
        other.step(10)
        assert other.state_hash() == run.state_hash()
        assert other.provenance == run.provenance
    fields = run.provenance.numerics["fluids"]["fields"]
    assert fields["sound_speed"] == 30.0
    assert fields["kernel"] == {"kind": "CubicSpline", "fields": {"smoothing": 1.3}}
    recording = pc.simulate(pool(), 0.01, fluids=METHOD)
    recording.save(tmp_path / "recording.npz")
    assert pc.load(tmp_path / "recording.npz").provenance == recording.provenance
    assert "fluids" not in pc.Simulation(pc.Scene(pc.Particles([[0.0, 0.0]]))).provenance.numerics


def test_several_methods_are_saved_by_the_paths_of_their_fluids(tmp_path):
    """Equal ones, because fluids of one scene have their numerics in common; one has no name."""
    scene = pc.Scene(pc.Fluid(CELLS, 0.1), pc.Fluid(np.add(CELLS, (0.4, 0.0)), 0.1, 800.0, name="oil"), DOWN, TANK)
    numerics = check({"fluids": {0: METHOD, "oil": replace(METHOD, shifting=0.0)}}, scene)
    assert list(numerics.fluids) == ["bodies[0]", "bodies['oil']"]
    run = pc.Simulation(scene, dt=1e-3, fluids={"oil": METHOD, 0: METHOD})
    run.save(tmp_path / "run.npz")
    assert pc.load(tmp_path / "run.npz").provenance == run.provenance
    with pytest.raises(pc.SceneError, match=r"bodies\['oil'\]: expected numerics as those of bodies\[0\]"):
        pc.Simulation(scene, fluids={"oil": METHOD})


@pytest.mark.parametrize("kind", FLUID_METHODS)
def test_methods_have_defaults_and_are_equal_by_what_they_say(kind):
    assert kind() == kind()
    assert hash(kind()) == hash(kind())


def test_what_cannot_be_is_refused_by_its_path():
    grain = pc.Scene(pc.Particles([[0.0, 0.0]]))
    refused = [
        (grain, METHOD, r"fluids: there is no Fluid in this scene"),
        (grain, {0: METHOD}, r"fluids\[0\]: is no Fluid of this scene, which has none"),
        (pool(), {"oil": METHOD}, r"fluids\['oil'\]: is no Fluid of this scene, which has bodies\['water'\]"),
        (pool(), pc.WeaklyCompressible, r"fluids: must be one of WeaklyCompressible\(\).*write WeaklyCompressible\(\)"),
        (pool(), "WeaklyCompresible", r"fluids: .*did you mean 'WeaklyCompressible'\?"),
    ]
    for scene, fluids, message in refused:
        with pytest.raises(pc.SceneError, match=message):
            pc.Simulation(scene, fluids=fluids)


def test_sound_that_is_slower_than_the_flow_or_too_slow_for_friction_is_warned_of():
    """c² < 100 νU/L: here ν = 1 m²/s, U = 0.1 m/s and L = 0.4 m ask for 5 m/s."""
    fast = pc.Scene(pc.Fluid(CELLS, 0.1, velocities=(2.0, 0.0)))
    with pytest.warns(pc.MachWarning, match=r"fluids\.sound_speed: 1 m/s are less than the speed of the flow, 2 m/s"):
        pc.Simulation(fast, fluids=pc.WeaklyCompressible(sound_speed=1.0))
    thick = pc.Scene(pc.Fluid(CELLS, 0.1, viscosity=1000.0, velocities=(0.1, 0.0)))
    with pytest.warns(pc.SceneWarning, match=r"fluids\.sound_speed: 1 m/s are too few for this viscosity.*take 5 or"):
        pc.Simulation(thick, fluids=pc.WeaklyCompressible(sound_speed=1.0))
    assert "sound at 5.0000 m/s" in str(pc.Simulation(thick).plan)


def sound(scene: pc.Scene) -> float:
    """The speed of sound that is chosen [m/s]."""
    (note,) = (note for note in pc.Simulation(scene).plan.notes if note.startswith("fluid: sound at "))
    return float(note.split()[3])


def test_sound_is_found_along_a_periodic_axis_and_in_a_central_force():
    """gL²/8ν in a channel that is 0.4 m wide, at most 20 √(gL/2); ωR in a harmonic well, from the edge of a drop."""
    ends, walls = pc.Periodic((0.0, -np.inf), (0.8, np.inf)), [(0.0, 1.0), (0.4, -1.0)]
    cells = pc.block((0.0, 0.0), (0.8, 0.4), 0.1)
    sides = [pc.Plane((0.0, height), (0.0, way), no_slip=True) for height, way in walls]
    along = pc.Gravity((0.1, 0.0))
    thick, thin = (pc.Fluid(cells, 0.1, viscosity=viscosity) for viscosity in (10.0, 1e-3))
    assert sound(pc.Scene(thick, along, ends, *sides)) == pytest.approx(10.0 * 0.1 * 0.4**2 / (8.0 * 0.01), rel=1e-4)
    assert sound(pc.Scene(thin, along, ends, *sides)) == pytest.approx(10.0 * 20.0 * np.sqrt(0.1 * 0.2), rel=1e-4)
    slippery = [pc.Plane((0.0, height), (0.0, way)) for height, way in walls]
    with pytest.raises(
        pc.SceneError, match=r"fluids\.sound_speed: .*no-slip walls and obstacles along a periodic axis"
    ):
        pc.Simulation(pc.Scene(thin, along, ends, *slippery))
    drop = pc.Fluid(pc.ball((0.0, 0.0), 0.5, 0.1), 0.1)
    edge = float(np.linalg.norm(drop.positions, axis=1).max())
    well = pc.CentralForce((0.0, 0.0), 4.0 * float(drop.mass[0]), exponent=1.0)
    assert sound(pc.Scene(drop, well)) == pytest.approx(10.0 * 2.0 * edge, rel=1e-4)


def test_the_artificial_viscosity_is_what_the_fluid_s_own_lacks():
    """αhc/8 of α = 0.02, h = 0.15 m and c = 10 m/s is 3.75e-3 m²/s: a viscosity above that is the only one."""
    cells, ends = pc.block((0.0, 0.0), (0.8, 0.8), 0.1), pc.Periodic((0.0, 0.0), (0.8, 0.8))

    def scene(viscosity: float) -> pc.Scene:
        return pc.Scene(pc.Fluid(cells, 0.1, viscosity=viscosity, velocities=(1.0, 0.0), name="water"), ends)

    def notes(viscosity: float) -> list[str]:
        method = pc.WeaklyCompressible(sound_speed=10.0)
        plan = pc.Simulation(scene(viscosity), fluids=method).plan
        return [note for note in plan.notes if note.startswith("bodies['water']: viscosity")]

    assert notes(4.0) == []
    (thin,), (half,) = notes(1e-3), notes(1.875)
    assert "viscosity 3.8e0 Pa·s, of which 3.7e0 are artificial (α = 2.00e-2) and 1.0e-3 its own" in thin
    assert "α = 1.00e-2" in half
    # c/10 over 0.8 m by 3.75e-3 m²/s.
    assert "Reynolds number is 213" in half
    same = [bits(scene(1.875), fluids=pc.WeaklyCompressible(10.0, artificial_viscosity=a)) for a in ("auto", 0.01)]
    assert same[0] == same[1]


def test_shifting_is_on_where_it_is_safe():
    """In a closed space and without a force; not at a free surface in gravity, with tension, or for fluids that mix."""
    water = pc.Fluid(CELLS, 0.1, velocities=(0.1, 0.0))
    oil = pc.Fluid(np.add(CELLS, (0.4, 0.0)), 0.1, 800.0)
    full, ends = pc.Box((0.0, 0.0), (0.4, 0.4)), pc.Periodic((0.0, 0.0), (0.8, 0.8))
    everywhere = pc.Fluid(pc.block((0.0, 0.0), (0.8, 0.8), 0.1), 0.1, velocities=(0.1, 0.0))
    tense = pc.Fluid(CELLS, 0.1, surface_tension=0.1)
    shifted = [(water,), (water, full, DOWN), (everywhere, ends)]
    still = [(water, TANK, DOWN), (water, oil), (tense,)]
    for items, on in [*((items, True) for items in shifted), *((items, False) for items in still)]:
        assert ("shifted by A = 6" in str(pc.Simulation(pc.Scene(*items)).plan)) == on
    summed = pc.Simulation(pc.Scene(everywhere, ends), fluids=pc.WeaklyCompressible(density_from="summation"))
    assert "shifted" not in str(summed.plan)


def test_methods_are_an_axis_of_a_tradeoff():
    methods = [pc.WeaklyCompressible(sound_speed=20.0), pc.WeaklyCompressible(sound_speed=40.0)]
    with counted():
        trade = pc.tradeoff(
            pool(), 0.02, fluids=methods, integrators=["VelocityVerlet"], precisions=["f64"], budget=0.5
        )
    assert {row.fluids for row in trade.rows} == set(methods)
    assert all(row.numerics["fluids"] == row.fluids for row in trade.rows)
    assert "WeaklyCompressible(sound_speed=20.0)" in str(trade)
    assert pc.Simulation(trade.scene, **trade.rows[0].numerics).dt == trade.rows[0].dt
    with pytest.raises(pc.SceneError, match="fluids: must not be empty"):
        pc.tradeoff(pool(), 0.02, fluids=[])
    with pytest.raises(pc.SceneError, match=r"fluids\[0\]: must be one of WeaklyCompressible\(\)"):
        pc.tradeoff(pool(), 0.02, fluids=["FLAP"])


def test_the_limit_and_a_film_take_methods(tmp_path):
    """Sound limits the step as 1/c."""
    limits = [
        pc.stability_limit(pool(), "VelocityVerlet", fluids=pc.WeaklyCompressible(c, artificial_viscosity=0.0))
        for c in (100.0, 200.0)
    ]
    assert limits[0] == pytest.approx(2.0 * limits[1], rel=0.02)
    film = pc.film(pool(), tmp_path / "pool.png", duration=0.02, size=(48, 32), fluids=METHOD)
    assert film.path.exists()
