"""The server of a panel: who has an answer, and what the page gets."""

from __future__ import annotations

import http.client
import json
import re
import struct
from urllib.parse import urlsplit

import numpy as np
import pytest

import physcore as pc
from chromium import until
from physcore.panel import server
from physcore.panel.panel import page

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect


def build(stiffness):
    sheet = pc.cloth((6, 4), 0.05, stiffness=stiffness, damping=0.02, mass=2e-3, pinned="top corners", name="net")
    return pc.Scene(sheet, pc.Gravity())


@pytest.fixture(scope="module")
def panel():
    """A panel that stays open between two clients, however long that takes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server, "GRACE", 1e6)
        yield from opened()


def opened():
    with pc.live(build, stiffness=pc.Slider(20.0, 2000.0, 200.0), show=False, size=(160, 120)) as panel:
        yield panel


def ask(panel, path, method="GET", **headers):
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(panel.url).port, timeout=60)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, dict(answer.getheaders()), body


def test_the_page_is_one_file_with_nothing_from_elsewhere(panel):
    address = urlsplit(panel.url)
    assert address.hostname == "127.0.0.1"
    status, headers, body = ask(panel, f"/?{address.query}")
    assert status == 200
    assert body.decode() == page()
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert headers["Referrer-Policy"] == "no-referrer"
    assert not re.search(r"""(src|href)\s*=\s*["']?(https?:)?//|@import|url\(""", page())


FOREIGN = [
    ("/", {}),
    ("/?token=", {}),
    ("/?token=wrong", {}),
    ("/?{token}&{token}", {}),
    ("/?{token}x", {}),
    ("/?{token}", {"Host": "example.org"}),
    ("/?{token}", {"Host": "127.0.0.1"}),
    ("/?{token}", {"Host": "127.0.0.1.example.org:{port}"}),
    ("/?{token}", {"Origin": "http://example.org"}),
    ("/?{token}", {"Origin": "null"}),
    ("/?{token}", {"Origin": "https://127.0.0.1:{port}"}),
    ("/?{token}", {"Origin": "http://127.0.0.1:1"}),
    ("/socket?token=wrong", {}),
]


@pytest.mark.parametrize(("path", "headers"), FOREIGN, ids=str)
def test_strangers_get_nothing(panel, path, headers):
    address = urlsplit(panel.url)
    words = {"token": address.query, "port": address.port}
    status, _, body = ask(
        panel, path.format(**words), **{name: value.format(**words) for name, value in headers.items()}
    )
    assert status == 403
    assert address.query.encode() not in body
    assert len(body) < 40


@pytest.mark.parametrize(
    "path", ["/page.html", "/../../../../etc/passwd", "//etc/passwd", "//x/", "http://x/", "/socket/", "/index.html"]
)
def test_no_file_is_read_for_a_request(panel, path):
    status, _, body = ask(panel, f"{path}?{urlsplit(panel.url).query}")
    assert status in (403, 404)
    assert len(body) < 40


def test_a_socket_needs_the_token_and_an_own_origin(panel):
    address = urlsplit(panel.url)
    own = f"ws://127.0.0.1:{address.port}/socket"
    for url, origin in (
        (own, None),
        (f"{own}?token=wrong", None),
        (f"{own}?{address.query}", "http://example.org"),
        (f"{own}?{address.query}", "null"),
    ):
        with pytest.raises(InvalidStatus) as refused:
            connect(url, origin=origin)
        assert refused.value.response.status_code == 403


@pytest.fixture
def client(panel):
    address = urlsplit(panel.url)
    origin = f"http://127.0.0.1:{address.port}"
    with connect(f"ws://127.0.0.1:{address.port}/socket?{address.query}", origin=origin, max_size=None) as opened:
        yield opened


def heard(client, kind):
    """The next message of a kind."""
    while True:
        message = client.recv(timeout=120)
        if isinstance(message, bytes):
            if kind is bytes:
                return message
        elif kind is not bytes and (content := json.loads(message))["kind"] == kind:
            return content


