"""Ropes as tubes, particles as light, and paths in the colors of their particles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import physcore as pc
from physcore.film import DARK, LIGHT, Orbit, Window
from physcore.film.film_renderer import FilmRenderer
from physcore.film.labels.heading import Heading
from physcore.film.styles.tube import LAY, TubePainter, _transported
from physcore.simulation.sources import sources

SIZE = (320, 240)


def picture(scene: pc.Scene, style: Any, camera: Any, theme: Any = DARK, frame: int = 0) -> np.ndarray:
    """A frame of a film of a tenth of a second."""
    found = sources(pc.simulate(scene, 0.1, progress=False), None, None, {})
    with FilmRenderer(found, SIZE, style, camera, theme, Heading(), False, labels=()) as made:
        return [canvas.pixels().astype(int) for canvas in made.frames()][frame]


def ring(count: int, radius: float = 1.0) -> pc.SpringNetwork:
    """A closed rope in the x–y plane."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    points = radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    pairs = np.column_stack([np.arange(count), (np.arange(count) + 1) % count])
    return pc.SpringNetwork(points, pairs, stiffness=1.0)


def painter_of(scene: pc.Scene, **options: Any) -> TubePainter:
    found = sources(pc.simulate(scene, 0.1, progress=False), None, None, {})
    with FilmRenderer(found, SIZE, pc.styles.Tube(**options), None, DARK, Heading(), False) as made:
        (painter,) = made._painters[0]
    assert isinstance(painter, TubePainter)
    return painter


def test_a_tube_is_as_wide_as_its_radius_and_has_no_corners() -> None:
    """A ring of 12 particles: a polygon would cut 1 − cos 15° = 3.4 % of the radius off, the spline 0.02 %."""
    scene, radius = pc.Scene(ring(12)), 0.1
    camera = Orbit(azimuth=-90.0, elevation=90.0, target=(0.0, 0.0, 0.0), extent=2.4, field_of_view=0.0)
    flat = picture(scene, pc.styles.Tube("#ff0000", radius=radius), camera)
    red = flat[..., 0] > 2 * flat[..., 1] + 20
    rows, columns = np.nonzero(red)
    middle = np.array([columns.mean(), rows.mean()])
    away = np.hypot(columns - middle[0], rows - middle[1])
    scale = away.max() / (1.0 + radius)
    # Pixels are found to half a pixel, a hundredth of the scale.
    assert away.min() == pytest.approx((1.0 - radius) * scale, abs=1.5)
    angle = np.arctan2(rows - middle[1], columns - middle[0])
    sectors = ((angle + np.pi) / (2.0 * np.pi) * 48).astype(int) % 48
    outer = np.array([away[sectors == sector].max() for sector in range(48)])
    assert np.ptp(outer) < 0.015 * scale + 1.0


def test_strands_turn_once_in_their_lay() -> None:
    rope = pc.rope(30, length=1.0, stiffness=1.0, start=(0.0, 0.0, 0.0), direction=(1.0, 0.0, 0.0))
    painter = painter_of(pc.Scene(rope), radius=0.02, strands=3)
    line = np.column_stack([np.linspace(0.0, LAY * 0.04, 50), np.zeros(50), np.zeros(50)])
    rings, shades = painter._rings(line, *_transported(line, None), 0.02)
    np.testing.assert_allclose(rings[0] + line[-1] - line[0], rings[-1], atol=1e-12)
    assert not np.allclose(rings[0] + line[25] - line[0], rings[25], atol=1e-3)
    assert shades.min() < 0.7 < 0.99 < shades.max()


