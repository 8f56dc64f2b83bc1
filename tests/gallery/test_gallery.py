"""The demos: each of them starts, and each shows the physics that it says it shows."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import physcore as pc
from physcore.checks import FloatArray
from physcore.gallery import DEMOS, costs, demo
from physcore.gallery.crystal import lattice_energy
from physcore.gallery.figure import Figure
from physcore.gallery.hourglass import GRAINS, HEIGHT

LONG = os.environ.get("PHYSCORE_TESTS") == "long"
QUICK = 5.0
"""Processor time of a demo, its film included, that is run whole in `make test` [s], at most."""
COSTS = costs()
FRAMES = 1
"""How many steps of a film the quick test simulates."""
FEWER: dict[str, dict[str, int]] = {
    "hourglass": {"grains": 500},
    "butterfly": {"tracers": 5000},
    "vortex_street": {"dye": 5000},
    "two_dams": {"particles": 2000},
}
"""Options of that test for demos that take seconds to begin."""


@pytest.mark.parametrize("name", DEMOS)
def test_every_demo_starts_and_writes_its_film(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = pc.simulate

    def beginning(scene: pc.Scene, duration: float, fps: float = 30.0, **numerics: object) -> pc.Recording:
        assert duration * fps > FRAMES
        return whole(scene, FRAMES / fps, fps, **numerics)  # type: ignore[arg-type]

    drawn = pc.film

    def first_frames(
        source: object, path: Path, *, duration: float | None = None, fps: float = 30.0, **options: object
    ) -> None:
        assert options["title"]
        assert options["subtitle"]
        given = {} if duration is None else {"duration": FRAMES / fps, "fps": fps}
        drawn(source, path, **given, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(pc, "simulate", beginning)
    monkeypatch.setattr(pc, "film", first_frames)
    for recording in demo(name).main(tmp_path / "film.gif", **FEWER.get(name, {})).values():
        assert len(recording.times) == FRAMES + 1
        assert np.isfinite(recording.positions).all()
    assert (tmp_path / "film.gif").read_bytes().startswith(b"GIF89a")


@pytest.fixture
def shown(
    tmp_path: Path, record_property: Callable[[str, object], None], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., pc.Recording]:
    """Runs a demo, whose film fits into a message and whose figure holds; gives its last recording. In `make test` the
    film, which takes longer than the physics, is left out.
    """
    if not LONG:
        monkeypatch.setattr(pc, "film", lambda *arguments, **options: None)

    def run(name: str, **options: int) -> pc.Recording:
        path = tmp_path / f"{name}.gif"
        recordings = demo(name).main(path, progress=False, **options)
        assert not LONG or path.stat().st_size <= 3e6
        figure = demo(name).figure(recordings)
        record_property("figure", str(figure))
        assert figure.holds
        return list(recordings.values())[-1]

    return run


WITH_MORE_TO_ASSERT = (
    "dam_break",
    "dam_break_3d",
    "splash",
    "lava",
    "rayleigh_taylor",
    "hourglass",
    "crystal",
    "curtain",
)
"""Demos of which more is asserted than their figures and budgets, each by a test below."""


@pytest.mark.parametrize(
    "name",
    [
        name if name in COSTS and COSTS[name].seconds <= QUICK else pytest.param(name, marks=pytest.mark.long)
        for name in DEMOS
        if name not in WITH_MORE_TO_ASSERT
    ],
)
def test_a_figure_holds_and_the_budget_closes(name: str, shown: Callable[[str], pc.Recording]) -> None:
    recording = shown(name)
    for budget in (recording.energy, *recording.budgets.values()):
        assert abs(budget.drift).max() < 0.02


@pytest.mark.long
def test_the_curtain_loses_energy_to_its_methods_alone(shown: Callable[[str], pc.Recording]) -> None:
    """Nothing but drag and damping dissipates; what backward Euler's equation takes beside is drift, downwards."""
    recording = shown("curtain")
    assert set(recording.energy.dissipated_by) >= {"drag", "damping"}
    assert recording.energy.drift[-1] < -0.05


