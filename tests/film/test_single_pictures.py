"""Pictures of single states: as frames of a film where both know the same; nothing of the simulation changes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc

SIZE = (200, 150)
DURATION = 0.4


def cloth() -> pc.Scene:
    body = pc.cloth((10, 8), 0.1, 100.0, mass=0.01, axes=((1, 0, 0), (0, 1, 0)), name="cloth", pinned="left")
    return pc.Scene(body, pc.Gravity(), pc.Floor(-1.0))


def fluid() -> pc.Scene:
    return pc.Scene(pc.Fluid(pc.block((0, 0), (0.3, 0.4), 0.05), 0.05), pc.Box((0, 0), (1.0, 0.8)), pc.Gravity())


def wave() -> pc.Scene:
    return pc.Scene(pc.Wave(pc.Grid((32, 24), 0.05), 1.0, displacement=lambda x, y: np.exp(-8 * (x**2 + y**2))))


def orbits() -> pc.Scene:
    bodies = pc.Particles([[0, 0], [1, 0]], velocities=[[0, 0], [0, 1]], mass=[1.0, 1e-3], name="pair")
    return pc.Scene(bodies, pc.Gravitation(1.0))


def packet() -> pc.Scene:
    grid = pc.Grid((32, 24), 0.2)
    return pc.Scene(pc.Schrodinger(grid, pc.wave_packet(grid, (2.0, 2.4), (2.0, 0.0), 0.5)))


def tracers() -> pc.Scene:
    return pc.Scene(pc.Tracers([[1.0, 1.0, 1.0], [1.1, 1.0, 1.0]], pc.Lorenz()))


def boxes() -> pc.Scene:
    body = pc.RigidBodies(pc.Rectangle(0.3, 0.2), [(0.4, 0.5), (1.2, 0.3)], [0.3, 0.0], angular_velocities=2.0)
    return pc.Scene(body, pc.Hinge((body, 1), None, (1.0, 0.3)), pc.Floor(-0.1), pc.Gravity())


def wedges() -> pc.Scene:
    """Two bodies of one mesh, a wedge, and a ball on a floor."""
    corners = [(0, 0, 0), (0.6, 0, 0), (0.6, 0.4, 0), (0, 0.4, 0), (0, 0, 0.4), (0, 0.4, 0.4)]
    faces = [(0, 3, 2), (0, 2, 1), (0, 4, 5), (0, 5, 3), (1, 2, 5), (1, 5, 4), (0, 1, 4), (2, 3, 5)]
    wedge = pc.RigidBodies(
        pc.MeshShape(corners, faces), [(0.0, 0.0, 0.4), (0.0, 0.8, 0.5)], angular_velocities=(1.0, 0.0, 2.0)
    )
    return pc.Scene(wedge, pc.RigidBody(pc.Ball(0.2), (0.8, 0.0, 0.3)), pc.Floor(0.0), pc.Gravity())


AROUND, FLAT = pc.Orbit(target=(0, 0, 0), extent=3.0), pc.Window((-0.2, -0.2), (2.0, 1.6))
GIVEN: dict[str, tuple[Any, dict[str, Any]]] = {
    "cloth": (cloth, {"camera": AROUND, "style": pc.styles.Surface(range=0.1)}),
    "fluid": (fluid, {"camera": FLAT, "style": pc.styles.Fluid(top=1.0)}),
    "wave": (wave, {"camera": FLAT, "style": pc.styles.Field(range=0.2)}),
    "orbits": (orbits, {"camera": FLAT, "style": [pc.styles.Paths(), pc.styles.Points(top=1.0, trail=0.2)]}),
    "packet": (packet, {"style": pc.styles.Phase(range=0.3)}),
    "tracers": (tracers, {"camera": pc.Orbit(target=(0, 0, 25), extent=60.0), "style": pc.styles.Trails()}),
    "turning": (cloth, {"camera": lambda time: pc.Orbit(azimuth=90 * time, target=(0, 0, 0), extent=3.0)}),
    "labels": (orbits, {"camera": FLAT, "labels": ("time", "dt", "energy"), "name_tags": True, "scale_bar": True}),
    "boxes": (boxes, {"camera": FLAT}),
    "wedges": (wedges, {"camera": AROUND, "style": pc.styles.Solids("teal")}),
    "diagram": (orbits, {"camera": FLAT, "inset": "energy", "style": pc.styles.Points("body")}),
}
"""Scenes with options that leave nothing open to be found from the whole motion."""


def film(recording: pc.Recording, path: Path, **options: Any) -> np.ndarray:
    """The last frame of a film."""
    recording.film(path, size=SIZE, **options)
    return np.asarray(Image.open(path).convert("RGB"))


@pytest.mark.parametrize("name", GIVEN)
def test_a_picture_is_the_frame_of_a_film(name: str, tmp_path: Path) -> None:
    """In all but the diagram, whose range of energies a film knows before."""
    scene, options = GIVEN[name][0](), GIVEN[name][1]
    if name == "turning":
        options = {**options, "style": pc.styles.Surface(color="tomato")}
    renderer = pc.Renderer(scene, size=SIZE, duration=DURATION, **options)
    for frame in pc.Simulation(scene).frames(DURATION):
        drawn = renderer.draw(frame)
    expected = film(pc.simulate(scene, DURATION), tmp_path / "film.png", **options)
    assert drawn.shape == expected.shape == (SIZE[1], SIZE[0], 3)
    assert drawn.dtype == np.uint8
    differ = (drawn != expected).any(axis=2)
    assert differ.mean() < (0.15 if name == "diagram" else 1e-9)
    assert len(np.unique(drawn.reshape(-1, 3), axis=0)) > 20


@pytest.mark.parametrize("name", GIVEN)
def test_drawing_changes_no_bit_and_twice_gives_the_same_pixels(name: str) -> None:
    scene, options = GIVEN[name][0](), GIVEN[name][1]
    drawn, alone = pc.Simulation(scene, dt=1e-3), pc.Simulation(scene, dt=1e-3)
    renderer = pc.Renderer(scene, size=SIZE, **options)
    for _ in range(12):
        drawn.run(0.02)
        first, second, again = renderer.draw(drawn), renderer.draw(drawn), renderer.draw(drawn.frame())
        assert np.array_equal(first, second)
        assert np.array_equal(first, again)
    alone.run(0.24)
    assert drawn.state_hash() == alone.state_hash()
    first[:] = 0
    assert renderer.draw(drawn).any(), "the picture belongs to the caller"


@pytest.mark.parametrize("name", ["cloth", "fluid", "orbits"])
def test_the_view_of_the_first_state_stays_until_reset(name: str) -> None:
    """A picture in the view of a state, and then of a later one."""
    scene = GIVEN[name][0]()
    options: dict[str, Any] = {"size": SIZE, "style": pc.styles.Points("tomato", size=3.0, trail=0.0), "labels": ()}
    simulation = pc.Simulation(scene)
    renderer, fresh = (pc.Renderer(scene, **options) for _ in range(2))
    first = renderer.draw(simulation)
    simulation.run(0.5)
    later, framed = renderer.draw(simulation), fresh.draw(simulation)
    assert not np.array_equal(later, first)
    assert not np.array_equal(later, framed)
    renderer.reset()
    assert np.array_equal(renderer.draw(simulation), framed)
    assert np.array_equal(renderer.draw(pc.Simulation(scene)), start_in(fresh, scene))


def start_in(renderer: pc.Renderer, scene: pc.Scene) -> np.ndarray:
    """The start of a scene, in the view that the renderer has."""
    return renderer.draw(pc.Simulation(scene))


def test_a_container_is_seen_whole_before_the_water_has_reached_its_end() -> None:
    """The box is three times as wide as the water: a vertical edge of it is to the right of the middle."""
    picture = pc.Renderer(fluid(), size=SIZE, labels=(), color_bar=False).draw(pc.Simulation(fluid()))
    edges = (picture != np.array(pc.DARK.background)).any(axis=2)
    assert edges[:, SIZE[0] // 2 :].sum(axis=0).max() > 40


def test_colors_go_as_far_as_the_states_that_were_drawn() -> None:
    """A ball at rest that falls: the end of the scale is its speed g t in each new picture."""
    scene = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravity())
    renderer, simulation = pc.Renderer(scene, size=SIZE), pc.Simulation(scene)
    renderer.draw(simulation)
    for _ in range(3):
        simulation.run(0.1)
        renderer.draw(simulation)
        assert renderer._painters[0][0].top == pytest.approx(9.81 * simulation.time, rel=0.01)


def test_trails_are_of_the_states_before_at_their_times() -> None:
    """On a circle, arcs through states a fourteenth and a seventh of a turn apart are equally near it: θ⁴/384."""
    scene = pc.Scene(pc.Particles([[1.0, 0.0]], velocities=[[0.0, 1.0]]), pc.CentralForce((0.0, 0.0), 1.0, 1.0))
    renderer = pc.Renderer(scene, size=SIZE, style=[pc.styles.Paths(), pc.styles.Points()])
    simulation = pc.Simulation(scene, integrator="RungeKutta4", dt=0.005)
    for interval in (0.0, 0.45, 0.9, 0.45):
        simulation.run(interval)
        renderer.draw(simulation)
    past: Any = next(painter for painter in renderer._painters[0] if isinstance(painter.style, pc.styles.Paths))._past
    points = np.concatenate([piece.points for piece in past._pieces])
    assert len(points) == 1 + 3 * 6
    assert abs(np.linalg.norm(points, axis=2) - 1.0).max() < 1.1 * 0.9**4 / 384


def test_an_earlier_state_begins_trails_anew() -> None:
    scene = orbits()
    renderer, simulation = pc.Renderer(scene, size=SIZE, camera=FLAT), pc.Simulation(scene)
    start = renderer.draw(simulation)
    for _ in range(5):
        simulation.run(0.1)
        renderer.draw(simulation)
    assert np.array_equal(renderer.draw(pc.Simulation(scene)), start)


def test_a_state_of_another_scene_is_drawn_in_the_same_view() -> None:
    """A floor that is added does not move the cloth in the picture."""
    before, after = cloth(), pc.Scene(*cloth().bodies, pc.Gravity())
    style = pc.styles.Surface(color="tomato")
    renderer = pc.Renderer(before, size=SIZE, style=style)
    renderer.draw(pc.Simulation(before))
    view = renderer._panels[0].view.at(0)
    picture = renderer.draw(pc.Simulation(after))
    other = renderer._panels[0].view.at(0)
    assert (view.scale, view.middle, view.distance) == (other.scale, other.middle, other.distance)
    assert np.array_equal(view.center, other.center)
    assert renderer.scene is after
    assert not np.array_equal(picture, pc.Renderer(after, size=SIZE, style=style).draw(pc.Simulation(after)))


@pytest.mark.parametrize(
    "camera",
    [
        pc.Follow("cloth"),
        pc.Follow("cloth", lambda time: pc.Orbit(azimuth=60 * time)),
        lambda time: pc.Orbit(90 * time),
    ],
)
def test_a_camera_moves_without_a_film(camera: Any) -> None:
    """It follows a cloth that falls; the direction changes with time, and the scale does not."""
    scene = pc.Scene(pc.cloth((6, 5), 0.1, 100.0, mass=0.01, axes=((1, 0, 0), (0, 1, 0)), name="cloth"), pc.Gravity())
    renderer, simulation, scales = pc.Renderer(scene, size=SIZE, camera=camera), pc.Simulation(scene), []
    for _ in range(4):
        renderer.draw(simulation)
        view = renderer._view(renderer._panels[0], renderer._last[0])  # type: ignore[index]
        scales.append(view.scale)
        if isinstance(camera, pc.Follow):
            middle = view.project(simulation.positions.mean(axis=0)[np.newaxis])[0][0]
            assert middle == pytest.approx(view.middle, abs=0.01)
        simulation.run(0.1)
    assert scales == pytest.approx([scales[0]] * 4)


@pytest.mark.parametrize(
    ("state", "options", "words"),
    [
        (lambda simulation: 3, {}, "draw.state: must be a Simulation, or a Frame"),
        (lambda simulation: simulation["pair"], {}, "of a whole scene"),
        (lambda simulation: simulation.frame(), {"labels": ("integrator",)}, "'integrator' needs a Simulation"),
        (lambda simulation: bare(simulation), {"labels": ("dt",)}, "'dt' needs a Frame or a Simulation"),
        (lambda simulation: bare(simulation), {"inset": "energy"}, "the inset needs a Frame or a Simulation"),
    ],
)
def test_what_cannot_be_drawn_is_refused(state: Any, options: dict[str, Any], words: str) -> None:
    simulation = pc.Simulation(orbits())
    with pytest.raises(pc.SceneError, match=words):
        pc.Renderer(simulation.scene, size=SIZE, **options).draw(state(simulation))


def bare(simulation: pc.Simulation) -> pc.Snapshot:
    """The state of a simulation without energies."""
    frame = simulation.frame()
    return pc.Snapshot(frame.time, frame.fields, scene=frame.scene)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"size": (3, 4)}, "size"),
        ({"fps": 0.0}, "fps"),
        ({"duration": -1.0}, "duration"),
        ({"style": "red"}, "style"),
        ({"legend": "Mars"}, "legend"),
        ({"camera": pc.Orbit()}, "camera"),
        ({"quality": "best"}, "quality"),
        ({"theme": "blue"}, "theme"),
    ],
)
def test_options_are_those_of_films(options: dict[str, Any], words: str) -> None:
    with pytest.raises(pc.SceneError, match=words):
        pc.Renderer(orbits(), **options).draw(pc.Simulation(orbits()))


def test_a_present_frame_is_that_of_a_recording() -> None:
    """The one at the end, in all fields and budgets."""
    simulation = pc.Simulation(fluid())
    *_, last = simulation.frames(0.1)
    present = simulation.frame()
    assert present.time == pytest.approx(last.time)
    assert present.energy.total == last.energy.total
    for name in ("positions", "velocities", "densities", "pressures"):
        assert np.array_equal(present.fields[name], last.fields[name]), name


@pytest.mark.parametrize("camera", [None, pc.Orbit(azimuth=10.0, extent=3.0, target=(0.0, 0.0, 0.5))])
def test_a_turned_renderer_is_one_with_another_camera(camera):
    """The same picture as that of a renderer whose Orbit had the angles and the extent from the start, but for what the
    automatic view leaves open; its target and scale stay. Turning back gives the first picture again.
    """
    scene = pc.Scene(pc.Particles([[0.0, 0.0, 0.3], [1.0, 0.5, 1.0]], radius=0.2), pc.Floor())
    simulation, renderer = pc.Simulation(scene), pc.Renderer(scene, size=(160, 120), camera=camera)
    with pytest.raises(pc.SceneError, match="turn: needs a camera at rest that has drawn a picture"):
        renderer.turn(10.0)
    first, before = renderer.draw(simulation), renderer.view
    renderer.turn(azimuth=25.0, elevation=15.0, zoom=2.0)
    other, after = renderer.draw(simulation), renderer.view
    np.testing.assert_allclose(after.axes.T @ after.center, before.axes.T @ before.center, atol=1e-12)
    assert after.scale == pytest.approx(2.0 * before.scale, rel=1e-6)
    if camera is not None:
        exact = replace(camera, azimuth=35.0, elevation=35.0, extent=1.5)
        again = pc.Renderer(scene, size=(160, 120), camera=exact)
        again.draw(simulation)
        np.testing.assert_allclose(again.view.axes, after.axes, atol=1e-12)
        assert again.view.scale == pytest.approx(after.scale)
    assert (other != first).any()
    renderer.turn(azimuth=-25.0, elevation=-15.0, zoom=0.5)
    np.testing.assert_array_equal(renderer.draw(simulation), first)
    with pytest.raises(pc.SceneError, match=r"turn.zoom: must be .*, got 0"):
        renderer.turn(zoom=0.0)
