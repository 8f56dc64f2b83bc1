"""The polygons and meshes that stand for the shapes of rigid bodies have their areas, volumes and normals."""

from __future__ import annotations

import math

import numpy as np
import pytest

import physcore as pc
from physcore.film.shapes import planar, spatial
from physcore.film.shapes.parts import planar_rotations, spatial_rotations
from physcore.scene.solids import Shape

SCALE = 200.0
"""Magnification [pixels/m]."""
PLANAR: dict[str, tuple[Shape, float]] = {
    "disc": (pc.Disc(0.2), math.tau * 0.2),
    "rectangle": (pc.Rectangle(0.4, 0.2), 1.2),
    "capsule": (pc.Capsule(0.5, 0.1), 1.0 + math.tau * 0.1),
    "clockwise": (pc.Polygon([(0.0, 0.0), (0.0, 0.3), (0.4, 0.0)]), 1.2),
    "plus": (pc.Compound([(pc.Rectangle(0.6, 0.2), (0.0, 0.0)), (pc.Rectangle(0.2, 0.6), (0.0, 0.0))]), 2.4),
    "side by side": (pc.Compound([(pc.Rectangle(0.2, 0.2), (0.0, 0.0)), (pc.Rectangle(0.4, 0.2), (0.3, 0.0))]), 1.6),
    "flush": (pc.Compound([(pc.Rectangle(0.4, 0.2), (0.0, 0.0)), (pc.Rectangle(0.4, 0.2), (0.2, 0.0))]), 1.6),
}
"""Shapes in 2D with the lengths of their outlines."""
SPATIAL: dict[str, Shape] = {
    "ball": pc.Ball(0.2),
    "capsule": pc.Capsule(0.3, 0.1),
    "cuboid": pc.Cuboid(0.4, 0.2, 0.1),
    "hull": pc.Hull(0.2 * np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])),
    "hammer": pc.Compound([(pc.Cuboid(0.05, 0.05, 0.3), (0.0, 0.0, 0.0)), (pc.Cuboid(0.2, 0.1, 0.1), (0.0, 0.0, 0.2))]),
}