def test_every_demo_is_run_whole() -> None:
    """Those that the test above leaves out are named in a call or in parameters."""
    source = Path(__file__).read_text(encoding="utf-8")
    assert [name for name in WITH_MORE_TO_ASSERT if f'("{name}"' not in source] == []


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
    # The rounding of single precision over hundreds of steps, of pressure and of tension; the ways are chaotic.
    assert sideways < 4e-5 * fall
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
    recording = shown("rayleigh_taylor")
    assert all_within(recording, (0.0, 0.0), (1.0, 2.0))
    drift = float(abs(recording.energy.drift).max())
    record_property("drift", drift)
    assert drift < 1e-3
    assert recording.energy.kinetic[-1] + recording.energy.dissipated[-1] == pytest.approx(lost(recording), rel=0.03)
    assert recording["heavy"].positions[-1, :, 1].min() < 0.2  # it nears the floor


@pytest.mark.long
@pytest.mark.parametrize("grains", [GRAINS, 4000])
def test_sand_runs_as_fast_at_the_end_as_at_the_start(
    grains: int, shown: Callable[..., pc.Recording], record_property: Callable[[str, object], None]
) -> None:
    """That is what makes an hourglass a clock (W. A. Beverloo et al., Chem. Eng. Sci. 15, 260, 1961).

    The weight of a meter of sand presses grains in by 2 ρ g H/k, 3 % of their radius; the last to land, at up to
    1.6 m/s, by v √(m/k), an eighth of it. Contacts begin at any place within a step, so that what they take is
    uncertain to order dt, 3e-3 of all.
    """
    recording = shown("hourglass", grains=grains)
    above = (recording.positions[..., 1] > 0.0).sum(axis=1)
    assert above[-1] == 0
    radii = np.concatenate([body.radius for body in recording.scene.bodies])
    assert (recording.positions[..., 1] > -HEIGHT + 0.99 * radii).all()
    running = (above < 0.8 * above[0]) & (above > 0.2 * above[0])
    times, left = recording.times[running], above[running]
    rate, start = np.polyfit(times, left, 1)
    off = float(abs(left - rate * times - start).max() / above[0])
    record_property("grains per second", -float(rate))
    record_property("farthest from a straight line", off)
    assert off < 0.01
    depths = overlaps(recording.positions[-1], radii)
    record_property(
        "overlap, of half of the contacts, of all but a hundredth, greatest",
        np.quantile(depths, [0.5, 0.99, 1.0]).tolist(),
    )
    assert np.quantile(depths, 0.99) < 0.05
    drift = float(abs(recording.energy.drift).max())
    record_property("drift", drift)
    assert drift < 3e-3


def overlaps(positions: FloatArray, radii: FloatArray) -> FloatArray:
    """Of all grains that touch, the overlap over the radius of the smaller one."""
    order = np.argsort(positions[:, 0])
    points, sizes = positions[order], radii[order]
    found, shift, reach = [], 1, 2.0 * radii.max()
    while shift < len(points) and (points[shift:, 0] - points[:-shift, 0]).min() < reach:
        apart = np.linalg.norm(points[shift:] - points[:-shift], axis=1)
        depth = (sizes[shift:] + sizes[:-shift] - apart) / np.minimum(sizes[shift:], sizes[:-shift])
        found.append(depth[depth > 0.0])
        shift += 1
    return np.concatenate(found)


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


def test_a_figure_is_a_line_that_shows_its_error() -> None:
    figure = Figure("period", 2.006, 2.0064, "by theory", 1e-3, "s")
    assert str(figure) == "period 2.00600 s, 2.00640 s by theory (off by 0.02 %, within 0.1 %)"
    assert str(Figure("growth", 1.2, 2.0, "by theory", 0.15)) == (
        "growth 1.20, 2.00 by theory (off by 40 %, more than 15 %)"
    )


@pytest.mark.parametrize("measured", [1.0, 1.02, 0.98, 1.0 + 1e-12])
def test_a_figure_holds_within_its_bound_on_both_sides(measured: float) -> None:
    assert Figure("ratio", measured, 1.0, "by theory", 0.021).holds
    assert str(Figure("ratio", measured, 1.0, "by theory", 0.021))


@pytest.mark.parametrize("measured", [1.03, 0.97, -1.0, np.nan, np.inf])
def test_a_figure_outside_its_bound_does_not_hold(measured: float) -> None:
    figure = Figure("ratio", measured, 1.0, "by theory", 0.021)
    assert not figure.holds
    assert "more than 2.1 %" in str(figure)
