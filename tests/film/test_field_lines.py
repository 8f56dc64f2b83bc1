"""Field lines follow fields, equipotentials are where the potential has their values, and both refuse what has none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore.film.camera.view import View
from physcore.film.colors.themes import resolve
from physcore.film.styles.base import Painter
from physcore.film.styles.charges import Fields
from physcore.film.styles.equipotentials import contours
from physcore.film.styles.field_lines import FieldLinesPainter
from physcore.scene.rotations import rotation_of
from physcore.simulation.sources import SourceFrame, sources

COULOMB = pc.Coulomb().constant


def charges(*values: float, dimension: int = 2) -> pc.Particles:
    places = np.zeros((len(values), dimension))
    places[:, 0] = np.arange(len(values)) - 0.5 * (len(values) - 1)
    return pc.Particles(places, charge=1e-9 * np.array(values), fixed=True)


def view(dimension: int, half: float = 2.0) -> View:
    return View(np.eye(dimension), np.zeros(dimension), 200.0 / half, (200.0, 200.0), np.inf, half)


def painter(scene: pc.Scene, style: pc.styles.Style) -> tuple[Painter, SourceFrame]:
    (source,) = sources(scene, 0.0, 1.0, {"dt": 1.0})
    (found,) = style.painters(source, scene.bodies, resolve("dark"))
    return found, next(iter(source.frames()))


def lines(scene: pc.Scene, **options: Any) -> np.ndarray:
    found, frame = painter(scene, pc.styles.FieldLines(**options))
    assert isinstance(found, FieldLinesPainter)
    return found._found(frame, view(scene.dimension))


def test_lines_are_kept_while_the_camera_turns_and_found_anew_when_it_zooms_or_shifts():
    scene = pc.Scene(charges(1.0, -2.0, dimension=3), pc.Coulomb(softening=0.1))
    found, frame = painter(scene, pc.styles.FieldLines())
    assert isinstance(found, FieldLinesPainter)
    target = np.array([0.2, -0.3, 0.1])

    def seen(angle: float, half: float, place: np.ndarray) -> View:
        axes = rotation_of(np.array([0.3, 0.2, 1.0]) * angle)
        return View(axes, axes @ place, 200.0 / half, (200.0, 200.0), np.inf, half)

    first = found._found(frame, seen(0.0, 2.0, target))
    assert all(found._found(frame, seen(angle, 2.0, target)) is first for angle in (0.1, 0.7, 3.0))
    for other in (seen(3.0, 1.9, target), seen(3.0, 1.9, target + 0.1)):
        last, lines = found._lines, found._found(frame, other)
        assert lines is not last
        np.testing.assert_array_equal(lines, painter(scene, pc.styles.FieldLines())[0]._found(frame, other))


@pytest.mark.parametrize(
    ("scene", "field"),
    [
        (pc.Scene(charges(1.0, -1.0), pc.Coulomb()), "electric"),
        (pc.Scene(charges(1.0, -2.0, dimension=3), pc.Coulomb(softening=0.1)), "electric"),
        (pc.Scene(charges(1.0), pc.ElectromagneticField(electric=(3.0, 1.0))), "electric"),
        (pc.Scene(charges(0.0, dimension=3), pc.ElectromagneticField(magnetic=pc.CurrentLoop(1.0, 5.0))), "magnetic"),
        (
            pc.Scene(charges(0.0), pc.ElectromagneticField(lambda t, x: np.stack([-x[:, 1], x[:, 0]], axis=1))),
            "electric",
        ),
    ],
    ids=["dipole", "two charges in space", "uniform", "loop", "function"],
)
def test_lines_follow_the_field(scene, field):
    """A chord of a curve that bends by φ within a step is off its direction there by a part of φ²/24; steps are a
    ninetieth of the view, and lines near charges bend by less than one half.
    """
    found = lines(scene, field=field, lines=12)
    assert len(found) >= 6
    fields = Fields(scene, SourceFrame(0.0, {"positions": np.concatenate([body.positions for body in scene.bodies])}))
    chord = np.diff(found, axis=1)
    middle = 0.5 * (found[:, 1:] + found[:, :-1])
    there = np.isfinite(chord).all(axis=2)
    chord, middle = chord[there], middle[there]
    values = fields.at(field, middle)
    length, size = np.linalg.norm(chord, axis=1), np.linalg.norm(values, axis=1)
    cosine = (chord * values).sum(axis=1) / (length * size)
    assert np.median(1.0 - cosine) < 1e-4
    assert np.percentile(cosine, 1.0) > 0.99


def test_lines_are_as_many_as_charges_are_large_and_end_at_them():
    """All lines of the positive charge end at the negative one, to which as many more come from far away."""
    scene = pc.Scene(charges(1.0, -2.0), pc.Coulomb())
    found = lines(scene, lines=24)
    first = np.array([line[np.isfinite(line).all(axis=1)][0] for line in found])
    from_charge = np.linalg.norm(first - [-0.5, 0.0], axis=1) < 0.1
    assert from_charge.sum() == 12
    assert 10 <= (~from_charge).sum() <= 14


def test_lines_of_a_field_without_charges_keep_apart():
    found = lines(pc.Scene(charges(0.0), pc.ElectromagneticField(electric=(0.0, 1.0))), lines=10)
    columns = np.sort(np.nanmean(found[..., 0], axis=1))
    assert 5 <= len(found) <= 20
    assert np.diff(columns).min() > 0.5 * 4.0 / 22.0


def test_contours_are_where_a_function_has_its_levels():
    """Exactly where it is linear; else the error of linear interpolation is |f″| h²/8, 1/4 of a cell here."""
    x, y = np.indices((30, 20)).astype(float)
    cuts = contours(2.0 * x - 3.0 * y, np.array([0.5, 7.0]))
    values = 2.0 * cuts[..., 0] - 3.0 * cuts[..., 1]
    assert np.minimum(np.abs(values - 0.5), np.abs(values - 7.0)).max() < 1e-12
    circle = contours((x - 14.0) ** 2 + (y - 9.0) ** 2, np.array([49.0]))
    assert np.abs(((circle - [14.0, 9.0]) ** 2).sum(axis=2) - 49.0).max() <= 0.5
    length = np.linalg.norm(np.diff(circle, axis=1), axis=2).sum()
    assert length == pytest.approx(2 * np.pi * 7.0, rel=0.02)


def test_fields_at_points_are_those_of_charges_and_fields():
    body = charges(1.0, -3.0, 2.0, dimension=3)
    scene = pc.Scene(
        body,
        pc.Coulomb(softening=0.2),
        pc.ElectromagneticField(electric=(0.0, 0.0, 4.0), magnetic=(0.0, 0.5, 0.0)),
        pc.Gravity((0.0, 0.0, -9.81)),
    )
    run = pc.Simulation(scene, dt=1e-3)
    points = np.random.default_rng(2).uniform(-2.0, 2.0, (150, 3))
    apart = points[:, np.newaxis] - body.positions
    distance = np.sqrt((apart**2).sum(axis=2) + 0.04)
    electric = COULOMB * (body.charge[:, np.newaxis] * apart / distance[..., np.newaxis] ** 3).sum(axis=1) + [0, 0, 4.0]
    potential = COULOMB * (body.charge / distance).sum(axis=1) - 4.0 * points[:, 2]
    np.testing.assert_allclose(run.electric_field(points), electric, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(run.electric_potential(points), potential, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(run.magnetic_field(points), np.tile([0.0, 0.5, 0.0], (150, 1)))
    flat = pc.Simulation(pc.Scene(charges(1.0), pc.ElectromagneticField(magnetic=0.7)), dt=1e-3)
    np.testing.assert_array_equal(flat.magnetic_field([[0.0, 1.0], [2.0, 0.0]]), [0.7, 0.7])


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda run: run.electric_field([[0.5, 0.0]]), "particles in different places"),
        (lambda run: run.electric_field([0.5, 0.0]), r"electric_field\.points: must have the shape \(M, 2\)"),
        (lambda run: run.magnetic_field([[np.nan, 0.0]]), r"magnetic_field\.points\[0, 0\]: must be finite"),
    ],
)
def test_points_that_have_no_field_are_refused(ask, message):
    run = pc.Simulation(pc.Scene(charges(1.0, -1.0), pc.Coulomb()), dt=1.0)
    with pytest.raises(pc.SceneError, match=message):
        ask(run)


def test_a_function_has_no_potential_to_show():
    scene = pc.Scene(charges(1.0), pc.ElectromagneticField(lambda t, x: -x, potential=lambda x: 0.0))
    with pytest.raises(pc.SceneError, match=r"electric fields with a potential.*functions"):
        pc.Simulation(scene, dt=1e-3).electric_potential([[0.0, 1.0]])


@pytest.mark.parametrize(
    ("scene", "style", "message"),
    [
        (pc.Scene(charges(0.0)), pc.styles.FieldLines(), r"FieldLines\.field: this scene has no electric field"),
        (pc.Scene(charges(1.0), pc.Coulomb()), pc.styles.FieldLines("magnetic"), "no magnetic field"),
        (
            pc.Scene(charges(1.0), pc.ElectromagneticField(magnetic=1.0)),
            pc.styles.FieldLines("magnetic"),
            "in 2D the magnetic field points out of the plane",
        ),
        (pc.Scene(charges(1.0, dimension=3), pc.Coulomb()), pc.styles.Equipotentials(), "this scene is in 3D"),
        (pc.Scene(charges(0.0)), pc.styles.Equipotentials(), "Equipotentials: this scene has no electric field"),
    ],
)
def test_scenes_without_such_a_field_are_refused(scene, style, message, tmp_path: Path):
    with pytest.raises(pc.SceneError, match=message):
        pc.film(scene, tmp_path / "film.gif", duration=0.1, fps=10, dt=0.1, style=style)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pc.styles.FieldLines("gravity"), r"FieldLines\.field"),
        (lambda: pc.styles.FieldLines(lines=1), r"FieldLines\.lines"),
        (lambda: pc.styles.FieldLines(strength=1.5), r"FieldLines\.strength"),
        (lambda: pc.styles.Equipotentials(levels=0), r"Equipotentials\.levels"),
        (lambda: pc.styles.Equipotentials(levels=[]), r"Equipotentials\.levels"),
        (lambda: pc.styles.Equipotentials(width=0.0), r"Equipotentials\.width"),
    ],
)
def test_options_out_of_range_are_refused(make, message):
    with pytest.raises(pc.SceneError, match=message):
        make()


def test_they_are_drawn_below_what_moves(tmp_path: Path):
    """Lines and levels cover some of the picture, and the charges stay above them."""
    scene = pc.Scene(charges(1.0, -1.0), pc.Coulomb(softening=0.01))
    styles = [pc.styles.Equipotentials(levels=[-20.0, 0.0, 20.0]), pc.styles.FieldLines(), pc.styles.Points()]
    pc.film(scene, tmp_path / "film.png", duration=0.1, fps=10, dt=0.1, style=styles, size=(320, 240))
    plain = pc.film(scene, tmp_path / "plain.png", duration=0.1, fps=10, dt=0.1, size=(320, 240))
    pictures = [np.asarray(Image.open(path).convert("RGB")).astype(int) for path in (tmp_path / "film.png", plain.path)]
    changed = (np.abs(pictures[0] - pictures[1]).max(axis=2) > 20).mean()
    assert 0.03 < changed < 0.5
