"""Files of pages: their size, and what cannot be on one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import physcore as pc
from physcore.film.page import tape
from physcore.film.styles.base import Painter
from physcore.film.styles.phase import PhasePainter
from physcore.film.writers import page

RANDOM = np.random.default_rng(4)
DUST = pc.Particles(RANDOM.random((5000, 3)), RANDOM.normal(0, 0.5, (5000, 3)), radius=0.005)


def test_ten_seconds_of_5000_particles_are_at_most_5_mb(tmp_path: Path) -> None:
    """In 3D, with a color of its own for each, bouncing: 300 frames of three coordinates and a color."""
    recording = pc.simulate(pc.Scene(DUST, pc.Gravity(), pc.Box((0.0,) * 3, (1.0,) * 3)), 10.0)
    film = pc.film(recording, tmp_path / "dust.html")
    assert film.frames == 301
    assert film.bytes <= 5_000_000


def test_a_page_is_rounded_to_fit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = pc.Scene(pc.Particles(RANDOM.random((200, 2)), RANDOM.random((200, 2))))
    recording = pc.simulate(scene, 2.0)
    whole = pc.film(recording, tmp_path / "whole.html").bytes
    with pytest.warns(pc.SceneWarning, match="is larger than max_bytes"):
        small = pc.film(recording, tmp_path / "small.html", max_bytes=1000).bytes
    assert small < whole
    monkeypatch.setattr(page, "FITS", 1000)
    with pytest.warns(
        pc.SceneWarning, match=r"pages above 5 MB open slowly, .* rounded to 12 bits already; give it fewer"
    ):
        pc.film(recording, tmp_path / "large.html")


def test_what_a_page_cannot_show_is_refused_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "film.html"
    monkeypatch.setattr(PhasePainter, "record", Painter.record)  # as a style that draws pixels and knows no other way
    grid = pc.Grid((20, 20), 0.1)
    packet = pc.Schrodinger(grid, pc.wave_packet(grid, (1.0, 1.0), (1.0, 0.0), 0.3))
    with pytest.raises(pc.SceneError, match="style: Phase draws pixels, which a page cannot show; give another style"):
        pc.film(pc.Scene(packet), path, duration=0.1)
    plain = pc.Scene(pc.Particles([[0.0, 0.0]]))
    with pytest.raises(pc.SceneError, match="loop: a page cannot blend the end into the start; give 'bounce'"):
        pc.film(plain, path, duration=0.1, loop="crossfade")
    monkeypatch.setattr(tape, "MOST", 1000)
    with pytest.raises(pc.SceneError, match=r"path: a page keeps all frames in memory, and \d of them have"):
        pc.film(pc.Scene(DUST), path, duration=0.1)
    assert list(tmp_path.iterdir()) == []


def test_a_page_stands_in_a_notebook(tmp_path: Path) -> None:
    film = pc.film(pc.Scene(pc.Particles([[0.0, 0.0]])), tmp_path / "film.html", duration=0.1)
    shown = film._repr_html_()
    assert shown.startswith("<iframe")
    assert 'sandbox="allow-scripts"' in shown
