"""Meshes: files written by trimesh come back, and bodies made of them have their area, volume and mass."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.files import READERS
from physcore.files.meshes import MeshReader

trimesh = pytest.importorskip("trimesh", reason="trimesh, which reads and writes meshes, is not installed")
pytest.importorskip("scipy", reason="scipy, which fills meshes, is not installed")

SINGLE = 4.0 * float(np.finfo(np.float32).eps)
"""Relative error of coordinates in single precision, as in STL and glTF, and of products of three of them."""
CORNERS = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
SIDES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]


def lump():
    """A closed mesh without symmetry."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=30.0)
    ball.vertices *= [1.0, 0.7, 1.3]
    ball.vertices += [5.0, 0.0, 40.0]
    return ball


@pytest.mark.parametrize("suffix", MeshReader.suffixes)
def test_a_file_of_trimesh_comes_back(suffix, tmp_path):
    """As sets of points, since formats order them at will; in meters."""
    mesh, path = lump(), tmp_path / f"lump{suffix}"
    if suffix == ".gltf":
        for name, content in mesh.export(file_type="gltf").items():
            (tmp_path / name.replace("model", "lump")).write_bytes(content)
    else:
        mesh.export(path)
    own = pc.read(path, unit="mm", up="z")
    assert (len(own.vertices), len(own.faces)) == (len(mesh.vertices), len(mesh.faces))
    order, expected = np.lexsort(own.vertices.round(6).T), np.lexsort((1e-3 * mesh.vertices).round(6).T)
    np.testing.assert_allclose(own.vertices[order], 1e-3 * mesh.vertices[expected], rtol=0.0, atol=0.08 * SINGLE)
    assert own.is_closed
    assert own.volume == pytest.approx(1e-9 * mesh.volume, rel=SINGLE)
    assert own.area == pytest.approx(1e-6 * mesh.area, rel=SINGLE)
    assert own.name == "lump"


def test_gltf_is_in_meters_with_y_up(tmp_path):
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / "box.glb")
    assert np.ptp(pc.read(tmp_path / "box.glb").vertices, axis=0).tolist() == [1.0, 3.0, 2.0]
    assert np.ptp(pc.read(tmp_path / "box.glb", unit="cm", up="z").vertices, axis=0) == pytest.approx(
        [0.01, 0.02, 0.03]
    )
    astronomical = pc.read(tmp_path / "box.glb", unit="AU", units=pc.units.system(length="AU", mass="M☉", time="d"))
    assert np.ptp(astronomical.vertices, axis=0) == pytest.approx([1.0, 3.0, 2.0])


def test_y_up_is_a_turn_and_no_mirror_image(tmp_path):
    lump().export(tmp_path / "lump.obj")
    assert pc.read(tmp_path / "lump.obj", unit="m", up="y").volume > 0.0


def test_a_file_without_a_unit_is_refused_with_its_size(tmp_path):
    trimesh.creation.box((1.0, 2.0, 3.0)).export(tmp_path / "box.stl")
    with pytest.raises(pc.SceneError, match=r"read.unit: .*box.stl does not say in which unit its 1 × 2 × 3 are"):
        pc.read(tmp_path / "box.stl")
    with pytest.raises(pc.SceneError, match=r"read.unit: must be a unit of length.*got 'kg'"):
        pc.read(tmp_path / "box.stl", unit="kg")
    with pytest.raises(pc.SceneError, match=r"read.masses: has no meaning for meshes"):
        pc.read(tmp_path / "box.stl", unit="m", masses={"H": 1.0})


@pytest.mark.parametrize("unit", ["in", "inches", 0.0254, (0.0254, "in")])
def test_units_of_length_have_several_forms(unit):
    assert pc.from_mesh(trimesh.creation.box((10.0, 1.0, 1.0)), unit=unit).vertices.max() == pytest.approx(0.127)


def test_an_object_of_trimesh_has_its_unit():
    box = trimesh.creation.box((10.0, 1.0, 1.0))
    assert np.ptp(pc.from_mesh(box).vertices[:, 0]) == 10.0
    box.units = "millimeters"
    assert np.ptp(pc.from_mesh(box).vertices[:, 0]) == pytest.approx(0.01)


