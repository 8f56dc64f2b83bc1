"""`physcore live` for demos and scripts."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from urllib.parse import urlsplit

import pytest

pytest.importorskip("websockets", reason="the extra physcore[live] is not installed")
from websockets.sync.client import connect

from physcore.__main__ import main

CALLS = """
import physcore as pc

def build(pull):
    return pc.Scene(pc.Particles([[0.0, 1.0]], name="ball"), pc.Gravity((0.0, -pull)))

panel = pc.live(build, pull=pc.Slider(0.0, 20.0, 9.81))
"""
DEFINES = """
import physcore as pc

def build(pull=pc.Slider(0.0, 20.0, 9.81), height=1.0):
    return pc.Scene(pc.Particles([[0.0, height]], name="ball"), pc.Gravity((0.0, -pull)))
"""
HAS = "import physcore as pc\nscene = pc.Scene(pc.Particles([[0.0, 1.0]]), pc.Gravity())\n"


@pytest.mark.parametrize(("source", "controls"), [(CALLS, ["pull"]), (DEFINES, ["pull"]), (HAS, []), (None, [])])
def test_a_script_or_a_demo_plays_until_its_page_is_closed(source, controls, tmp_path):
    name = "figure_eight"
    if source is not None:
        name = str(tmp_path / "own.py")
        (tmp_path / "own.py").write_text(source)
    environment = {**os.environ, "BROWSER": "true", "PYTHONUNBUFFERED": "1"}  # a browser that shows nothing
    command = [sys.executable, "-m", "physcore", "live", name]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as process:
        line = process.stderr.readline()
        assert line.startswith("The panel is http://127.0.0.1:"), line + process.stderr.read()
        address = urlsplit(line.split()[-1])
        with connect(f"ws://{address.netloc}/socket?{address.query}", max_size=None) as client:
            hello = json.loads(client.recv())
            assert [control["name"] for control in hello["controls"]] == controls
            while True:  # The first page begins to play.
                message = client.recv(timeout=120)
                if isinstance(message, str) and json.loads(message)["time"] > 0.0:
                    break
        assert process.wait(timeout=120) == 0
        assert process.stderr.read() == ""


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (None, r"there is no such script"),
        ("x = 1\n", r"opens no panel by pc.live\(…\), and has no function or Scene called build or scene"),
        ("def build():\n    return 3\n", r"build: must return a Scene, got 3"),
    ],
)
def test_a_script_without_a_scene_is_told(source, message, tmp_path, capsys):
    path = tmp_path / "own.py"
    if source is not None:
        path.write_text(source)
    assert main(["live", str(path)]) == 2
    import re

    assert re.search(message, capsys.readouterr().err)


def test_an_unknown_demo_is_told(capsys):
    assert main(["live", "figure_eigth"]) == 2
    assert "did you mean 'figure_eight'" in capsys.readouterr().err
