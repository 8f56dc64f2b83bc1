"""Fluids: what they are made of, the shapes that they fill, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physcore.numerics.choices import check
from physcore.scene.kernels import KERNELS
from physcore.scene.overlaps import closer_than
from physcore.simulation import engine

WATER = pc.block((0.0, 0.0), (1.0, 0.5), 0.1)


def test_a_block_is_the_centers_of_its_cells_along_x_first():
    np.testing.assert_allclose(
        pc.block((1.0, 0.0), (1.3, 0.2), 0.1),
        [[1.05, 0.05], [1.15, 0.05], [1.25, 0.05], [1.05, 0.15], [1.15, 0.15], [1.25, 0.15]],
    )
    assert pc.block((0.0,) * 3, (0.4, 0.6, 0.2), 0.2).shape == (6, 3)
    assert len(WATER) == 50


def test_the_number_of_cells_is_rounded():
    assert len(pc.block((0.0, 0.0), (0.05715, 2 * 0.05715), 0.05715 / 40)) == 40 * 80
    assert len(pc.block((0.0, 0.0), (1.04, 0.96), 0.1)) == 100


@pytest.mark.parametrize("dimension", [2, 3])
@given(radius=st.floats(1.0, 8.0))
def test_a_ball_has_its_volume_and_its_center(dimension, radius):
    """The cells that a surface of area A cuts may be counted or not: at most about A · √D of them, of size 1."""
    points = pc.ball((3.0, -2.0, 1.0)[:dimension], radius, 1.0)
    volume, surface = (
        (math.pi * radius**2, 2 * math.pi * radius)
        if dimension == 2
        else (
            4 / 3 * math.pi * radius**3,
            4 * math.pi * radius**2,
        )
    )
    assert abs(len(points) - volume) <= math.sqrt(dimension) * surface
    np.testing.assert_allclose(points.mean(axis=0), (3.0, -2.0, 1.0)[:dimension], atol=1e-12)
    assert np.linalg.norm(points - (3.0, -2.0, 1.0)[:dimension], axis=1).max() <= radius * (1 + 1e-12)


def test_a_cylinder_stands_on_its_base():
    points = pc.cylinder((1.0, 2.0, 3.0), radius=0.5, height=1.0, spacing=0.1)
    disc = pc.ball((1.0, 2.0), 0.5, 0.1)
    assert points.shape == (10 * len(disc), 3)
    np.testing.assert_allclose(points[: len(disc), :2], disc)
    np.testing.assert_allclose(np.unique(points[:, 2].round(9)), 3.05 + 0.1 * np.arange(10))


def test_a_fluid_has_the_mass_of_the_space_that_it_fills():
    flat = pc.Fluid(WATER, 0.1, density=800.0, velocities=(1.0, 0.0), name="oil")
    assert flat.mass.sum() == pytest.approx(800.0 * 1.0 * 0.5)  # for each meter of depth
    assert (flat.velocities == [1.0, 0.0]).all()
    assert not flat.radius.any()
    assert not flat.fixed.any()
    assert repr(flat) == "Fluid('oil', 50 particles in 2D)"
    cube = pc.Fluid(pc.block((0,) * 3, (1,) * 3, 0.25), 0.25)
    assert cube.mass.sum() == pytest.approx(1000.0)
    with pytest.raises(ValueError, match="read-only"):
        cube.mass[0] = 1.0


@pytest.mark.parametrize("kind", KERNELS)
def test_kernels_are_public_values_with_a_source(kind):
    assert getattr(pc, kind.__name__) is kind
    assert kind() == kind(kind().smoothing)
    assert kind(2.0) != kind(1.5)
    assert hash(kind(2)) == hash(kind(2.0))
    assert "Source:" in kind.__doc__


def test_drag_and_pair_forces_spare_a_fluid_that_is_not_named():
    water, grains = pc.Fluid(WATER, 0.1), pc.Particles([[2.0, 2.0]], radius=0.1)
    forces = (
        pc.Drag(1.0),
        pc.SoftSpheres(10.0),
        pc.LennardJones(1.0, 0.1),
        pc.Gravity((0.0, -1.0)),
        pc.Drag(1.0, on=water),
    )
    scene = pc.Scene(water, grains, *forces)
    assert [entry["on"] for entry in engine.describe(scene, check({}, scene))["forces"]] == [[1], [1], [1], None, [0]]
    assert scene.fluids == (water,)
    dry = pc.Scene(grains, *forces[:2])
    assert [entry["on"] for entry in engine.describe(dry, check({}, dry))["forces"]] == [None, None]


def test_the_engine_is_told_what_makes_a_fluid():
    scene = pc.Scene(pc.Fluid(WATER, 0.1, viscosity=0.0), pc.Particles([[2.0, 2.0]], name="dust"))
    method = pc.WeaklyCompressible(sound_speed=20.0, kernel=pc.CubicSpline(1.3), artificial_viscosity=0.02)
    described = engine.describe(scene, check({"fluids": method}, scene))["bodies"]
    columns = {"positions", "velocities", "mass", "charge", "radius", "fixed"}
    assert [entry["kind"] for entry in described] == ["Fluid", "Particles"]
    assert {name: value for name, value in described[0]["values"].items() if name not in columns} == {
        "spacing": 0.1,
        "density": 1000.0,
        "viscosity": 0.0,
        "surface_tension": 0.0,
        "obstacles": True,
        "method": {
            "kind": "WeaklyCompressible",
            "name": None,
            "on": None,
            "members": None,
            "values": {
                "sound_speed": 20.0,
                "kernel": {
                    "kind": "CubicSpline",
                    "name": None,
                    "on": None,
                    "members": None,
                    "values": {"smoothing": 1.3},
                },
                "artificial_viscosity": 0.02,
                "density_diffusion": 0.1,
                "density_from": "continuity",
                "shifting": "auto",
            },
        },
    }
    assert set(described[1]["values"]) == columns
    assert described[1]["name"] == "dust"


def brute(points: np.ndarray, distance: float) -> bool:
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    return bool((apart[np.triu_indices(len(points), 1)] < distance).any())


@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(0, 60),
    dimension=st.sampled_from([2, 3]),
    spread=st.sampled_from([1.0, 5.0, 1e9]),
)
def test_points_that_are_too_close_are_found_as_by_comparing_all(seed, count, dimension, spread):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.0, 1.0, (count, dimension)) * spread * rng.choice([1.0, 1e-9], (count, 1))
    distance = rng.uniform(0.05, 0.5)
    pair = closer_than(points, distance)
    assert (pair is not None) == brute(points, distance)
    if pair is not None:
        assert pair[0] < pair[1]
        assert np.linalg.norm(points[pair[0]] - points[pair[1]]) < distance


def test_a_hundred_thousand_points_in_one_place_are_refused_at_once():
    with pytest.raises(pc.SceneError, match="overlapping particles: 0 and 1 are 0 m apart"):
        pc.Fluid(np.zeros((100_000, 3)), 0.1)


def test_fluids_must_not_overlap_each_other_nor_themselves_across_the_domain():
    one, other = pc.Fluid(WATER, 0.1), pc.Fluid(np.add(WATER, (0.94, 0.01)), 0.1)
    with pytest.raises(pc.SceneError, match=r"bodies\[2\].positions: overlapping bodies: particles of bodies\[0\] and"):
        pc.Scene(one, pc.Particles([[0.05, 0.05]]), other)
    pc.Scene(one, pc.Fluid(np.add(WATER, (1.0, 0.0)), 0.1))
    pc.Scene(one, pc.Periodic((0.0, -math.inf), (1.0, math.inf)))
    with pytest.raises(pc.SceneError, match=r"overlapping bodies: particles of bodies\[0\], across the domain"):
        pc.Scene(one, pc.Periodic((0.0, 0.0), (1.0, 0.44)))


class Rising:
    """A world whose fluid gets denser by 1 kg/m³ in a second, with c = 10 m/s; all else is the engine's."""

    def __init__(self, *arguments: Any) -> None:
        self._world = engine_world(*arguments)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._world, name)

    def read(self, name: str) -> np.ndarray:
        density = np.concatenate([[math.nan], np.full(len(WATER), 1000.0 + self._world.time)])
        own = {"densities": density, "pressures": 100.0 * (density - 1000.0)}
        return own[name] if name in own else self._world.read(name)