def test_an_object_of_meshio_is_taken(tmp_path):
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]]
    meshio.Mesh(points, [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 2]])]).write(tmp_path / "sheet.vtk")
    sheet = pc.from_mesh(meshio.read(tmp_path / "sheet.vtk"))
    assert len(sheet.faces) == 3
    assert sheet.area == 1.5


@pytest.mark.parametrize("bad", ["nothing", object(), 3])
def test_an_object_without_faces_is_refused(bad):
    with pytest.raises(pc.SceneError, match=r"from_mesh.mesh: must have vertices and faces"):
        pc.from_mesh(bad)


@pytest.mark.parametrize("suffix", MeshReader.suffixes)
@pytest.mark.parametrize("content", [b"", b"nonsense\n", bytes(range(256))], ids=["empty", "text", "bytes"])
def test_a_damaged_file_is_an_error_with_its_name(suffix, content, tmp_path):
    (tmp_path / f"bad{suffix}").write_bytes(content)
    with pytest.raises(pc.FileError, match=f"bad{suffix}"):
        pc.read(tmp_path / f"bad{suffix}", unit="m")


def test_points_without_faces_are_refused(tmp_path):
    trimesh.PointCloud(CORNERS).export(tmp_path / "points.ply")
    with pytest.raises(pc.FileError, match=r"points.ply: has no triangles: it has points without faces"):
        pc.read(tmp_path / "points.ply", unit="m")


def test_an_open_mesh_is_a_cloth_but_no_solid():
    cup = pc.Mesh(CORNERS, SIDES[:3], name="cup")
    assert not cup.is_closed
    assert len(cup.cloth(10.0, 0.1).faces) == 3
    for make in (cup.rigid_body, lambda: cup.soft_body(0.1, 1.0), lambda: cup.fill(0.1), lambda: cup.volume):
        with pytest.raises(pc.SceneError, match=r"of cup: it is open: 3 edges have one face only.*fill_holes"):
            make()


def test_three_faces_at_an_edge_are_a_warning_and_no_solid(tmp_path):
    fins = trimesh.Trimesh([*CORNERS, [1.0, 1.0, 1.0]], [*SIDES, [0, 1, 4]], process=False)
    fins.export(tmp_path / "fins.off")
    with pytest.warns(
        pc.SceneWarning, match=r"fins.off: 3 faces meet at the edge of the vertices 0 and 1, at \(0.5, 0,"
    ):
        mesh = pc.read(tmp_path / "fins.off", unit="m")
    with pytest.raises(pc.SceneError, match="3 faces meet at the edge"):
        mesh.rigid_body()


def test_one_face_that_is_turned_over_is_named():
    mesh = pc.Mesh(CORNERS, [*SIDES[:3], SIDES[3][::-1]])
    with pytest.raises(pc.SceneError, match=r"two faces pass the edge of the vertices . and ., at .* in one direction"):
        mesh.rigid_body()


def test_a_mesh_that_is_inside_out_is_turned_over_with_a_warning(tmp_path):
    trimesh.Trimesh(CORNERS, np.array(SIDES)[:, ::-1], process=False).export(tmp_path / "out.off")
    with pytest.warns(pc.SceneWarning, match=r"out.off: is inside out"):
        mesh = pc.read(tmp_path / "out.off", unit="m")
    assert mesh.volume == pytest.approx(1.0 / 6.0)


def test_a_cloth_has_the_mass_of_its_area_and_springs_at_its_edges():
    mesh = pc.from_mesh(lump(), unit="mm")
    cloth = mesh.cloth(stiffness=50.0, areal_density=0.3, damping=0.1, fixed=[0], name="skin")
    assert cloth.mass.sum() == pytest.approx(0.3 * mesh.area)
    assert len(cloth.pairs) == len(mesh.vertices) + len(mesh.faces) - 2  # Euler
    assert cloth.name == "skin"
    assert cloth.fixed[0]
    np.testing.assert_array_equal(cloth.faces, mesh.faces)