def test_frames_do_not_turn_about_the_line() -> None:
    """Along a helix of curvature κ and torsion τ, a frame that does not turn lags behind the normal by ∫τ ds."""
    t = np.linspace(0.0, 2.0 * np.pi, 4001)
    line = np.column_stack([np.cos(t), np.sin(t), 0.5 * t])
    normals, binormals = _transported(line, np.array([-1.0, 0.0, 0.0]))
    along = np.gradient(line, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    np.testing.assert_allclose(np.einsum("md,md->m", normals, along), 0.0, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(binormals, axis=1), 1.0, atol=1e-9)
    frenet = np.column_stack([-np.cos(t), -np.sin(t), np.zeros_like(t)])
    angle = np.unwrap(
        np.arctan2(np.einsum("md,md->m", normals, np.cross(along, frenet)), np.einsum("md,md->m", normals, frenet))
    )
    torsion, speed = 0.5 / 1.25, np.sqrt(1.25)
    # Double reflection has an error of O(h⁴) for each step, and gradients at the ends of O(h).
    assert abs(angle[-1] - angle[0]) == pytest.approx(torsion * speed * 2.0 * np.pi, abs=5e-3)


def test_a_broken_spring_ends_a_tube_and_a_ring_is_closed() -> None:
    for body, closed in ((ring(8), True), (pc.rope(8, length=1.0, stiffness=1.0), False)):
        painter = painter_of(pc.Scene(body), radius=0.02)
        (rope,) = painter._ropes
        assert rope.closed == closed
        whole = np.ones(len(rope.springs), dtype=np.bool_)
        assert [(len(part), ring_) for part, ring_ in rope.whole(whole)] == [(8, closed)]
        whole[[2, 4]] = False
        parts = [part.tolist() for part, _ in rope.whole(whole)]
        # Springs 2 and 4 are between particles 2–3 and 4–5.
        expected = [[3, 4], [5, 6, 7, 0, 1, 2]] if closed else [[0, 1, 2], [3, 4], [5, 6, 7]]
        assert sorted(map(sorted, parts)) == sorted(map(sorted, expected))


def test_a_tube_is_drawn_in_the_plane_too() -> None:
    rope = pc.rope(8, length=1.0, stiffness=1.0, start=(0.0, 0.0), direction=(1.0, 0.0), pinned="start")
    found, window = (
        sources(pc.simulate(pc.Scene(rope), 0.1, progress=False), None, None, {}),
        Window((-0.1, -0.5), (1.1, 0.5)),
    )
    style = pc.styles.Tube("#ff0000", radius=0.05)
    with FilmRenderer(found, SIZE, style, window, DARK, Heading(), False, labels=()) as made:
        seen, scale = next(iter(made.frames())).pixels().astype(int), made._panels[0].view.at(0).scale
    drawn = np.abs(seen - np.array(DARK.background)).sum(axis=2) > 12
    # A polygon of 14 sides is at least cos 13° = 0.974 as wide; each of the two edges is found to a pixel of 25.
    assert drawn.sum() == pytest.approx(1.0 * 0.1 * scale**2, rel=0.1)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"strands": 1}, "Tube.strands: must be 0 for a plain tube, or 2 to 12"),
        ({"strands": 13}, "Tube.strands: must be ≤ 12"),
        ({"radius": 0.0}, "Tube.radius: must be > 0"),
        ({"color": "nonsense"}, "Tube.color"),
    ],
)
def test_wrong_tubes_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(pc.SceneError, match=message):
        pc.styles.Tube(**options)


def test_a_cloth_is_no_rope() -> None:
    cloth = pc.cloth((4, 4), 0.1, 1.0)
    with pytest.raises(pc.SceneError, match=r"Tube\.on: .* is no rope; use Strain"):
        picture(pc.Scene(cloth), pc.styles.Tube(on=cloth), Orbit())


# Particles as light.


def stars(count: int = 400, **options: Any) -> pc.Particles:
    return pc.Particles(np.random.default_rng(1).normal(scale=0.1, size=(count, 2)), **options)


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_particles_shine_in_their_own_color(theme: Any) -> None:
    """Two clouds apart: on a dark ground each adds its color, on a light one each takes the other colors away."""
    near, far = stars(name="near"), pc.Particles(stars().positions + np.array([1.0, 0.0]), name="far")
    style = pc.styles.Density(color={"near": "#ff4020", "far": "#2060ff"}, spread=2.0, exposure=0.3)
    seen = picture(pc.Scene(near, far), style, Window((-0.5, -0.75), (1.5, 0.75)), theme)
    for column, strong, weak in ((80, 0, 2), (240, 2, 0)):
        around = seen[110:130, column - 10 : column + 10].reshape(-1, 3).mean(axis=0)
        assert around[strong] > around[weak] + 20.0
    assert (seen[5, 5] == theme.background).all()


def test_particles_without_a_color_show_their_density() -> None:
    scene = pc.Scene(stars())
    window = Window((-0.5, -0.375), (0.5, 0.375))
    seen = picture(scene, pc.styles.Density(), window)
    assert seen[100:140, 140:180].mean() > 4.0 * seen[:20, :20].mean()
    assert not np.array_equal(seen, picture(scene, pc.styles.Density(color="body"), window))


def test_density_draws_what_has_many_points() -> None:
    few, many = stars(20), stars(400)
    style = pc.styles.Density()
    assert [style.draws(body) for body in (few, many)] == [False, True]
    assert pc.styles.Density(on=few).draws(few)
    assert not style.draws(pc.rope(300, length=1.0, stiffness=1.0))
    cloud = pc.Tracers(np.zeros((300, 3)), pc.Lorenz())
    with pytest.raises(pc.SceneError, match=r"Density\.color: must be None for Tracers"):
        picture(pc.Scene(cloud), pc.styles.Density(color="red"), Orbit(target=(0.0, 0.0, 0.0), extent=2.0))
    with pytest.raises(pc.SceneError, match=r"Density\.on: must be"):
        pc.styles.Density(on=3)  # type: ignore[arg-type]


# Paths.


def test_paths_have_the_colors_of_their_points() -> None:
    body = pc.Particles([[0.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [1.0, 0.0]])
    window, colors = Window((-0.1, -0.5), (0.5, 1.5)), ["#ff0000", "#00ff00"]
    for style, expected in (
        ([pc.styles.Paths(), pc.styles.Points(colors, trail=0.0)], colors),
        ([pc.styles.Paths(color="#0000ff"), pc.styles.Points(colors, trail=0.0)], ["#0000ff"] * 2),
    ):
        found = sources(pc.simulate(pc.Scene(body), 0.1, progress=False), None, None, {})
        with FilmRenderer(found, SIZE, style, window, DARK, Heading(), False) as made:
            (paths,) = [each for each in made._painters[0] if each.traced is not None]
        drawn = paths._colors.argmax(axis=1).tolist()  # type: ignore[attr-defined]
        assert drawn == [["#ff0000", "#00ff00", "#0000ff"].index(each) for each in expected]
