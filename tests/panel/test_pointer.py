"""From pixels to meters and back."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import physcore as pc
from physcore.film.renderer import Renderer
from physcore.panel.artist import Picture
from physcore.panel.pointer import moved, picked, rolled
from physcore.panel.requests import Desk
from physcore.scene.rotations import rotation_of


def drawn(scene, **options):
    renderer = Renderer(scene, size=(320, 240), **options)
    simulation = pc.Simulation(scene)
    pixels = renderer.draw(simulation)
    return Picture(pixels, simulation.frame(), renderer.view, None)


FLAT = pc.Scene(pc.Particles([[0.0, 0.0], [1.0, 0.0], [0.5, 0.8]], fixed=[2], name="dots"))
DEEP = pc.Scene(pc.Particles([[0.0, 0.0, 0.0], [1.0, 2.0, 0.5], [0.5, 0.8, 1.0]], name="dots"))


@pytest.mark.parametrize(
    ("scene", "camera"),
    [
        (FLAT, None),
        (DEEP, pc.Orbit(azimuth=20.0, elevation=30.0, field_of_view=60.0)),
        (DEEP, pc.Orbit(azimuth=-70.0, elevation=80.0, field_of_view=0.0)),
    ],
    ids=["2D", "perspective", "parallel"],
)
def test_a_moved_pointer_is_under_its_pixel_and_as_far_away_as_before(scene, camera):
    view = drawn(scene, camera=camera).view
    before = scene.bodies[0].positions[1]
    for pixel in [(10.0, 20.0), (300.0, 7.5), (161.2, 239.0)]:
        point = moved(view, tuple(before.tolist()), *pixel)
        pixels, depths, _ = view.project(np.array([point, before]))
        np.testing.assert_allclose(pixels[0], pixel, atol=2e-4)  # projections have single precision
        if depths is not None:
            # Depths along the line of sight: those of the plane through the pointer are equal.
            along = (np.array([point, before]) @ view.axes[2]).round(12)
            assert along[0] == pytest.approx(along[1], abs=1e-5)


def test_the_nearest_free_element_is_picked_and_none_that_is_far():
    picture = drawn(FLAT)
    body = FLAT.bodies[0]
    pixels, _, _ = picture.view.project(body.positions)
    for index in (0, 1):
        assert picked(picture, *(pixels[index] + 3.0).tolist()) == (body, index)
    assert picked(picture, *pixels[2].tolist()) is None  # it is fixed, and the others are far away
    assert picked(picture, -500.0, 0.0) is None


def test_indices_count_within_their_body_and_rigid_bodies_too():
    stones = pc.RigidBodies(pc.Disc(0.1), [(0.0, 2.0), (1.0, 2.0)], name="stones")
    dots = pc.Particles([[0.0, 0.0], [1.0, 0.0]], name="dots")
    for scene in (pc.Scene(stones, dots), pc.Scene(dots, stones)):
        picture = drawn(scene)
        for body in scene.bodies:
            pixels, _, _ = picture.view.project(body.positions)
            for index in range(2):
                assert picked(picture, *pixels[index].tolist()) == (body, index)


def test_a_large_body_is_picked_by_its_end_and_what_lies_on_it_by_itself():
    plank = pc.RigidBody(pc.Rectangle(2.0, 0.2), (0.0, 0.0), name="plank")
    scene = pc.Scene(plank, pc.Particles([[0.6, 0.16]], radius=0.05))
    picture = drawn(scene)
    ends, _, magnification = picture.view.project(np.array([[-0.8, 0.0], [0.61, 0.16], [0.0, 1.3]]))
    assert 0.8 * magnification[0] > 0.06 * 320.0  # the end is far from the center
    found = [picked(picture, *end.tolist()) for end in ends]
    assert found == [(scene.bodies[0], 0), (scene.bodies[1], 0), None]


def test_what_is_held_rolls_under_the_mouse():
    """The side that is seen moves with the mouse; in 2D a wheel on the ground rolls in its direction."""
    assert rolled(drawn(FLAT), 120.0, 30.0) == pytest.approx([-np.pi / 2.0])
    picture = drawn(DEEP, camera=pc.Orbit(azimuth=20.0, elevation=30.0, field_of_view=0.0))
    right, up, toward = picture.view.axes
    for across, down, expected in ((120.0, 0.0, right), (0.0, 120.0, -up)):
        vector = rolled(picture, across, down)
        assert np.linalg.norm(vector) == pytest.approx(np.pi / 2.0)
        np.testing.assert_allclose(rotation_of(vector) @ toward, expected, atol=1e-9)


def test_a_scene_of_fields_has_nothing_to_pick():
    assert picked(drawn(pc.Scene(pc.Wave(pc.Grid((8, 8), 0.1), 1.0))), 100.0, 100.0) is None


class Physics:
    """A thread of physics that only keeps what it is asked for, and is itself the session."""

    def __init__(self, scene):
        self.scene, self.held = scene, []

    def post(self, request):
        request(self)

    def grab(self, element, stiffness):
        self.held.append(element)


@pytest.mark.parametrize("size", [(320, 240), (640, 480), (1920, 1440)])
def test_a_press_means_the_same_element_in_pictures_of_any_size(size):
    """A page of another width gets larger pictures; a press on the smaller one, which it still shows, does not miss."""
    shown = drawn(FLAT)
    (x, y), *_ = shown.view.project(FLAT.bodies[0].positions[1:])[0].tolist()
    renderer = Renderer(FLAT, size=size)
    present = pc.Simulation(FLAT)
    newer = Picture(renderer.draw(present), present.frame(), renderer.view, None)
    physics = Physics(FLAT)
    desk = Desk(physics, SimpleNamespace(picture=newer), 1.0)
    desk.receive({"do": "grab", "x": x / 320, "y": y / 240})
    assert physics.held == [(FLAT.bodies[0], 1)]
