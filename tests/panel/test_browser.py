"""The page of a panel in headless Chromium."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest

import physcore as pc
from chromium import Browser, executable, until

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")
pytestmark = pytest.mark.skipif(executable() is None, reason="there is no Chromium: apt-get install chromium")

SHIFT = 8
"""The key in a mouse event of the protocol."""
PRESS = 10.0
"""Time after which a press of the mouse that nothing has come of is repeated [s]."""


def build(stiffness, gravity, shape):
    columns = {"wide": 12, "narrow": 6}[shape]
    net = pc.cloth((columns, 8), 0.05, stiffness=stiffness, damping=0.02, mass=2e-3, pinned="top corners", name="net")
    return pc.Scene(net, *([pc.Gravity()] if gravity else []))


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    opened = Browser(tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


@pytest.fixture
def panel():
    controls = {
        "stiffness": pc.Slider(20.0, 2000.0, 200.0, logarithmic=True),
        "gravity": pc.Switch(True),
        "shape": pc.Choice(("wide", "narrow")),
    }
    with pc.live(build, show=False, size=(320, 240), **controls) as opened:
        yield opened


@pytest.fixture
def page(browser, panel):
    opened = browser.page(panel.url)
    opened.until("document.querySelectorAll('.control').length == 4 && Number(panel.dataset.pictures) > 0")
    yield opened
    opened.close()


def test_the_buttons_play_pause_step_and_reset(panel, page):
    page.click(".play")
    until(lambda: panel.simulation.time > 0.1, "physics")
    page.until("document.querySelector('.play').textContent == 'Pause' && Number(panel.dataset.pictures) > 3")
    page.click(".play")
    page.until("panel.dataset.playing == 'false'")
    steps = panel.simulation.steps
    page.click(".step")
    until(lambda: panel.simulation.steps == steps + 1, "the step")
    page.click(".reset")
    until(lambda: panel.simulation.steps == 0, "the reset")
    page.until("panel.dataset.steps == '0'")


def test_controls_move_the_physics(panel, page):
    panel.play()
    page.evaluate("(input => { input.value = input.max; input.dispatchEvent(new Event('input')); })"
                  "(document.querySelector('[data-name=stiffness] input'))")  # fmt: skip
    until(lambda: panel.values["stiffness"] == 2000.0, "the slider")
    page.until("document.querySelector('.said').textContent == 'goes on from the present state'")
    assert panel.simulation.time > 0.0
    assert panel.simulation.energy().work > 0.0  # the springs became stiffer while they were stretched
    page.click("[data-name=gravity] input")
    until(lambda: panel.values["gravity"] is False, "the switch")
    assert panel.simulation.scene.forces == ()
    page.click("[data-name=shape] button:last-of-type")
    until(lambda: panel.values["shape"] == "narrow", "the choice")
    page.until("document.querySelector('.said').textContent.startsWith('started anew')")
    assert len(panel.simulation.positions) == 48


def grasp(panel, page, point):
    """Take hold of what is at a point [m], and return the scale of the page and the place of its origin.

    The page may still move its parts when the mouse is pressed, and the press then misses: it is repeated.
    """
    for _ in range(10):
        box = page.evaluate("(box => [box.x, box.y, box.width / 320])"
                            "(document.querySelector('.film canvas').getBoundingClientRect())")  # fmt: skip
        pixels, _, _ = panel.artist.picture.view.project(np.array([point]))
        place = np.array(box[:2]) + box[2] * pixels[0]
        page.mouse("mousePressed", *place.tolist())
        end = time.monotonic() + PRESS
        while time.monotonic() < end:
            if panel.runner.moment.hand:
                return box[2], np.array(box[:2])
            time.sleep(0.02)
        page.mouse("mouseReleased", *place.tolist())
    raise AssertionError("nothing was held")


def test_the_wheel_zooms_and_the_right_button_turns(browser):
    """By the same angles and factor as `Renderer.turn`; "Fit" goes back. In the picture up is +z all the time."""
    ball = pc.Particles([[0.3, 0.2, 0.5]], radius=0.2)
    with pc.live(lambda: pc.Scene(ball, pc.Floor(), pc.Gravity()), show=False, size=(320, 240)) as panel:
        page = browser.page(panel.url)
        page.until("Number(panel.dataset.pictures) > 0")
        before = panel.artist.picture.view
        x, y = page.middle(".film canvas")
        page.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-400)
        until(lambda: panel.artist.picture.view.scale > 1.5 * before.scale, "the zoom")
        assert panel.artist.picture.view.scale == pytest.approx(np.exp(0.6) * before.scale, rel=1e-3)
        for kind, across in (("mousePressed", 0), ("mouseMoved", 50), ("mouseReleased", 50)):
            page.call("Input.dispatchMouseEvent", type=kind, x=x + across, y=y, button="right", buttons=2)
        until(lambda: not np.allclose(panel.artist.picture.view.axes, before.axes), "the turn")
        until(lambda: panel.artist.picture.view.axes[0] @ before.axes[0] < 0.95, "the whole turn")
        now = panel.artist.picture.view
        assert now.axes[0] @ before.axes[0] == pytest.approx(np.cos(np.radians(20.0)), abs=1e-6)
        np.testing.assert_allclose(now.axes.T @ now.center, before.axes.T @ before.center, atol=1e-9)
        page.click(".frame")
        until(lambda: np.allclose(panel.artist.picture.view.axes, before.axes), "the fit")
        page.close()


def test_a_drag_closes_the_budget(panel, page):
    """The mouse takes the lower corner of the net and draws it aside; what it did is work."""
    start = panel.simulation.energy().balance
    corner = panel.simulation["net"].positions[0]
    scale, origin = grasp(panel, page, corner)
    pixels, _, _ = panel.artist.picture.view.project(corner[np.newaxis])
    x, y = (origin + scale * pixels[0]).tolist()
    until(lambda: "central" in panel.simulation.energy().by_term, "the grasp")
    for share in range(1, 11):
        page.mouse("mouseMoved", x - 8.0 * share, y + 4.0 * share)
    panel.play()
    until(lambda: np.linalg.norm(panel.simulation["net"].positions[0] - corner) > 0.05, "the drag")
    page.mouse("mouseReleased", x - 80.0, y + 40.0)
    until(lambda: "central" not in panel.simulation.energy().by_term, "the release")
    panel.pause()
    energy = panel.simulation.energy()
    assert energy.work != 0.0
    assert abs(energy.balance - start) < 0.02 * (energy.kinetic + abs(energy.work) + energy.dissipated)


def test_the_pointer_is_where_the_mouse_is(panel, page):
    """What is held comes to rest near the mouse: the picture's pixels are turned back into meters."""
    panel.set(gravity=False)
    corner = panel.simulation["net"].positions[0]
    target = corner + np.array([-0.05, -0.05])
    scale, origin = grasp(panel, page, corner)
    pixels, _, magnification = panel.artist.picture.view.project(target[np.newaxis])
    place = (origin + scale * pixels[0]).tolist()
    page.mouse("mouseMoved", *place)
    pixel = 1.0 / float(magnification[0]) / scale
    until(lambda: np.abs(np.array(panel.runner.moment.hand[1]) - target).max() < 2.0 * pixel, "the pointer")
    page.mouse("mouseReleased", *place)