def test_a_client_is_greeted_and_sees_what_the_renderer_draws(panel, client):
    panel.reset()
    hello = heard(client, "hello")
    (slider,) = hello["controls"]
    assert slider == {
        "name": "stiffness", "kind": "slider", "lower": 20.0, "upper": 2000.0, "whole": False, "logarithmic": False
    }  # fmt: skip
    client.send(json.dumps({"do": "frame"}))
    content = heard(client, bytes)
    kind, width, height, *hand = struct.unpack_from("<4sII4f", content)
    assert (kind, width, height) == (b"RGB ", 160, 120)
    assert np.isnan(hand).all()
    pixels = np.frombuffer(content, np.uint8, offset=28).reshape(120, 160, 3)
    expected = pc.Renderer(panel.simulation.scene, size=(160, 120), room=1.25, fps=60).draw(panel.simulation)
    np.testing.assert_array_equal(pixels, expected)


def test_requests_of_a_client_are_done(panel, client):
    client.send(json.dumps({"do": "play"}))
    until(lambda: panel.simulation.time > 0.05, "physics")
    client.send(json.dumps({"do": "set", "values": {"stiffness": 500.0}}))
    until(lambda: panel.values["stiffness"] == 500.0, "the slider")
    client.send(json.dumps({"do": "speed", "factor": 0.5}))
    until(lambda: panel.report.speed == 0.5, "the speed")
    client.send(json.dumps({"do": "reset"}))
    until(lambda: panel.simulation.time == 0.0, "the reset")
    client.send(json.dumps({"do": "step"}))
    until(lambda: panel.simulation.steps == 1, "the step")
    client.send(json.dumps({"do": "set", "values": {"stiffness": 1.0}}))
    until(lambda: panel.error, "the message")
    assert panel.error == "set.stiffness: must be ≥ 20, got 1"
    client.send(json.dumps({"do": "speed", "factor": 1.0}))
    until(lambda: panel.error == "", "the end of the message")


@pytest.mark.parametrize(
    "message",
    [
        "", "{", "[]", "3", "null", "[" * 50_000, b"\x00\xff", '{"do": "fly"}', '{"do": ["play"]}', '{"do": "set"}',
        '{"do": "set", "values": 3}', '{"do": "set", "values": {"k": 3}}', '{"do": "grab", "x": "left", "y": 0}',
        '{"do": "grab", "x": NaN, "y": 0}', '{"do": "drag", "x": 1e308, "y": -1e308}', '{"do": "speed", "factor": 0}',
        '{"do": "seen", "number": -7}', '{"do": "seen", "number": []}', '{"do": "look", "theme": "../etc", "width": 3}',
        '{"do": "__init__"}', '{"do": "set", "values": {"stiffness": {}}}',
    ],
    ids=str,
)  # fmt: skip
def test_no_message_does_harm(panel, client, message):
    panel.reset()
    state = panel.simulation.state_hash()
    client.send(message)
    client.send(json.dumps({"do": "speed", "factor": 1.0}))
    heard(client, "report")
    assert panel.simulation.state_hash() == state


def test_a_message_that_is_too_long_ends_the_connection_alone(panel, client):
    from websockets.exceptions import ConnectionClosed

    client.send("x" * 100_000)
    with pytest.raises(ConnectionClosed):
        heard(client, "never")
    assert panel.simulation.time >= 0.0


def test_the_last_seconds_are_saved_as_a_gif(panel, client, tmp_path):
    panel.play()
    until(lambda: heard(client, bytes) and not client.send('{"do": "seen", "number": 1}') and
          panel.simulation.time > 0.3, "pictures")  # fmt: skip
    panel.pause()
    client.send('{"do": "save"}')
    answer = heard(client, "saved")
    content = heard_gif(client)
    assert len(content) == answer["bytes"]
    (tmp_path / "sent.gif").write_bytes(content)
    panel.save(tmp_path / "own.gif")
    assert pc.provenance(tmp_path / "own.gif")[0]["scene"] == panel.simulation.scene.hash()
    from PIL import Image

    with Image.open(tmp_path / "sent.gif") as film:
        assert film.size == (160, 120)
        assert film.n_frames > 1
    with pytest.raises(pc.FileError, match=r"must end in .gif"):
        panel.save(tmp_path / "own.mp4")


def heard_gif(client):
    while True:
        content = heard(client, bytes)
        if content[:4] == b"GIF ":
            return content[4:]


def test_nothing_is_saved_before_anything_is_seen(tmp_path):
    with (
        pc.live(build, stiffness=pc.Slider(20.0, 2000.0), show=False) as panel,
        pytest.raises(pc.SceneError, match=r"^save: nothing was drawn yet"),
    ):
        panel.save(tmp_path / "own.gif")
