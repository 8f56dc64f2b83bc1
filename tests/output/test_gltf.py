"""Surfaces over time in glTF, read by pygltflib or by the bytes of the specification, and by trimesh."""

from __future__ import annotations

import json

import numpy as np
import pytest

import physcore as pc

SINGLE = float(np.finfo(np.float32).eps)
KINDS = {5126: "<f4", 5125: "<u4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def parsed(path):
    """The JSON of a file and a function for its arrays, after the specification."""
    data = path.read_bytes()
    assert data[:4] == b"glTF"
    version, whole, size = (int.from_bytes(data[start : start + 4], "little") for start in (4, 8, 12))
    assert (version, whole, data[16:20]) == (2, len(data), b"JSON")
    content = json.loads(data[20 : 20 + size])
    body = data[28 + size :]
    assert data[24 + size : 28 + size] == b"BIN\0"
    assert len(body) == content["buffers"][0]["byteLength"]

    def array(index):
        accessor = content["accessors"][index]
        view = content["bufferViews"][accessor["bufferView"]]
        assert view["byteOffset"] % 4 == 0
        part = body[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        values = np.frombuffer(part, KINDS[accessor["componentType"]])
        return values.reshape(accessor["count"], WIDTHS[accessor["type"]]).squeeze()

    return content, array


def sheet(**options):
    return pc.cloth((5, 4), 0.1, 50.0, mass=0.01, origin=(0.0, 0.0, 1.0), axes=((1, 0, 0), (0, 1, 0)), **options)


@pytest.fixture(scope="module")
def falling():
    cloth, die = (
        sheet(pinned="left", name="sheet"),
        pc.RigidBodies(
            pc.Cuboid(0.2, 0.1, 0.3),
            [(0.0, 1.0, 1.0), (1.0, 1.0, 1.0)],
            angular_velocities=[(5.0, 1.0, 0.0)] * 2,
            name="dice",
        ),
    )
    return pc.simulate(pc.Scene(cloth, die, pc.Gravity((0.0, 0.0, -9.81))), 0.5, fps=20)


def test_a_cloth_is_a_mesh_whose_targets_are_its_frames(falling, tmp_path):
    pc.export(falling, tmp_path / "run.glb")
    content, array = parsed(tmp_path / "run.glb")
    mesh = next(each for each in content["meshes"] if each["name"] == "sheet")
    (primitive,) = mesh["primitives"]
    cloth = falling.scene.bodies[0]
    base = array(primitive["attributes"]["POSITION"])
    np.testing.assert_array_equal(base, cloth.positions.astype(np.float32))
    np.testing.assert_array_equal(array(primitive["indices"]).reshape(-1, 3), cloth.faces)
    assert len(primitive["targets"]) == len(mesh["weights"]) == 10
    for frame, target in enumerate(primitive["targets"], 1):
        moved = base + array(target["POSITION"])
        np.testing.assert_allclose(moved, falling[cloth].positions[frame], rtol=0.0, atol=4.0 * SINGLE)
        accessor = content["accessors"][target["POSITION"]]
        assert accessor["min"] == array(target["POSITION"]).min(axis=0).tolist()
    animation = content["animations"][0]
    node = next(index for index, each in enumerate(content["nodes"]) if each["name"] == "sheet")
    (channel,) = (each for each in animation["channels"] if each["target"]["node"] == node)
    sampler = animation["samplers"][channel["sampler"]]
    np.testing.assert_allclose(array(sampler["input"]), falling.times, rtol=SINGLE)
    weights = array(sampler["output"]).reshape(11, 10)
    np.testing.assert_array_equal(weights[1:], np.eye(10))
    assert not weights[0].any()


def test_rigid_bodies_are_nodes_that_move_and_turn(falling, tmp_path):
    pc.export(falling, tmp_path / "run.glb")
    content, array = parsed(tmp_path / "run.glb")
    dice = falling.scene.bodies[1]
    names = [each["name"] for each in content["nodes"]]
    assert names == ["physcore", "sheet", "dice 0", "dice 1"]
    animation = content["animations"][0]
    for index in range(2):
        found = {
            each["target"]["path"]: array(animation["samplers"][each["sampler"]]["output"])
            for each in animation["channels"]
            if each["target"]["node"] == 2 + index
        }
        np.testing.assert_allclose(found["translation"], falling[dice].positions[:, index], rtol=0.0, atol=2.0 * SINGLE)
        expected = falling[dice].orientations[:, index][:, [1, 2, 3, 0]]
        # q and −q are one orientation; neighbors are on one side, so that viewers turn the short way.
        same = np.abs(np.einsum("fk,fk->f", found["rotation"], expected))
        np.testing.assert_allclose(same, 1.0, rtol=0.0, atol=4.0 * SINGLE)
        assert (np.einsum("fk,fk->f", found["rotation"][1:], found["rotation"][:-1]) > 0.0).all()
    corners = array(content["meshes"][1]["primitives"][0]["attributes"]["POSITION"])
    assert np.ptp(corners, axis=0) == pytest.approx([0.2, 0.1, 0.3], rel=1e-6)


def test_up_is_y_and_lengths_are_meters(falling, tmp_path):
    """As trimesh places the nodes: z of the scene, 1 m, is y."""
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    pc.export(falling, tmp_path / "run.glb")
    scene = trimesh.load_scene(tmp_path / "run.glb", process=False)
    placed = scene.graph.get("sheet")[0] @ np.append(falling.scene.bodies[0].positions[-1], 1.0)
    assert placed[:3] == pytest.approx([0.4, 1.0, -0.3], abs=1e-6)
    small = pc.Scene(sheet(), units=pc.units.system(length="mm"))
    pc.export(small, tmp_path / "small.glb", duration=0.1)
    content, array = parsed(tmp_path / "small.glb")
    points = array(content["meshes"][0]["primitives"][0]["attributes"]["POSITION"])
    assert points.max() == pytest.approx(1e-3)
    pc.export(small, tmp_path / "small.glb", duration=0.1, units=pc.units.system(length="mm"))
    content, array = parsed(tmp_path / "small.glb")
    assert array(content["meshes"][0]["primitives"][0]["attributes"]["POSITION"]).max() == 1.0


def test_another_reader_finds_the_same(falling, tmp_path):
    pygltflib = pytest.importorskip("pygltflib", reason="pygltflib is not installed")
    validator = pytest.importorskip("pygltflib.validator")
    pc.export(falling, tmp_path / "run.glb")
    found = pygltflib.GLTF2().load(str(tmp_path / "run.glb"))
    assert [mesh.name for mesh in found.meshes] == ["sheet", "dice"]
    assert len(found.animations[0].channels) == 1 + 2 * 2
    with pytest.warns(UserWarning, match="provisional"):
        validator.validate(found)


def test_a_scene_gives_the_bytes_of_its_recording(falling, tmp_path):
    pc.export(falling, tmp_path / "recorded.glb")
    pc.export(falling.scene, tmp_path / "streamed.glb", duration=0.5, fps=20)
    assert (tmp_path / "recorded.glb").read_bytes() == (tmp_path / "streamed.glb").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


def test_what_has_no_surface_is_refused(tmp_path):
    with pytest.raises(pc.SceneError, match=r"path: \.glb holds surfaces, and no body has faces.*\.xyz"):
        pc.export(pc.Scene(pc.Particles(np.zeros((1, 3)))), tmp_path / "dust.glb", duration=1.0)
    assert not list(tmp_path.iterdir())


def test_one_frame_is_a_mesh_alone(tmp_path):
    pc.export(pc.Scene(sheet()), tmp_path / "still.glb", duration=0.0)
    content, _ = parsed(tmp_path / "still.glb")
    assert "targets" not in content["meshes"][0]["primitives"][0]
    assert "animations" not in content


def test_the_surface_of_a_liquid_is_shown_in_its_frame(tmp_path):
    """Each frame has a mesh, whose node has the size 1 then and 0 else, without steps between."""
    water = pc.Fluid(pc.block((0.0, 0.0, 0.0), (0.3, 0.2, 0.2), 0.05), 0.05, name="water")
    tank = pc.Box((0.0, 0.0, 0.0), (0.6, 0.2, 0.6))
    pc.export(pc.Scene(water, tank, pc.Gravity((0, 0, -9.81))), tmp_path / "run.glb", duration=0.2, fps=20)
    content, array = parsed(tmp_path / "run.glb")
    assert [each["name"] for each in content["meshes"]] == [f"water {frame}" for frame in range(5)]
    animation = content["animations"][0]
    assert len(animation["channels"]) == 5
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        assert (channel["target"]["path"], sampler["interpolation"]) == ("scale", "STEP")
        node = content["nodes"][channel["target"]["node"]]
        frame = int(node["name"].split()[1])
        assert content["meshes"][node["mesh"]]["name"] == node["name"]
        np.testing.assert_array_equal(array(sampler["output"]), np.repeat(np.eye(5)[frame], 3).reshape(5, 3))
    trimesh = pytest.importorskip("trimesh")
    meshes = trimesh.load(tmp_path / "run.glb").geometry
    assert meshes["water 0"].is_watertight
    np.testing.assert_allclose(meshes["water 0"].extents, (0.3, 0.2, 0.2), atol=0.012)  # a quarter of a spacing