def test_a_drag_with_the_shift_key_turns_a_rigid_body(browser):
    wheel = pc.RigidBody(pc.Rectangle(0.4, 0.2), (0.0, 0.0), mass=1.0, name="wheel")
    with pc.live(lambda: pc.Scene(wheel), dt=1e-3, show=False, size=(320, 240)) as panel:
        page = browser.page(panel.url)
        page.until("Number(panel.dataset.pictures) > 0")
        hint = "Mouse: drag to pull, Shift and drag to turn a body, wheel to zoom"
        assert page.evaluate("document.querySelector('.hint').textContent") == hint
        x, y = page.middle(".film canvas")
        for kind, across in (("mousePressed", 0), ("mouseMoved", 60), ("mouseMoved", 120)):
            page.call(
                "Input.dispatchMouseEvent", type=kind, x=x + across, y=y, button="left", buttons=1, modifiers=SHIFT
            )
        height = page.evaluate("document.querySelector('.film canvas').getBoundingClientRect().height")
        angle = -np.pi * 120.0 / height

        def turned():
            hand = panel.runner.read(lambda session: session.hand)
            return hand is not None and hand.rotation is not None and abs(hand.rotation[0] - angle) < 0.01

        until(turned, "the turn")
        panel.play()
        until(lambda: abs(panel.simulation["wheel"].angles[0] - angle) < 0.1, "the wheel")
        page.mouse("mouseReleased", x, y)
        until(lambda: panel.runner.moment.hand is None, "the release")
        energy = panel.simulation.energy()
        assert energy.work > 0.0
        # The method has order 2, and the hand a frequency of 25 rad/s.
        assert abs(energy.balance) < 10.0 * (25.0 * 1e-3) ** 2 * (energy.kinetic + energy.work)
        page.close()