def area(points: np.ndarray, triangles: np.ndarray) -> float:
    """The signed area of triangles."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * float(((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum())


@pytest.mark.parametrize("name", PLANAR)
def test_the_outline_of_a_shape_has_its_length(name: str) -> None:
    """Sides inside of another part, or between two parts, do not count. Of a circle of radius r in 4 q segments the
    length is 8 q r sin(π/4q) > 2 π r (1 − (π/4q)²/6); sides along which parts are flush count once, or twice.
    """
    shape, length = PLANAR[name]
    face = planar.face_of(planar.cores_of(shape), SCALE)
    ways = face.points[face.rim[:, 1]] - face.points[face.rim[:, 0]]
    found = float(np.hypot(*ways.T).sum())
    if name == "flush":
        twice = 2 * 0.2  # both long sides of the common part
        assert found == pytest.approx(length + twice, rel=1e-7)
        return
    quarter = planar.segments_of(0.2, SCALE)
    short = length * (math.pi / (4 * quarter)) ** 2 / 6.0 if name in ("disc", "capsule") else 0.0
    assert length - short - 1e-7 <= found <= length + 1e-7


@pytest.mark.parametrize("name", ["disc", "rectangle", "capsule", "clockwise"])
def test_triangles_fill_a_shape_and_a_mark_half_of_it(name: str) -> None:
    """The inscribed polygon of a circle lacks less than the sagitta along the circumference. The center of mass of a
    triangle is on each line from a corner that halves it, and that of a symmetric shape on each line that halves it.
    """
    shape, length = PLANAR[name]
    face = planar.face_of(planar.cores_of(shape), SCALE)
    assert isinstance(shape.properties(2).size, float)
    whole = area(face.points, face.triangles)
    assert shape.properties(2).size - planar.SAGITTA / SCALE * length <= whole <= shape.properties(2).size + 1e-12
    assert area(face.points, face.painted) == pytest.approx(0.5 * whole, rel=1e-9)


def test_marks_are_different_after_half_a_turn_except_on_discs() -> None:
    """A mark is on one side of the center of mass, so that half a turn puts it on the other side."""
    for name, symmetric in (("disc", True), ("rectangle", False), ("capsule", False)):
        face = planar.face_of(planar.cores_of(PLANAR[name][0]), SCALE)
        weights = [area(face.points, face.painted[k : k + 1]) for k in range(len(face.painted))]
        middle = np.average(face.points[face.painted].mean(axis=1), axis=0, weights=weights)
        assert (float(np.hypot(*middle)) < 1e-9) == symmetric


def test_a_compound_is_drawn_about_its_center_of_mass() -> None:
    """The first moments of the parts of equal thickness cancel: Σ area · center = 0."""
    shape = pc.Compound([(pc.Rectangle(0.4, 0.2), (1.0, 2.0), 0.3), (pc.Rectangle(0.2, 0.2), (1.4, 2.0))])
    cores = planar.cores_of(shape)
    moment = 0.08 * cores[0].vertices.mean(axis=0) + 0.04 * cores[1].vertices.mean(axis=0)
    assert np.abs(moment).max() < 1e-12
    side = cores[0].vertices[1] - cores[0].vertices[0]
    assert math.atan2(side[1], side[0]) == pytest.approx(0.3)


def test_a_polygon_that_is_not_convex_is_cut_at_its_ears() -> None:
    """A star and a comb: the parts are convex, have the area of the polygon together and its sides as their outline."""
    turn = 0.2 * math.pi * np.arange(10)
    star = np.where(np.arange(10) % 2, 0.15, 0.4)[:, np.newaxis] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    teeth = [(0.1 * k, 0.3 if k % 2 else 0.1) for k in range(8, -1, -1)]
    for polygon in (star, np.array([(0.0, 0.0), (0.8, 0.0), *teeth])):
        parts = planar.convex_parts(polygon)
        after = np.roll(polygon, -1, axis=0)
        whole = 0.5 * float((polygon[:, 0] * after[:, 1] - polygon[:, 1] * after[:, 0]).sum())
        face = planar.face_of([planar.Core(part, 0.0) for part in parts], SCALE)
        assert area(face.points, face.triangles) == pytest.approx(whole, rel=1e-12)
        assert all(area(part, np.array([[0, k, k + 1]])) > 0.0 for part in parts for k in range(1, len(part) - 1))
        ways = face.points[face.rim[:, 1]] - face.points[face.rim[:, 0]]
        assert float(np.hypot(*ways.T).sum()) == pytest.approx(float(np.hypot(*(after - polygon).T).sum()), rel=1e-6)


def test_parts_of_segments_beyond_a_square_are_left() -> None:
    """A line through a unit square loses the part within; one beside it is whole; one within is gone."""
    square = planar.SQUARE / 2.0
    lines = np.array([[[-1.0, 0.1], [1.0, 0.1]], [[-1.0, 0.7], [1.0, 0.7]], [[-0.2, 0.0], [0.3, 0.2]]])
    left = planar.outer_parts(lines, [square])
    ends = sorted(left.reshape(-1, 4).round(6).tolist())
    assert ends == [[-1.0, 0.1, -0.5, 0.1], [-1.0, 0.7, 1.0, 0.7], [0.5, 0.1, 1.0, 0.1]]


@pytest.mark.parametrize("marks", [True, False])
@pytest.mark.parametrize("name", SPATIAL)
def test_meshes_enclose_the_volume_of_a_shape_and_look_outward(name: str, marks: bool) -> None:
    """By Gauss's theorem the volume is ⅙ Σ a · (b × c), and the vector areas of a closed surface add up to zero. Cut
    polytopes lose nothing; a ball loses less than its surface times the sagitta in both directions.
    """
    shape = SPATIAL[name]
    mesh = spatial.mesh_of(shape, SCALE, marks)
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    volume = float(np.einsum("nd,nd->", a, np.cross(b, c))) / 6.0
    areas = np.cross(b - a, c - a)
    assert np.abs(areas.sum(axis=0)).max() < 1e-9
    size, surface = shape.properties(3).size, 0.5 * float(np.sqrt((areas**2).sum(axis=1)).sum())
    lost = 2.0 * spatial.SAGITTA / SCALE * surface if name in ("ball", "capsule") else 1e-9
    assert size - lost <= volume <= size + 1e-9
    normals = mesh.normals[mesh.triangles]
    assert np.abs((normals**2).sum(axis=2) - 1.0).max() < 1e-9
    assert (np.einsum("nkd,nd->nk", normals, areas) > 0.0).all()
    assert (len(np.unique(mesh.tones)) > len(np.unique(spatial.mesh_of(shape, SCALE, False).tones))) == marks


def test_pieces_of_a_face_are_short_and_few() -> None:
    """No side is longer than a piece; a slab a hundred times as large has not ten thousand times as many triangles."""
    mesh = spatial.mesh_of(pc.Cuboid(1.0, 0.5, 0.25), SCALE, True)
    sides = mesh.points[mesh.triangles] - mesh.points[mesh.triangles[:, [1, 2, 0]]]
    assert np.sqrt((sides**2).sum(axis=2)).max() <= spatial.PIECE / SCALE + 1e-12
    slab = spatial.mesh_of(pc.Cuboid(100.0, 50.0, 25.0), SCALE, True)
    # A right isosceles triangle with a hypotenuse p, halved once too often, has an area of p²/8 or more.
    assert len(slab.triangles) <= 8 * spatial.MANY * 2.0


def test_rotations_are_those_of_angles_and_quaternions() -> None:
    """Rodrigues' formula for a turn by 0.7 rad about an axis; in the plane about z."""
    axis = np.array([1.0, 2.0, -2.0]) / 3.0
    turn = np.array([[math.cos(0.35), *(math.sin(0.35) * axis)]])
    v = np.array([0.3, -0.1, 0.5])
    expected = v * math.cos(0.7) + np.cross(axis, v) * math.sin(0.7) + axis * (axis @ v) * (1.0 - math.cos(0.7))
    assert spatial_rotations(turn)[0] @ v == pytest.approx(expected, abs=1e-14)
    assert planar_rotations(np.array([0.7]))[0] @ [1.0, 0.0] == pytest.approx([math.cos(0.7), math.sin(0.7)])
