"""The panel as a widget of a notebook."""

from __future__ import annotations

import struct

import numpy as np
import pytest

import physcore as pc
from chromium import Browser, executable, until

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")
pytest.importorskip("anywidget", reason="the extra physcore[live] is not installed")

from physcore.panel.display import widget
from physcore.panel.server import framed


def build(pull):
    return pc.Scene(pc.Particles([[0.0, 1.0]], name="ball"), pc.Gravity((0.0, -pull)))


@pytest.fixture
def panel():
    with pc.live(build, pull=pc.Slider(0.0, 20.0, 9.81), show=False, size=(64, 48)) as opened:
        yield opened


def test_a_view_is_greeted_sees_pictures_and_asks(panel, monkeypatch):
    shown, sent = widget(panel), []
    monkeypatch.setattr(shown, "send", lambda content, buffers=(): sent.append((content, list(buffers))))

    def ask(**message):
        shown._handle_custom_msg(message, [])

    ask(do="open")
    assert [content["kind"] for content, _ in sent[:2]] == ["hello", "report"]
    until(lambda: any(buffers for _, buffers in sent), "a picture")
    (picture,) = next(buffers for _, buffers in sent if buffers)
    assert struct.unpack_from("<4sII", picture) == (b"RGB ", 64, 48)
    ask(do="seen")
    ask(do="play")
    until(lambda: panel.simulation.time > 0.05, "physics")
    ask(do="set", values={"pull": 1.0})
    until(lambda: panel.values["pull"] == 1.0, "the slider")
    ask(do="save")
    until(lambda: any(buffers and buffers[0][:4] == b"GIF " for _, buffers in sent), "the film")
    ask(do="shut")
    until(lambda: panel.closed, "the end")


def test_a_view_that_is_opened_again_in_time_keeps_the_panel(panel, monkeypatch):
    shown = widget(panel)
    monkeypatch.setattr(shown, "send", lambda content, buffers=(): None)
    shown._handle_custom_msg({"do": "open"}, [])
    shown._handle_custom_msg({"do": "shut"}, [])
    leaving = shown._leaving
    shown._handle_custom_msg({"do": "open"}, [])
    leaving.join()
    assert not panel.closed
    assert shown._leaving is None


@pytest.mark.skipif(executable() is None, reason="there is no Chromium: apt-get install chromium")
def test_the_module_of_the_widget_shows_pictures_in_a_browser(panel, tmp_path):
    """A model in JavaScript stands for the kernel: it sends what the kernel would, and keeps what it is sent."""
    import json

    shown = widget(panel)
    pixels = np.zeros((2, 3, 3), dtype=np.uint8)
    pixels[0, 0] = (10, 20, 30)
    hello, report = (json.loads(text) for text in panel.greeting())
    browser = Browser(tmp_path)
    page = browser.page("about:blank")
    model = """
        window.sent = [];
        const on = (kind, call) => { window.heard = call; };
        window.model = {send: message => sent.push(message), on, off: () => {}};
        window.bytes = new Uint8Array(%s);
        (async code => {
          const module = await import(URL.createObjectURL(new Blob([code], {type: "text/javascript"})));
          window.end = module.default.render({model, el: document.body});
          heard(%s); heard(%s);
          heard({kind: "picture"}, [new DataView(bytes.buffer)]);
          return "loaded";
        })(%s)
    """ % (list(framed(pixels, None)), json.dumps(hello), json.dumps(report), json.dumps(shown._esm))  # noqa: UP031
    assert page.evaluate(model) == "loaded"
    page.until("document.querySelector('.film canvas').width == 3")
    colors = "document.querySelector('.film canvas').getContext('2d').getImageData(0, 0, 1, 1).data"
    assert page.evaluate(f"Array.from({colors})") == [10, 20, 30, 255]
    page.click(".play")
    page.evaluate("end()")
    asked = page.evaluate("sent.map(message => message.do)")
    assert asked[0] == "open"
    assert {"look", "seen", "play"} <= set(asked)
    assert asked[-1] == "shut"
    browser.close()
