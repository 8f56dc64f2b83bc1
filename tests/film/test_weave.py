"""Woven cloths: threads that are seen where they are wider than pixels, and hang loose where the cloth has torn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import physcore as pc
from physcore.film.styles.frays import PARTS, frays, torn_edges

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def sheet(dimension: int = 3, **values: Any) -> pc.SpringNetwork:
    axes = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)) if dimension == 3 else ((1.0, 0.0), (0.0, 1.0))
    return pc.cloth((12, 9), 0.1, 100.0, mass=0.01, axes=axes, pinned="left", **values)


def still(body: pc.SpringNetwork, folder: Path, weave: float | None) -> np.ndarray:
    path, style = folder / "cloth.png", pc.styles.Surface("#b04030", weave=weave)
    pc.film(pc.Scene(body), path, duration=0.01, fps=100.0, size=(240, 180), style=style, labels=(), progress=False)
    return np.asarray(Image.open(path).convert("RGB")).astype(float)


@pytest.mark.parametrize("dimension", [2, 3])
def test_threads_vary_the_color_and_keep_its_mean(dimension: int, tmp_path: Path) -> None:
    """The middle of the picture has some 15 × 15 threads of 5 pixels, whose waves have the mean 0. Of threads of a
    hundredth of a pixel nothing is left.
    """
    body = sheet(dimension)
    plain, fine = still(body, tmp_path, None), still(body, tmp_path, 5e-5)
    np.testing.assert_allclose(fine, plain, atol=1.0)  # rounding
    middle = np.s_[50:130, 70:170]
    woven = still(body, tmp_path, 0.03)[middle]
    assert woven[..., 0].std() > 5.0 + plain[middle][..., 0].std()
    np.testing.assert_allclose(woven.mean(axis=(0, 1)), plain[middle].mean(axis=(0, 1)), atol=1.5)


def test_threads_stick_out_of_the_torn_edge_only() -> None:
    """Of a square of 4 × 4 threads, the half below its diagonal is left. Four threads of each set cross the diagonal in
    their middles: those along x at y = ½, 1½, … leave toward −x, those along y toward +y.
    """
    ends, owners = torn_edges(HALVES, np.array([True, False]))
    assert sorted(ends[:, :2].ravel().tolist()) == [0, 2]
    assert owners.tolist() == [0]
    flat = np.pad(SQUARE, ((0, 0), (0, 1)))
    for positions in (SQUARE, flat):
        loose = frays(positions, SQUARE, HALVES, np.array([True, False]), 9.0)
        assert loose.points.shape == (8, PARTS + 1, positions.shape[1])
        root, tip = loose.points[:, 0], loose.points[:, -1]
        np.testing.assert_allclose(root[:, 0], root[:, 1], atol=1e-12)
        assert sorted(root[:, 0].round(9).tolist()) == sorted([0.5, 1.5, 2.5, 3.5] * 2)
        assert (tip[:, 1] - tip[:, 0] > 0.1).all(), "toward the other half"
        again = frays(positions + 1.0, SQUARE, HALVES, np.array([True, False]), 9.0)
        np.testing.assert_allclose(again.points, loose.points + 1.0)
    assert len(frays(flat, SQUARE, HALVES, np.array([True, True]), 9.0).points) == 0
    assert len(frays(flat, SQUARE, HALVES, np.array([False, False]), 9.0).points) == 0


def test_fine_threads_do_not_all_hang_loose() -> None:
    """Four thousand threads cross the diagonal. Where they are 0.1 pixels wide, one in thirteen is drawn."""
    count = len(frays(SQUARE, 1000.0 * SQUARE, HALVES, np.array([True, False]), 0.1).points)
    assert count == pytest.approx(2 * 4000 / 13, abs=2)


def test_a_torn_cloth_is_wider_with_its_loose_threads(tmp_path: Path) -> None:
    """Its free half breaks off at once and is pulled away: threads reach into the gap."""

    def covered(weave: float | None) -> int:
        whole = sheet()
        middle = whole.positions[whole.pairs].mean(axis=1)[:, 0]
        strength = np.where(np.abs(middle - 0.55) < 0.06, 1e-6, np.inf)
        body = pc.SpringNetwork(
            whole.positions, whole.pairs, whole.stiffness, mass=whole.mass, fixed=whole.fixed, faces=whole.faces,
            breaking_strain=strength, velocities=np.where(whole.positions[:, :1] > 0.55, [[3.0, 0.0, 0.0]], 0.0),
        )  # fmt: skip
        path, style = tmp_path / "torn.png", pc.styles.Surface("tomato", weave=weave)
        recording = pc.simulate(pc.Scene(body), 0.1, 50.0, progress=False)
        pc.film(recording, path, size=(240, 180), style=style, labels=(), progress=False)
        picture = np.asarray(Image.open(path).convert("RGB")).astype(int)
        return int((picture[..., 0] - picture[..., 2] > 30).sum())

    assert covered(0.02) > covered(None) + 20


@pytest.mark.parametrize(
    ("weave", "message"), [(0.0, "must be > 0"), (-1.0, "must be > 0"), ("fine", "must be a number")]
)
def test_a_wrong_weave_is_refused(weave: Any, message: str) -> None:
    with pytest.raises(pc.SceneError, match=rf"Surface\.weave: {message}"):
        pc.styles.Surface(weave=weave)
