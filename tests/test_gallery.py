"""The demos: each of them starts, and each shows the physics that it says it shows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import physcore as pc
from physcore.checks import FloatArray
from physcore.gallery import DEMOS, demo

FRAMES = 2
"""How many steps of a film the quick test simulates."""


@pytest.mark.parametrize("name", DEMOS)
def test_every_demo_starts_and_writes_its_film(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = pc.simulate

    def beginning(scene: pc.Scene, duration: float, fps: float = 30.0, **numerics: object) -> pc.Recording:
        assert duration * fps > FRAMES
        return whole(scene, FRAMES / fps, fps, **numerics)  # type: ignore[arg-type]

    monkeypatch.setattr(pc, "simulate", beginning)
    for recording in demo(name).main(tmp_path / "film.gif").values():
        assert len(recording.times) == FRAMES + 1
        assert np.isfinite(recording.positions).all()
    assert (tmp_path / "film.gif").read_bytes().startswith(b"GIF89a")


@pytest.fixture
def shown(tmp_path: Path) -> Callable[[str], pc.Recording]:
    """Runs a demo with one recording, whose film fits into a message."""

    def run(name: str) -> pc.Recording:
        path = tmp_path / f"{name}.gif"
        (recording,) = demo(name).main(path, progress=False).values()
        assert path.stat().st_size < 8e6
        return recording

    return run


def lost(recording: pc.Recording) -> float:
    """What the potential energy has fallen by [J]."""
    potential = recording.energy.by_term["gravity"]
    return float(potential[0] - potential[-1])


def all_within(recording: pc.Recording, lower: tuple[float, ...], upper: tuple[float, ...]) -> bool:
    """Whether no particle was outside a box, up to the rounding of numbers of that size in single precision."""
    rounding = 1e-6 * max(map(abs, (*lower, *upper)))
    inside = (recording.positions >= np.array(lower) - rounding) & (recording.positions <= np.array(upper) + rounding)
    return bool(inside.all())


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "upper"), [("dam_break", (4.0, 3.0)), ("dam_break_3d", (2.4, 0.88, 1.5))], ids=lambda value: str(value)
)
def test_water_behind_a_dam_turns_height_into_motion_and_heat(
    name: str,
    upper: tuple[float, ...],
    shown: Callable[[str], pc.Recording],
    record_property: Callable[[str, object], None],
) -> None:
    """No front is faster than that of a dry dam break, 2 √(g H) (A. Ritter, 1892)."""
    recording = shown(name)
    assert all_within(recording, (0.0,) * len(upper), upper)
    drift = float(abs(recording.energy.drift).max())
    record_property("drift", drift)
    assert drift < 0.02
    assert recording.energy.kinetic[-1] + recording.energy.dissipated[-1] == pytest.approx(lost(recording), rel=0.03)
    x = recording.positions[..., 0]
    front, height = x.max(axis=1), np.ptp(recording.positions[0, :, -1])
    reached = np.argmax(front > 0.9 * upper[0])
    speeds = np.diff(front[:reached]) * recording.fps
    record_property("front over √(gH)", float(speeds.max() / np.sqrt(9.81 * height)))
    assert speeds.max() < 2.0 * np.sqrt(9.81 * height)


@pytest.mark.long
def test_a_crown_is_thrown_up_evenly(
    shown: Callable[[str], pc.Recording], record_property: Callable[[str, object], None]
) -> None:
    """Nothing pushes sideways before the crown has reached a wall, so that no momentum is there."""
    recording = shown("splash")
    assert all_within(recording, (-0.5, -0.5, 0.0), (0.5, 0.5, 0.42))
    drift = float(abs(recording.energy.drift).max())
    record_property("drift", drift)
    assert drift < 0.01
    fall = float(abs(recording.momentum[0, 2]))
    sideways = float(abs(recording.momentum[recording.times < 0.15, :2]).max())
    record_property("sideways momentum", sideways / fall)
    assert sideways < 1e-5 * fall  # the rounding of single precision, over hundreds of steps
    highest = recording.positions[..., 2].max(axis=1)
    assert highest[recording.times > 0.1].max() > 0.2  # the crown is more than twice as high as the pool is deep


@pytest.mark.long
def test_lava_turns_its_fall_into_heat(
    shown: Callable[[str], pc.Recording], record_property: Callable[[str, object], None]
) -> None:
    recording = shown("lava")
    energy = recording.energy
    drift = float(abs(energy.drift).max())
    record_property("drift", drift)
    assert drift < 0.02
    assert energy.dissipated[-1] == pytest.approx(lost(recording), rel=0.03)
    assert energy.kinetic[-1] < 0.02 * energy.kinetic.max()
    downhill = recording.positions[..., 0].mean(axis=1)
    assert (np.diff(downhill) > 0.0).all()


@pytest.mark.long
def test_a_heavy_fluid_sinks_into_a_light_one(
    shown: Callable[[str], pc.Recording], record_property: Callable[[str, object], None]
) -> None:
    """From rest a ripple grows as a₀ cosh(√(A g k) t) (G. I. Taylor, 1950), A = 0.8/2.8 by the densities.

    Its amplitude a is what Σ cos(kx) over the heavy fluid says, −a/2 by area. In the first second viscosity takes νk² t
    from the exponent: 2μ/(ρ₁ + ρ₂) and αhc/8 together 0.05, so 5 % of the growth. The rest that is missing, less than
    twice as much, is what rows of the lattice withstand before they slip.
    """
    recording = shown("rayleigh_taylor")
    assert all_within(recording, (0.0, 0.0), (1.0, 2.0))
    drift = float(abs(recording.energy.drift).max())
    record_property("drift", drift)
    assert drift < 1e-3
    assert recording.energy.kinetic[-1] + recording.energy.dissipated[-1] == pytest.approx(lost(recording), rel=0.03)
    x = recording["heavy"].positions[..., 0]
    amplitude = -2.0 * np.cos(2.0 * np.pi * x).sum(axis=1) / 64.0**2
    second = int(np.argmin(abs(recording.times - 1.0)))
    growth = float(amplitude[second] / amplitude[0])
    expected = float(np.cosh(np.sqrt(0.8 / 2.8 * 2.0 * np.pi)))
    record_property("growth in a second over that of the linear theory", growth / expected)
    assert growth == pytest.approx(expected, rel=0.15)
    assert recording["heavy"].positions[-1, :, 1].min() < 0.2  # it nears the floor


@pytest.mark.long
def test_sand_runs_as_fast_at_the_end_as_at_the_start(
    shown: Callable[[str], pc.Recording], record_property: Callable[[str, object], None]
) -> None:
    """That is what makes an hourglass a clock (W. A. Beverloo et al., Chem. Eng. Sci. 15, 260, 1961)."""
    recording = shown("hourglass")
    above = (recording.positions[..., 1] > 0.0).sum(axis=1)
    assert above[-1] == 0
    radii = np.concatenate([body.radius for body in recording.scene.bodies])
    assert (recording.positions[..., 1] > -1.75 + 0.99 * radii).all()
    running = (above < 0.8 * above[0]) & (above > 0.2 * above[0])
    times, left = recording.times[running], above[running]
    rate, start = np.polyfit(times, left, 1)
    off = float(abs(left - rate * times - start).max() / above[0])
    record_property("grains per second", -float(rate))
    record_property("farthest from a straight line", off)
    assert off < 0.01
    deepest = np.array([overlap(positions, radii) for positions in recording.positions[::4]])
    record_property("overlap, typical and greatest", (float(np.median(deepest)), float(deepest.max())))
    assert deepest[-1] < 0.05
    assert np.median(deepest) < 0.05
    assert abs(recording.energy.drift).max() < 1e-3


def overlap(positions: FloatArray, radii: FloatArray) -> float:
    """The deepest overlap of two grains over the radius of the smaller one."""
    order = np.argsort(positions[:, 0])
    points, sizes = positions[order], radii[order]
    deepest, shift, reach = 0.0, 1, 2.0 * radii.max()
    while shift < len(points) and (points[shift:, 0] - points[:-shift, 0]).min() < reach:
        apart = np.linalg.norm(points[shift:] - points[:-shift], axis=1)
        depth = (sizes[shift:] + sizes[:-shift] - apart) / np.minimum(sizes[shift:], sizes[:-shift])
        deepest, shift = max(deepest, float(depth.max())), shift + 1
    return deepest


@pytest.mark.long
def test_atoms_freeze_into_a_hexagonal_lattice(
    shown: Callable[[str], pc.Recording], record_property: Callable[[str, object], None]
) -> None:
    """The energy of the best lattice is a sum over its sites; an atom at a surface lacks a third of its neighbors."""
    recording = shown("crystal")
    assert abs(recording.energy.drift).max() < 0.01
    assert abs(recording.momentum).max() < 1e-9
    atoms = recording.scene.particles
    bound = float(recording.energy.by_term["Lennard-Jones"][-1]) / atoms
    lattice = min(lattice_energy(distance) for distance in np.linspace(1.05, 1.2, 301))
    record_property("energy per atom over that of the lattice", bound / lattice)
    assert 0.75 * lattice > bound > lattice
    assert recording.energy.kinetic[-1] < 0.1 * recording.energy.kinetic[0]


def lattice_energy(distance: float) -> float:
    """Half the energy of an atom's bonds in a hexagonal lattice, with the shifted force of LennardJones [ε]."""
    steps = np.arange(-4, 5)
    i, j = (index.ravel() for index in np.meshgrid(steps, steps))
    apart = distance * np.sqrt(i * i + i * j + j * j)
    apart = apart[(apart > 0.0) & (apart < 2.5)]

    def uncut(r: FloatArray) -> FloatArray:
        return 4.0 * (r**-12 - r**-6)

    slope = 24.0 * (2.5**-7 - 2.0 * 2.5**-13)
    cut = np.array(2.5)
    return 0.5 * float((uncut(apart) - uncut(cut) - (apart - 2.5) * slope).sum())