@pytest.mark.parametrize("spacing", [0.008, 0.02, 1.0])
def test_a_soft_body_fills_the_volume(spacing):
    """Delaunay's tetrahedra with their centers within cover the convex solid but for slivers at its faces."""
    mesh = pc.from_mesh(lump(), unit="mm")
    jelly = mesh.soft_body(spacing, stiffness=100.0, density=900.0)
    assert jelly.mass.sum() == pytest.approx(900.0 * mesh.volume)
    assert jelly.mass.min() > 0.05 * jelly.mass.mean()
    inner = len(jelly) - len(mesh.vertices)
    np.testing.assert_array_equal(jelly.positions[: len(mesh.vertices)], mesh.vertices)
    assert mesh.contains(jelly.positions[len(mesh.vertices) :]).all()
    # Two points of the lattice in each cube; those near vertices are left out, half of them at most if cubes are small.
    assert (mesh.volume / spacing**3 if spacing < 0.01 else 0) <= inner <= 2.0 * mesh.volume / spacing**3
    # The center of mass of the particles is that of the solid, to a part of the edges.
    center = jelly.mass @ jelly.positions / jelly.mass.sum()
    assert center == pytest.approx(mesh.shape.properties(3).center, abs=1e-3)


def test_a_soft_body_keeps_its_form_and_its_energy():
    mesh = pc.from_mesh(trimesh.creation.icosphere(subdivisions=1), unit=0.1)
    jelly = mesh.soft_body(0.08, stiffness=2e3, damping=2.0, velocities=(0.0, 0.0, -1.0))
    recording = pc.simulate(pc.Scene(jelly, pc.Gravity((0.0, 0.0, -9.81)), pc.Floor(-0.2)), 0.5)
    assert abs(recording.energy.drift).max() < 1e-3
    size = np.linalg.norm(np.ptp(recording.positions, axis=1), axis=1)
    assert 0.8 < size.min() / size[0] < size.max() / size[0] < 1.2


def test_a_rigid_body_stays_where_the_mesh_is():
    mesh = pc.from_mesh(lump(), unit="mm")
    body = mesh.rigid_body(density=500.0)
    assert body.positions[0] == pytest.approx([0.005, 0.0, 0.04], abs=1e-6)
    assert body.mass[0] == pytest.approx(500.0 * mesh.volume)
    assert mesh.rigid_body((1.0, 2.0, 3.0)).positions[0].tolist() == [1.0, 2.0, 3.0]
    inside = body.contains(pc.block((-0.03, -0.03, 0.0), (0.04, 0.03, 0.08), 0.004))
    np.testing.assert_array_equal(inside, mesh.contains(pc.block((-0.03, -0.03, 0.0), (0.04, 0.03, 0.08), 0.004)))


@pytest.mark.parametrize("spacing", [0.004, 0.002])
def test_a_filled_mesh_has_its_volume(spacing):
    """Cells are cut at random by the surface, whose errors have both signs: a tenth of a layer of cells at most."""
    mesh = pc.from_mesh(lump(), unit="mm")
    points = mesh.fill(spacing)
    assert len(points) * spacing**3 == pytest.approx(mesh.volume, abs=0.1 * mesh.area * spacing)
    with pytest.raises(pc.SceneError, match="has no room for a cell"):
        pc.Mesh(CORNERS, SIDES).fill(3.0)


def test_moved_meshes_are_new():
    mesh = pc.Mesh(CORNERS, SIDES)
    moved = mesh.moved((1.0, 0.0, 0.0), scale=2.0)
    assert moved.volume == pytest.approx(8.0 * mesh.volume)
    assert moved.vertices[:, 0].min() == 1.0


def test_suffixes_are_of_one_reader_each():
    suffixes = [suffix for reader in READERS for suffix in reader.suffixes]
    assert len(set(suffixes)) == len(suffixes)


def test_an_unknown_suffix_names_those_that_are_known(tmp_path):
    with pytest.raises(pc.SceneError, match=r"read.path: must end in one of \.obj .*got '.*mesh.foo'"):
        pc.read(tmp_path / "mesh.foo")
    with pytest.raises(pc.FileError, match="there is no such file"):
        pc.read(tmp_path / "mesh.stl")
    with pytest.raises(pc.FileError, match="is a folder"):
        pc.read(tmp_path, ".stl")