engine_world = engine.World


@pytest.fixture
def pool(monkeypatch: pytest.MonkeyPatch) -> pc.Simulation:
    """A stone and the fluid, which drift apart: with time steps that frames at 10 per second do not fall on."""
    monkeypatch.setattr(engine, "World", Rising)
    stone = pc.Particles([[5.0, 5.0]], velocities=1.0, name="stone")
    scene = pc.Scene(stone, pc.Fluid(WATER, 0.1, name="water", obstacles=False))
    return pc.Simulation(scene, dt=0.003, fluids=pc.WeaklyCompressible(sound_speed=10.0))


def test_a_snapshot_of_a_fluid_has_densities_and_pressures(pool):
    pool.step(100)
    water = pool["water"]
    assert water.densities.shape == water.pressures.shape == (50,)
    np.testing.assert_allclose(water.densities, 1000.3)
    np.testing.assert_allclose(water.pressures, 30.0)
    for name in ("densities", "pressures"):
        with pytest.raises(pc.SceneError, match=f"{name}: only a Fluid has them"):
            getattr(pool["stone"], name)


def test_densities_and_pressures_are_recorded_and_saved(pool, tmp_path):
    """Between two steps they go straight from one to the other, which is exact here but for rounding."""
    recording = pool.record(1.0, fps=10.0, channels=("positions", "densities", "pressures"))
    recording.save(tmp_path / "pool.npz")
    loaded = pc.load(tmp_path / "pool.npz")
    assert isinstance(loaded, pc.Recording)
    for each in (recording, loaded):
        assert each.densities.shape == each.pressures.shape == (11, 51)
        assert np.isnan(each.densities[:, 0]).all()
        expected = np.tile(1000.0 + each.times[:, None], 50)
        np.testing.assert_allclose(each["water"].densities, expected, rtol=1e-14)
        np.testing.assert_allclose(each["water"].pressures, 100.0 * (expected - 1000.0), atol=1e-10)
        with pytest.raises(pc.SceneError, match="densities were not recorded"):
            _ = each["stone"].densities
    with pytest.raises(pc.SceneError, match="velocities were not recorded"):
        _ = recording.velocities