def test_a_busy_page_loses_no_press(browser, panel, page):
    """All that the mouse did while a page was busy comes at once: it sends all of it, in its order.

    A second finger changes nothing, and the capture of a pointer that has been released already fails.
    """
    sent = page.evaluate("""(() => {
        const root = document.createElement("div"), sent = [];
        document.body.append(root);
        mount(root, {send: message => sent.push(message.do), open: () => {}});
        const film = root.querySelector("canvas"), box = film.getBoundingClientRect();
        const act = (kind, pointerId, x) => film.dispatchEvent(new PointerEvent(kind,
            {pointerId, button: 0, clientX: box.x + x, clientY: box.y + 10, bubbles: true}));
        act("pointerdown", 77, 10); act("pointerdown", 78, 50); act("pointermove", 77, 20); act("pointermove", 78, 60);
        act("pointerup", 78, 60); act("pointermove", 77, 30); act("pointerup", 77, 30);
        act("lostpointercapture", 77, 30); act("pointerdown", 79, 40); act("pointercancel", 79, 40);
        root.remove();
        return sent;
    })()""")
    assert sent == ["grab", "drag", "release", "grab", "release"]


def test_the_film_of_the_last_seconds_is_saved(panel, page):
    panel.play()
    page.until("Number(panel.dataset.pictures) > 20")
    page.click(".save")
    page.until("Number(panel.dataset.saved) > 1000")


def test_a_step_above_the_limit_is_shown(browser):
    def stiff(stiffness):
        return build(stiffness, True, "wide")

    with pc.live(stiff, stiffness=pc.Slider(20.0, 4000.0, 20.0), dt=4e-3, show=False, size=(160, 120)) as panel:
        page = browser.page(panel.url)
        page.until("document.querySelector('.share') && document.querySelector('.share').textContent.includes('%')")
        assert page.evaluate("document.querySelector('.plan').classList.contains('over')") is False
        panel.set(stiffness=4000.0)
        page.until("document.querySelector('.plan').classList.contains('over')")
        page.until("document.querySelector('.term').textContent.includes('above the stability limit')")
        page.close()


def test_a_closed_page_ends_the_simulation_and_a_reload_does_not(browser, panel):
    page = browser.page(panel.url)
    page.until("Number(panel.dataset.pictures) > 0")
    page.call("Page.reload")
    page.until("window.panel && Number(panel.dataset.pictures) > 0")
    panel.play()
    until(lambda: panel.simulation.time > 0.05, "physics")
    page.close()
    until(lambda: panel.closed, "the end")
    with pytest.raises(pc.PhyscoreError, match="closed"):
        panel.play()


def test_a_page_tells_when_its_panel_is_closed(browser, panel):
    page = browser.page(panel.url)
    page.until("Number(panel.dataset.pictures) > 0")
    panel.close()
    page.until("panel.dataset.ended == 'true'")
    page.close()


def test_a_foreign_page_gets_nothing(browser, panel, page):
    """A page of another origin, which even knows the address, can neither read it nor open its socket."""
    foreign = browser.page("data:text/html,<p>foreign</p>")
    foreign.until("document.readyState == 'complete'")
    url = json.dumps(panel.url)
    fetched = f"fetch({url}).then(answer => answer.text()).then(text => 'read', error => 'refused')"
    assert foreign.evaluate(fetched) == "refused"
    socket = json.dumps(panel.url.replace("http:", "ws:").replace("/?", "/socket?"))
    opened = (
        f"new Promise(done => {{ const socket = new WebSocket({socket}); "
        "socket.onopen = () => done('open'); socket.onerror = () => done('refused'); })"
    )
    assert foreign.evaluate(opened) == "refused"
    assert page.evaluate(opened) == "open"
    foreign.close()
    wrong = browser.page(panel.url + "x")
    wrong.until("document.readyState == 'complete' && !!document.body")
    assert wrong.evaluate("document.body.textContent").strip() == "Forbidden"
    wrong.close()
