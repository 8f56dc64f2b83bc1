"""Surfaces over time in USD, read by its own library where it is installed, and as text."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import physcore as pc


@pytest.fixture(scope="module")
def wet() -> pc.Recording:
    pytest.importorskip("pysplashsurf", reason="pysplashsurf is not installed")
    water = pc.Fluid(pc.block((0.0, 0.0, 0.0), (0.3, 0.2, 0.2), 0.05), 0.05, name="clear water")
    tank = pc.Box((0.0, 0.0, 0.0), (0.6, 0.2, 0.6), on=water)
    cloth = pc.cloth((5, 4), 0.1, 50.0, mass=0.01, origin=(0.0, 1.0, 1.0), axes=((1, 0, 0), (0, 1, 0)), pinned="left")
    dice = pc.RigidBodies(
        pc.Cuboid(0.2, 0.1, 0.3), [(0.0, 3.0, 1.0), (1.0, 3.0, 1.0)], angular_velocities=[(5.0, 1.0, 0.0)] * 2,
        name="2 dice",
    )  # fmt: skip
    return pc.simulate(pc.Scene(water, tank, cloth, dice, pc.Gravity((0.0, 0.0, -9.81))), 0.2, fps=20, progress=False)


def volume(points: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return float((a * np.cross(b, c)).sum() / 6.0)


def test_the_library_reads_what_moves(wet: pc.Recording, tmp_path: Path) -> None:
    """Water of 12 liters: the edges of its surface, 4 × 0.7 m, are rounded by at most three spacings of 0.05 m."""
    usd, geometry = pytest.importorskip("pxr.Usd"), pytest.importorskip("pxr.UsdGeom")
    pc.export(wet, tmp_path / "run.usda")
    stage = usd.Stage.Open(str(tmp_path / "run.usda"))
    assert geometry.GetStageUpAxis(stage) == "Z"
    assert geometry.GetStageMetersPerUnit(stage) == 1.0
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()) == (0, 4, 20)
    assert not stage.GetCompositionErrors()
    sheet = geometry.Mesh(stage.GetPrimAtPath("/physcore/body_1"))
    water = geometry.Mesh(stage.GetPrimAtPath("/physcore/clear_water"))
    assert water.GetPrim().GetDisplayName() == "clear water"
    body, dice = wet.scene.bodies[1], wet["2 dice"]
    assert np.array_equal(np.array(sheet.GetFaceVertexIndicesAttr().Get(2)).reshape(-1, 3), body.faces)
    for frame in range(5):
        expected = wet[body].positions[frame]
        np.testing.assert_allclose(np.array(sheet.GetPointsAttr().Get(frame)), expected, rtol=1e-6, atol=1e-7)
        points = np.array(water.GetPointsAttr().Get(frame), dtype=float)
        faces = np.array(water.GetFaceVertexIndicesAttr().Get(frame)).reshape(-1, 3)
        assert len(water.GetFaceVertexCountsAttr().Get(frame)) == len(faces)
        assert faces.max() == len(points) - 1
        if frame == 0:
            assert 0.012 - (1.0 - np.pi / 4.0) * 0.15 * 0.15 * 2.8 < volume(points, faces) < 0.012
        cache = geometry.XformCache(usd.TimeCode(frame))
        for index in range(2):
            prim = stage.GetPrimAtPath(f"/physcore/_2_dice_{index}")
            matrix = np.array(cache.GetLocalToWorldTransform(prim))
            np.testing.assert_allclose(matrix[3, :3], dice.positions[frame, index], atol=1e-9)
            w, vector = dice.orientations[frame, index, 0], dice.orientations[frame, index, 1:]
            way = np.array([0.1, 0.05, 0.15])
            turned = way + 2.0 * np.cross(vector, np.cross(vector, way) + w * way)
            np.testing.assert_allclose(way @ matrix[:3, :3], turned, atol=1e-9)
            assert geometry.Mesh(stage.GetPrimAtPath(f"{prim.GetPath()}/mesh")).GetPointsAttr().Get()


def test_the_text_has_a_mesh_for_each_body_and_frames_of_water(wet: pc.Recording, tmp_path: Path) -> None:
    pc.export(wet, tmp_path / "run.usda")
    text = (tmp_path / "run.usda").read_text()
    assert text.startswith("#usda 1.0\n")
    assert text.count("{") == text.count("}")
    assert re.findall(r'def \w+ "(\w+)"', text) == [
        "physcore",
        "clear_water",
        "body_1",
        "mesh",
        "_2_dice_0",
        "_2_dice_1",
    ]
    water = text[text.index('"clear_water"') : text.index('"body_1"')]
    for attribute in ("points", "faceVertexCounts", "faceVertexIndices"):
        part = water[water.index(f"{attribute}.timeSamples") :]
        assert re.findall(r"^ +(\d+): \[", part[: part.index("}")], flags=re.MULTILINE) == list("01234")
    assert list(tmp_path.iterdir()) == [tmp_path / "run.usda"]


def test_names_are_those_of_usd(tmp_path: Path) -> None:
    """Two that would be alike are told apart, and quotation marks stay in the name that is shown."""
    bodies = [
        pc.RigidBody(pc.Ball(0.1), (float(index), 0.0, 0.0), name=name)
        for index, name in enumerate(('a"b', "a b", "ä"))
    ]
    pc.export(pc.Scene(*bodies), tmp_path / "balls.usda", duration=0.1, fps=10.0)
    text = (tmp_path / "balls.usda").read_text()
    assert re.findall(r'def Xform "(\w+)"', text) == ["physcore", "a_b", "a_b__2", "_"]
    assert r'displayName = "a\"b"' in text


@pytest.mark.parametrize("suffix", [".usda", ".glb"])
def test_what_has_no_surface_is_refused(suffix: str, tmp_path: Path) -> None:
    scene: Any = pc.Scene(pc.Fluid(pc.block((0.0, 0.0), (0.2, 0.2), 0.05), 0.05))
    with pytest.raises(pc.SceneError, match=rf"path: {suffix} holds surfaces, and no body has faces: .* liquids .* 3D"):
        pc.export(scene, tmp_path / f"flat{suffix}", duration=0.1, fps=10.0)
    assert not list(tmp_path.iterdir())