def test_frames_show_them_too(pool):
    frame = list(pool.frames(1.0, fps=10.0))[4]
    np.testing.assert_allclose(frame.densities[1:], 1000.4, rtol=1e-14)
    assert math.isnan(frame.pressures[0])


def test_fluids_are_computed_in_single_precision_unless_asked_otherwise():
    scene = pc.Scene(pc.Fluid(WATER, 0.1))
    assert [check({"precision": choice}, scene).precision for choice in ("auto", "f32", "f64")] == ["f32", "f32", "f64"]
    assert check({}, pc.Scene(pc.Particles([[0.0, 0.0]]))).precision == "f64"


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Fluid(WATER, 0.0), "Fluid.spacing: must be > 0"),
        (lambda: pc.Fluid(WATER, 0.1, density=-1.0), "Fluid.density: must be > 0"),
        (lambda: pc.Fluid(WATER, 0.1, viscosity=-1.0), "Fluid.viscosity: must be ≥ 0"),
        (lambda: pc.WeaklyCompressible(sound_speed=0.0), "WeaklyCompressible.sound_speed: must be > 0"),
        (lambda: pc.WeaklyCompressible(sound_speed="fast"), "WeaklyCompressible.sound_speed: .* or 'auto', got 'fast'"),
        (lambda: pc.WeaklyCompressible(kernel=pc.WendlandC2), r"WeaklyCompressible.kernel: .*write WendlandC2\(\)"),
        (lambda: pc.WeaklyCompressible(kernel="cubic"), "WeaklyCompressible.kernel: must be one of"),
        (
            lambda: pc.WeaklyCompressible(artificial_viscosity=-1),
            "WeaklyCompressible.artificial_viscosity: must be ≥ 0",
        ),
        (lambda: pc.WeaklyCompressible(density_diffusion=-1), "WeaklyCompressible.density_diffusion: must be ≥ 0"),
        (lambda: pc.Fluid(WATER, 0.1, surface_tension=-1), "Fluid.surface_tension: must be ≥ 0"),
        (lambda: pc.WeaklyCompressible(shifting=-1), "WeaklyCompressible.shifting: must be ≥ 0"),
        (
            lambda: pc.WeaklyCompressible(shifting=6.0, density_from="summation"),
            "WeaklyCompressible.shifting: must be 0 with density_from='summation'",
        ),
        (
            lambda: pc.Simulation(
                pc.Scene(pc.Fluid(WATER, 0.1, surface_tension=0.1)), fluids=pc.WeaklyCompressible(shifting=6.0)
            ),
            r"fluids\.shifting: expected 0 where there is surface tension",
        ),
        (
            lambda: pc.Simulation(
                pc.Scene(pc.Fluid(WATER, 0.1, surface_tension=0.1)),
                fluids=pc.WeaklyCompressible(kernel=pc.WendlandC2(0.7)),
            ),
            r"fluids\.kernel\.smoothing: expected at least 0.75 where there is surface tension, got 0.7",
        ),
        (lambda: pc.Fluid(WATER, 0.21), "Fluid.positions: overlapping particles: 0 and 1 are 0.1 m apart"),
        (lambda: pc.Fluid([1.0, 2.0], 0.1), r"Fluid.positions: must have the shape \(N, 2\) or \(N, 3\)"),
        (lambda: pc.WendlandC2(0.5), "WendlandC2.smoothing: must be ≥ 0.6"),
        (lambda: pc.block((0, 0), (1, 0.04), 0.1), r"block.upper\[1\]: must be at least one spacing"),
        (lambda: pc.block((0, 0), (1, 1, 1), 0.1), "block.upper: must have 2 components"),
        (lambda: pc.block((0, 0), (1, 1), -0.1), "block.spacing: must be > 0"),
        (lambda: pc.ball((0, 0), 0.01, 0.1), "ball.radius: a radius of 0.01 m has no room"),
        (lambda: pc.cylinder((0, 0), 1.0, 1.0, 0.1), "cylinder.center: must have 3 components"),
        (lambda: pc.cylinder((0, 0, 0), 1.0, 0.01, 0.1), "cylinder.height: must be at least one spacing"),
        (lambda: pc.Scene(pc.Fluid(WATER, 0.1), pc.Drag(1.0)), r"forces\[0\].on: Drag acts on fluids only where"),
    ],
)
def test_bad_input_is_refused_with_its_path(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()


@pytest.mark.parametrize("spacing", [1e200, 1e-200])
def test_a_particle_without_a_finite_mass_is_refused(spacing):
    """spacing² is neither below 1.8e308 nor above 4.9e-324."""
    with pytest.raises(pc.SceneError, match=r"^Fluid\.(spacing|density): "):
        pc.Fluid([[0.0, 0.0]], spacing)
