"""Rigid bodies in films: where they are, how they are turned, what hides what, and their joints."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physcore as pc
from film.scripted import ABOVE, CENTERED, SIZE, at, covered, films, picture, recorded
from physcore.film import DARK, LIGHT, Corotating, Follow, Orbit, Window
from physcore.film.assignment import painters
from physcore.film.colors.light import lit
from physcore.film.film_renderer import FilmRenderer
from physcore.film.styles.base import FOG
from physcore.film.styles.solids import images
from physcore.simulation.sources import Recorded

PLANAR = {
    "disc": (pc.Disc(0.4), math.tau * 0.4),
    "rectangle": (pc.Rectangle(0.9, 0.5), 2.8),
    "capsule": (pc.Capsule(0.7, 0.2), 1.4 + math.tau * 0.2),
    "polygon": (pc.Polygon([(0.0, 0.0), (0.9, 0.0), (0.0, 0.7)]), 1.6 + math.hypot(0.9, 0.7)),
    "plus": (pc.Compound([(pc.Rectangle(0.9, 0.2), (0.0, 0.0)), (pc.Rectangle(0.2, 0.9), (0.0, 0.0))]), 3.6),
}


@pytest.mark.parametrize("angle", [0.0, 0.4])
@pytest.mark.parametrize("name", PLANAR)
def test_a_shape_covers_its_area(name: str, angle: float) -> None:
    """A rim of two pixels lies half outside, and each touched pixel counts: between 1 and 2 pixels along the outline.
    Where two parts overlap, the area counts once.
    """
    shape, length = PLANAR[name]
    shot = picture(pc.Scene(pc.RigidBody(shape, (0.1, -0.1), angle)))
    size = shape.area - (0.04 if name == "plus" else 0.0)
    extra = (np.count_nonzero(covered(shot)) - 1e4 * size) / (100.0 * length)
    assert 0.5 <= extra <= 2.5
    middle = np.argwhere(covered(shot)).mean(axis=0) + 0.5
    assert middle == pytest.approx([90.0, 110.0], abs=1.0)  # the center of mass


@pytest.mark.parametrize("shape", [pc.Disc(0.4), pc.Rectangle(0.6, 0.6), pc.Capsule(0.4, 0.2)])
def test_marks_show_a_rotation(shape: Any) -> None:
    """Turned by a sixth, and for all but the disc by a half, the picture is another one. Without a mark a disc turns
    invisibly, up to rounding.
    """
    scenes = [pc.Scene(pc.RigidBody(shape, (0.0, 0.0), angle)) for angle in (0.0, math.pi / 3, math.pi)]
    still, sixth, half = (picture(scene) for scene in scenes)
    assert np.abs(sixth - still).max() > 20.0
    changed = np.count_nonzero(np.abs(half - still).max(axis=2) > 10.0) / np.count_nonzero(covered(still))
    assert changed < 0.05 if isinstance(shape, pc.Disc) else changed > 0.5  # along edges, by rounding
    bare = [picture(scene, style=pc.styles.Solids(marks=False)) for scene in scenes]
    assert (np.abs(bare[1] - bare[0]).max() > 2.0) == (not isinstance(shape, pc.Disc))


@pytest.mark.parametrize("radius", [0.035, 0.015])
def test_small_discs_have_a_spoke_or_no_mark(radius: float) -> None:
    """At a radius of 3.5 pixels a line shows the angle; at 1.5 pixels there is nothing left to see."""
    shots = [picture(pc.Scene(pc.RigidBody(pc.Disc(radius), (0.0, 0.0), angle))) for angle in (0.0, 2.0)]
    assert (np.abs(shots[0] - shots[1]).max() > 5.0) == (radius > 0.025)


@pytest.mark.parametrize(
    "shape",
    [
        pc.Ball(0.4),
        pc.Cuboid(0.6, 0.6, 0.6),
        pc.Capsule(0.4, 0.2),
        pc.Hull(0.4 * np.array(list(itertools.product((-1, 1), repeat=3)))),
    ],
)
def test_marks_show_a_rotation_in_space(shape: Any) -> None:
    """Turned about the line of sight by less than the symmetry of the silhouette, the picture is another one."""
    turned = (math.cos(0.3), 0.0, 0.0, math.sin(0.3))
    shots = [
        picture(pc.Scene(pc.RigidBody(shape, (0.0, 0.0, 0.0), orientation=each)), ABOVE)
        for each in ((1, 0, 0, 0), turned)
    ]
    assert np.abs(shots[0] - shots[1]).max() > 20.0


def test_a_ball_in_space_covers_a_circle_and_is_lit_from_above() -> None:
    """The polygon around the ball, enlarged by half a pixel, deviates by less than a pixel; the lamp is upper left."""
    scene = pc.Scene(pc.RigidBody(pc.Ball(0.4), (0.2, 0.1, 0.0)))
    shot = picture(scene, ABOVE, style=pc.styles.Solids("#808080", marks=False))
    seen = (np.abs(shot - picture(pc.Scene(pc.RigidBody(pc.Ball(0.01), (0.7, -0.7, 0.0))), ABOVE)) > 6.0).any(axis=2)
    rows, columns = np.mgrid[0:160, 0:200] + 0.5
    away = np.hypot(columns - 120.0, rows - 70.0)
    assert seen[away < 39.0].all()
    assert not seen[(away > 41.5) & (away < 60.0)].any()
    assert at(shot, 0.0, 0.3).sum() > at(shot, 0.4, -0.1).sum() + 60.0


def prism(outline: list[tuple[float, float]], height: float) -> Any:
    """A closed mesh: an outline in the plane that is star-shaped about its first point, extruded along z."""
    count = len(outline)
    points = [(x, y, z) for z in (-0.5 * height, 0.5 * height) for x, y in outline]
    faces = [(0, k + 1, k) for k in range(1, count - 1)]
    faces += [tuple(count + corner for corner in face[::-1]) for face in faces]
    for k in range(count):
        after = (k + 1) % count
        faces += [(k, after, count + after), (k, count + after, count + k)]
    return pc.MeshShape(points, faces)


def seen(scene: pc.Scene, **options: Any) -> np.ndarray:
    """Whether each pixel, as seen from above, differs from an empty picture."""
    empty = picture(pc.Scene(pc.RigidBody(pc.Ball(0.01), (0.9, -0.7, 0.0))), ABOVE, **options)
    return (np.abs(picture(scene, ABOVE, **options) - empty) > 6.0).any(axis=2) & NEAR


NEAR = np.hypot(*(np.mgrid[0:160, 0:200] - np.array([80, 100])[:, np.newaxis, np.newaxis])) < 78.0
"""Pixels that are not near the small ball of the empty picture."""
SQUARE = [(-0.3, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2)]
CORNER = [(0.0, 0.0), (0.6, 0.0), (0.6, 0.2), (0.2, 0.2), (0.2, 0.6), (0.0, 0.6)]


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_a_mesh_is_drawn_as_the_cuboid_that_it_is(turn: float) -> None:
    """Up to the rounded edges of a polytope, which are lit otherwise, and half a pixel along the outline."""
    turned = (math.cos(0.5 * turn), math.sin(0.5 * turn), 0.0, 0.0)
    style = pc.styles.Solids("#808080", marks=False)
    shapes = prism(SQUARE, 0.3), pc.Cuboid(0.6, 0.4, 0.3)
    scenes = [pc.Scene(pc.RigidBody(shape, (0.0, 0.0, 0.0), orientation=turned)) for shape in shapes]
    mesh, cuboid = (picture(scene, ABOVE, style=style) for scene in scenes)
    one, other = (seen(scene, style=style) for scene in scenes)
    depth = 0.4 * math.cos(turn) + 0.3 * math.sin(turn)
    length = 200.0 * (0.6 + depth)
    assert np.count_nonzero(one != other) < 0.5 * length
    assert 0.0 <= np.count_nonzero(one) - 1e4 * 0.6 * depth <= 1.5 * length
    differ = np.abs(mesh - cuboid).max(axis=2) > 4.0
    assert np.count_nonzero(differ) < 0.3 * np.count_nonzero(one)
    middle = -0.15 * math.sin(turn)  # of the upper face
    assert at(mesh, 0.0, middle) == pytest.approx(at(cuboid, 0.0, middle), abs=2.0)


def test_a_mesh_with_a_notch_covers_its_silhouette_about_its_center_of_mass() -> None:
    """From above: the area of the outline, with each touched pixel along it. The notch stays free."""
    shape, place = prism(CORNER, 0.2), np.array([0.1, -0.05])
    shown = seen(pc.Scene(pc.RigidBody(shape, (*place, 0.0))), style=pc.styles.Solids("#808080"))
    assert 0.0 <= np.count_nonzero(shown) - 1e4 * shape.volume / 0.2 <= 1.5 * 100.0 * 2.4
    rows, columns = np.nonzero(shown)
    middle = np.array([columns.mean() + 0.5 - 100.0, 80.0 - rows.mean() - 0.5]) / 100.0
    assert middle == pytest.approx(place, abs=0.01)
    for x, y, inside in ((0.1, 0.1, True), (0.5, 0.1, True), (0.1, 0.5, True), (0.4, 0.4, False)):
        x, y = (x, y) - shape.center[:2] + place
        assert shown[round(80 - 100 * y), round(100 + 100 * x)] == inside


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_notebook_shows_rigid_bodies(dimension: int) -> None:
    shape = pc.Rectangle(0.3, 0.2) if dimension == 2 else prism(CORNER, 0.2)
    body = pc.RigidBody(shape, (0.0,) * (dimension - 1) + (0.5,))
    recording = pc.simulate(pc.Scene(body, pc.Floor(0.0), pc.Gravity()), 0.3)
    assert "data:image/gif;base64," in recording.show()._repr_html_()


def test_faces_toward_the_camera_are_lit_by_their_normals() -> None:
    """From above, the upper face of a cuboid looks up; tilted to the left by 0.6 rad, its normal is tilted too. In the
    middle of the depth of the scene, half of the fog is added.
    """
    gray = np.full((1, 3), 128.0)
    for angle in (0.0, -0.6):
        turned = (math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0)
        scene = pc.Scene(pc.RigidBody(pc.Cuboid(0.6, 0.6, 0.2), (0.0, 0.0, 0.0), orientation=turned))
        shot = picture(scene, ABOVE, style=pc.styles.Solids("#808080", marks=False))
        expected = lit(gray, np.array([[math.sin(angle), 0.0, math.cos(angle)]]))[0]
        expected = (1.0 - 0.5 * FOG) * expected + 0.5 * FOG * np.array(DARK.background)
        assert at(shot, 0.0, 0.0) == pytest.approx(expected, abs=3.0)


@pytest.mark.parametrize("order", [False, True])
def test_the_nearer_body_hides_the_farther_one(order: bool) -> None:
    """From above the higher one is seen, whichever comes first in the scene; cloths and particles likewise."""
    low = pc.RigidBody(pc.Cuboid(1.0, 1.0, 0.2), (0.0, 0.0, 0.0), name="low")
    high = pc.RigidBody(pc.Cuboid(0.5, 0.5, 0.2), (0.0, 0.0, 0.4), name="high")
    net = pc.cloth((3, 3), 0.2, 100.0, origin=(0.1, -0.2, 0.2), axes=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    dust = pc.Particles([[-0.35, -0.35, 0.3], [-0.35, 0.35, -0.3]], radius=0.06)
    items = [low, high, net, dust]
    solid = pc.styles.Solids({"low": "#ff0000", "high": "#00ff00"}, marks=False)
    style = [solid, pc.styles.Surface("#0000ff"), pc.styles.Points("#ffffff")]
    shot = picture(pc.Scene(*(items[::-1] if order else items)), ABOVE, style=style)
    assert at(shot, 0.0, 0.0).argmax() == at(shot, 0.2, 0.1).argmax() == 1  # the high one, over the cloth
    assert at(shot, 0.4, 0.0).argmax() == 2  # the cloth, over the low one
    assert at(shot, 0.4, 0.4).argmax() == at(shot, -0.35, 0.35).argmax() == 0  # the low one, over a particle
    assert at(shot, -0.35, -0.35).min() > 60.0  # a particle over the low one


def test_solids_cast_shadows_on_the_floor() -> None:
    """Beside a ball, away from the lamp, the floor is darker than without a ball."""
    floor, far = pc.Floor(0.0), pc.RigidBody(pc.Ball(0.01), (0.7, 0.7, 0.01))
    camera = Orbit(azimuth=-90.0, elevation=60.0, field_of_view=0.0, target=(0.0, 0.0, 0.0), extent=1.6)
    bare, shot = (
        picture(pc.Scene(*bodies, floor), camera)
        for bodies in ([far], [far, pc.RigidBody(pc.Ball(0.2), (0.0, 0.0, 0.3))])
    )
    darker = (bare - shot).sum(axis=2)[:, 100:] > 30.0
    assert np.count_nonzero(darker) > 300


def test_particles_are_drawn_over_bodies_and_bodies_over_boundaries() -> None:
    """In the plane, in whatever order the items are given."""
    items = [
        pc.Particles([[0.0, 0.0]], radius=0.05),
        pc.RigidBody(pc.Rectangle(0.6, 0.6), (0.0, 0.0)),
        pc.Plane((0.0, -0.1), (0.0, 1.0)),
    ]
    style = [pc.styles.Points("#ffffff", trail=0.0), pc.styles.Solids("#ff0000", marks=False)]
    for some in (items, items[::-1]):
        shot = picture(pc.Scene(*some), style=style)
        assert at(shot, 0.0, 0.0).min() > 250.0
        assert at(shot, 0.2, 0.2).argmax() == at(shot, 0.2, -0.2).argmax() == 0
        assert at(shot, 0.5, -0.3) == pytest.approx(DARK.surface)


def test_neighbors_differ_and_fixed_bodies_look_like_boundaries() -> None:
    """Bodies of one item have shades of one color, a fixed one that of the ground; a choice of the user holds."""
    bodies = pc.RigidBodies(pc.Disc(0.1), [(0.3 * k - 0.6, 0.0) for k in range(5)], fixed=[4], name="discs")
    scene = pc.Scene(bodies)
    shot = picture(scene, style=pc.styles.Solids(marks=False))
    colors = np.array([at(shot, 0.3 * k - 0.6, 0.0) for k in range(5)])
    assert (np.abs(np.diff(colors[:4], axis=0)).max(axis=1) > 12.0).all()
    assert np.abs(colors[:4] - np.mean(colors[:4], axis=0)).max() < 60.0
    assert colors[4] == pytest.approx(DARK.surface)
    chosen = picture(scene, style=pc.styles.Solids({"discs": "#ff0000"}, marks=False))
    assert at(chosen, 0.6, 0.0).argmax() == 0
    each = picture(scene, style=pc.styles.Solids(["red", "lime", "blue", "red", "lime"], marks=False))
    assert [int(at(each, 0.3 * k - 0.6, 0.0).argmax()) for k in range(5)] == [0, 1, 2, 0, 1]


def test_the_speed_of_bodies_is_shown_on_a_scale() -> None:
    """The scale begins at zero and ends at the given or the largest speed; a function gives values too."""
    bodies = pc.RigidBodies(pc.Disc(0.1), [(-0.5, 0.0), (0.5, 0.0)], velocities=[(0.0, 0.0), (3.0, 4.0)])
    recording = recorded(pc.Scene(bodies))
    source = Recorded(recording)
    (painter,) = painters(source, [pc.styles.Solids("speed")], DARK)
    painter.observe(next(source.frames()))
    assert painter.scale is not None
    assert (painter.scale.quantity, painter.scale.unit, painter.scale.ends) == ("speed", "m/s", (0.0, 5.0))
    shot = films(recording, pc.styles.Solids("speed", marks=False), CENTERED)[0]
    heights = films(recording, pc.styles.Solids(lambda time, x, v: np.hypot(*v.T), marks=False), CENTERED)[0]
    assert np.abs(at(shot, 0.5, 0.0) - at(shot, -0.5, 0.0)).max() > 60.0
    assert np.array_equal(shot, heights)
    index = films(recording, pc.styles.Solids("index", marks=False), CENTERED)[0]
    assert np.abs(at(index, 0.5, 0.0) - at(index, -0.5, 0.0)).max() > 30.0


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_whole_bodies_are_in_the_picture(dimension: int) -> None:
    """With the view found from the motion, no body reaches the edge of the picture, and they fill most of it."""
    shape = pc.Rectangle(2.0, 0.2) if dimension == 2 else pc.Cuboid(2.0, 0.2, 0.2)
    scene = pc.Scene(pc.RigidBody(shape, np.zeros(dimension), 0.7 if dimension == 2 else 0.0))
    for theme in (DARK, LIGHT):
        shot = films(recorded(scene), theme=theme, size=(160, 120))[0]
        edges = np.concatenate([shot[0], shot[-1], shot[:, 0], shot[:, -1]])
        bodies = np.abs(shot - shot[0, 0]).max(axis=2) > 40.0
        assert np.ptp(edges.sum(axis=1)) < 60.0  # the backdrop alone
        assert np.ptp(np.argwhere(bodies), axis=0).max() > 80


def test_a_large_fixed_body_is_scenery() -> None:
    """A ground of 100 m does not make what moves on it small."""
    box = pc.RigidBody(pc.Rectangle(0.4, 0.4), (0.0, 0.2), name="box")
    ground = pc.RigidBody(pc.Rectangle(100.0, 2.0), (0.0, -1.0), fixed=True)
    shot = films(recorded(pc.Scene(box, ground)), pc.styles.Solids({"box": "#ff0000"}, marks=False))[0]
    red = shot[..., 0] > shot[..., 2] + 60.0
    assert np.count_nonzero(red) > 1000
    # A post beside the motion is in the picture, with all its height.
    post = pc.RigidBody(pc.Rectangle(0.1, 0.5), (0.3, 0.25), fixed=True, name="post")
    shot = films(recorded(pc.Scene(box, post)), pc.styles.Solids({"box": "#ff0000", "post": "#00ff00"}, marks=False))[0]
    green = np.argwhere(shot[..., 1] > shot[..., 0] + 60.0)
    assert 0 < green.min(axis=0)[0] < 30
    assert np.ptp(green[:, 0]) == pytest.approx(5.0 * np.ptp(green[:, 1]), rel=0.25)


def test_a_camera_follows_a_body() -> None:
    """The followed body stays in the middle while it moves ten times its size."""
    ball = pc.RigidBody(pc.Disc(0.1), (0.0, 0.0), name="ball")
    scene = pc.Scene(ball, pc.Particles([[0.0, 1.0], [3.0, 1.0]]))
    moves = [{"rigid_positions": [[0.2 * k, 0.0]]} for k in range(11)]
    style = [pc.styles.Solids("#ff0000", marks=False), pc.styles.Points("#0000ff", trail=0.0)]
    for shot in films(recorded(scene, moves), style, Follow("ball", smoothing=0.0)):
        red = np.argwhere(shot[..., 0] > shot[..., 2] + 60.0)
        assert red.mean(axis=0) + 0.5 == pytest.approx([80.0, 100.0], abs=1.0)


def test_bodies_turn_against_a_corotating_frame() -> None:
    """A body that turns with the pair, a quarter between two frames, looks the same in both."""
    pair = pc.Particles([[-0.5, 0.0], [0.5, 0.0]], mass=1.0, name="pair")
    scene = pc.Scene(pair, pc.RigidBody(pc.Rectangle(0.2, 0.6), (0.0, 0.5), name="bar"))
    later = {"positions": [[0.0, -0.5], [0.0, 0.5]], "rigid_positions": [[-0.5, 0.0]], "angles": [0.5 * math.pi]}
    camera = Corotating(("pair", 0), ("pair", 1), CENTERED)
    style = pc.styles.Points("#ffffff", trail=0.0)
    first, second = films(recorded(scene, [{}, later]), style, camera)
    assert np.abs(first - second).mean() < 0.5


def test_bodies_across_a_face_of_the_domain_are_seen_on_both_sides() -> None:
    """A disc in the left face of a domain is in the right one too."""
    square = pc.Periodic((-0.5, -0.5), (0.5, 0.5))
    shot = picture(pc.Scene(pc.RigidBody(pc.Disc(0.1), (-0.48, 0.1)), square), style=pc.styles.Solids(marks=False))
    assert at(shot, 0.44, 0.1) == pytest.approx(at(shot, -0.44, 0.1))
    assert np.abs(at(shot, 0.44, 0.1) - at(shot, 0.0, 0.1)).max() > 60.0


def test_images_are_beyond_the_opposite_faces() -> None:
    """In the corner of a square domain there are three of them, along a line that is not periodic none."""
    square = pc.Periodic((0.0, 0.0), (1.0, 1.0))
    points, origins = images(square, np.array([[0.05, 0.98], [0.5, 0.5]]), 0.1)
    assert sorted(points[origins == 0].round(9).tolist()) == [[0.05, -0.02], [0.05, 0.98], [1.05, -0.02], [1.05, 0.98]]
    assert np.count_nonzero(origins == 1) == 1


def test_many_equal_bodies_are_drawn_in_few_calls() -> None:
    """The calls of the canvas do not depend on the number of bodies, in one item or one item each."""

    class Counter:
        calls = 0

        def __getattr__(self, name: str) -> Any:
            Counter.calls += 1
            return lambda *arguments: None

    counts = []
    shapes = [pc.Disc(0.01), pc.Rectangle(0.02, 0.01)]
    for number, single in ((5, False), (500, False), (50, True)):
        places = [np.random.default_rng(k).uniform(-0.7, 0.7, (number, 2)) for k in range(2)]
        if single:
            bodies = [pc.RigidBody(shape, point) for shape, some in zip(shapes, places, strict=True) for point in some]
        else:
            bodies = [pc.RigidBodies(shape, some) for shape, some in zip(shapes, places, strict=True)]
        source = Recorded(recorded(pc.Scene(*bodies)))
        (painter,) = painters(source, [pc.styles.Solids()], DARK)
        with FilmRenderer([source], SIZE, None, CENTERED, DARK, None, False) as film:
            view = film._panels[0].view.at(0)
        Counter.calls = 0
        painter.paint(Counter(), next(source.frames()), view, 3e4)  # type: ignore[arg-type]
        counts.append(Counter.calls)
    assert counts[0] == counts[1] == counts[2] > 0


@pytest.mark.parametrize("dimension", [2, 3])
def test_items_without_bodies_are_drawn(dimension: int) -> None:
    """A scene may have an item of no bodies."""
    shape = pc.Disc(0.1) if dimension == 2 else pc.Ball(0.1)
    scene = pc.Scene(pc.RigidBodies(shape, np.empty((0, dimension))), pc.RigidBody(shape, np.zeros(dimension)))
    assert len(films(recorded(scene))) == 1
    assert len(films(recorded(pc.Scene(pc.RigidBodies(shape, np.empty((0, dimension))))))) == 1


def test_pictures_of_a_simulation_are_those_of_its_recording(tmp_path: Path) -> None:
    """A film of a scene has the same bytes as one of its recording, and a renderer draws its last frame."""
    box = pc.RigidBodies(pc.Rectangle(0.2, 0.2), [(0.0, 0.5), (0.5, 0.5)], angular_velocities=2.0, name="boxes")
    scene = pc.Scene(box, pc.Gravity())
    window = Window((-1.0, -1.0), (1.0, 1.0))
    recording = pc.simulate(scene, 0.2, fps=10, dt=0.01)
    options: Any = {"size": SIZE, "camera": window, "legend": True, "name_tags": True, "scale_bar": True}
    for name, source, more in (
        ("one", recording, {}),
        ("two", recording, {}),
        ("three", scene, {"duration": 0.2, "fps": 10, "dt": 0.01}),
    ):
        pc.film(source, tmp_path / f"{name}.gif", **options, **more)
    films = [(tmp_path / f"{name}.gif").read_bytes() for name in ("one", "two", "three")]
    assert films[0] == films[1]
    simulation = pc.Simulation(scene, dt=0.01)
    simulation.run(0.2)
    renderer = pc.Renderer(scene, size=SIZE, camera=window, labels=())
    last = renderer.draw(simulation)
    assert covered(last.astype(float)).sum() > 300
    assert renderer.draw(pc.Simulation(scene, dt=0.01)).tobytes() != last.tobytes()


def test_a_tag_stands_beside_the_body_and_the_legend_has_its_color() -> None:
    """The name is written outside of the shape."""
    scene = pc.Scene(pc.RigidBody(pc.Disc(0.3), (0.0, 0.0), name="wheel"))
    bare, tagged = (picture(scene, name_tags=each) for each in (False, True))
    rows, columns = np.argwhere((bare != tagged).any(axis=2)).T
    assert len(rows) > 20
    assert (np.hypot(columns - 100.0, rows - 80.0) > 30.0).all()
    source = Recorded(recorded(scene))
    (painter,) = painters(source, [pc.styles.Solids("tomato")], DARK)
    assert painter.legend == [(scene.bodies[0], (255, 99, 71))]


def test_what_cannot_be_drawn_is_refused() -> None:
    """Each message names the argument."""
    ball, dust = pc.RigidBody(pc.Disc(0.1), (0.0, 0.0), name="ball"), pc.Particles([[0.0, 0.5]], name="dust")
    recording = recorded(pc.Scene(ball, dust))
    for style, match in (
        (pc.styles.Points(on="ball"), r"Points\.on: .*rigid bodies; draw it by Solids"),
        (pc.styles.Solids(on="dust"), r"Solids\.on: .*particles; draw it by Points"),
        (pc.styles.Solids(["red", "lime"]), r"Solids\.color: must be one, or 1"),
    ):
        with pytest.raises(pc.SceneError, match=match):
            films(recording, style)
    for arguments, match in (
        ({"color": "tepid"}, r"Solids\.color"),
        ({"marks": 1.5}, r"Solids\.marks"),
        ({"top": -1.0}, r"Solids\.top"),
        ({"forces": -1.0}, r"Solids\.forces"),
        ({"colormap": "mud"}, r"Solids\.colormap"),
    ):
        with pytest.raises(pc.SceneError, match=match):
            pc.styles.Solids(**arguments)
    for channel, style, match in (
        ("angles", pc.styles.Solids(), "angles of rigid bodies"),
        ("rigid_velocities", pc.styles.Solids("speed"), "rigid velocities"),
        ("joint_forces", pc.styles.Solids(forces=True), r"Solids\.forces"),
    ):
        lacking = recorded(pc.Scene(ball, dust))
        del lacking.channels[channel]
        with pytest.raises(pc.SceneError, match=match):
            films(lacking, style)


def test_a_relief_of_rigid_bodies_is_refused() -> None:
    """They have no shape in 3D."""
    wave = pc.Wave(pc.Grid((16, 16), 0.1), 1.0)
    scene = pc.Scene(pc.RigidBody(pc.Disc(0.1), (0.5, 0.5)), wave)
    with pytest.raises(pc.SceneError, match="style: a Relief"):
        pc.Renderer(scene, style=pc.styles.Relief())
