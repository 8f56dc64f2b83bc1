"""Physics and pictures do not wait for each other."""

from __future__ import annotations

import threading
import urllib.request

import numpy as np
import pytest

import physcore as pc
from chromium import until
from physcore.panel.pace import nominal_speed
from physcore.panel.reel import BYTES, RATE, SECONDS, Reel
from physcore.panel.runner import Moment

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")

BALL = pc.Particles([[0.0, 1.0]], velocities=[[1.0, 0.0]], name="ball")


def test_physics_goes_on_while_a_picture_is_drawn():
    with pc.live(lambda: pc.Scene(BALL, pc.Gravity()), dt=1e-3, show=False) as panel:
        begun, free = threading.Event(), threading.Event()
        draw = panel.artist._renderer.draw

        def slow(state):
            begun.set()
            free.wait()
            return draw(state)

        panel.artist._renderer.draw = slow
        panel.play()
        panel.artist.watch(on=True)
        try:
            assert begun.wait(60.0)
            steps = panel.simulation.steps
            until(lambda: panel.simulation.steps > steps + 100, "physics")
        finally:
            free.set()


def test_the_page_answers_and_pictures_come_while_a_step_is_computed():
    begun, free = threading.Event(), threading.Event()
    free.set()

    def force(time, positions, velocities):
        if time > 0.1:
            begun.set()
            free.wait()
        return np.zeros_like(positions)

    with pc.live(lambda: pc.Scene(BALL, pc.CustomForce(force)), dt=1e-2, show=False) as panel:
        free.clear()
        panel.play()
        try:
            assert begun.wait(60.0)
            with urllib.request.urlopen(panel.url, timeout=60) as answer:
                assert answer.status == 200
            before = panel.artist.picture
            panel.artist.watch(on=True)
            until(lambda: panel.artist.picture is not before, "a picture")
        finally:
            free.set()


def test_a_pace_that_cannot_be_kept_is_told():
    with pc.live(lambda: pc.Scene(BALL, pc.Gravity()), dt=1e-4, speed=1e6, show=False) as panel:
        panel.play()
        until(lambda: panel.report.pace is not None, "the pace")
        assert panel.report.pace < 0.95
        panel.pause()
        panel.step()
        assert panel.report.pace is None


def test_the_way_between_two_moments_is_gone_in_their_time():
    scene = pc.Scene(BALL)
    simulation = pc.Simulation(scene, dt=0.1)
    from physcore.simulation.passage import Course

    passage = Course(simulation).advance(0.1, audited=False)
    moment = Moment(passage, scene, 0.0, clock=50.0, interval=0.2, hand=None)
    for now, share in ((49.0, 0.0), (50.05, 0.25), (50.1, 0.5), (50.2, 1.0), (99.0, 1.0)):
        assert moment.share(now) == pytest.approx(share)
        assert moment.state(share).positions[0, 0] == pytest.approx(0.1 * share)


def test_speeds_suit_the_time_step():
    assert nominal_speed(1e-3, 60.0) == 1.0
    assert nominal_speed(3600.0, 60.0) == 9e5  # 240 hours per second
    assert nominal_speed(1e-15, 60.0) == 2e-13


def test_a_reel_keeps_the_last_seconds_and_no_more_than_its_memory():
    small, large = Reel(), Reel()
    pixels = np.zeros((20, 20, 3), dtype=np.uint8)
    for number in range(1000):
        small.add(number / 60.0, pixels + np.uint8(number % 200))
    content = small.gif(pc.Scene(BALL))
    import io

    from PIL import Image

    with Image.open(io.BytesIO(content)) as film:
        assert film.n_frames == SECONDS * RATE
        durations = []
        for frame in range(film.n_frames):
            film.seek(frame)
            durations.append(film.info["duration"])
    assert sum(durations) == pytest.approx(1e3 * SECONDS, rel=0.02)
    picture = np.zeros((2000, 2000, 3), dtype=np.uint8)
    for number in range(30):
        large.add(float(number), picture)
    assert len(large._pictures) == BYTES // picture.nbytes
