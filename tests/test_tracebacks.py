"""Tracebacks of mistakes: the user's lines and the message, no lines of the package."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

import physcore as pc
from forks import Forks
from physcore.entrance import FULL, entrance

BALL = """import warnings
import physcore as pc
ball = pc.Particles([[0.0, 1.0]])
scene = pc.Scene(ball, pc.Gravity())
"""

MISTAKES = {
    "constructor": "pc.Particles([[0.0, 0.0]], mass=-1.0)",
    "dataclass": "pc.Gravity('down')",
    "builder": "pc.cloth((4, 4), spacing=-1.0, stiffness=1.0)",
    "class method": "pc.Fluid.block((0.0, 0.0), (1.0, 1.0), -0.1)",
    "function": "pc.simulate(scene, 1.0, dt=-1.0)",
    "keyword": "pc.simulate(scene, 1.0, integrater='RK4')",
    "name": "pc.simulate(scene, 1.0, integrator='RK4')",
    "method": "pc.Simulation(scene, dt=0.1).step(-1)",
    "item": "pc.Simulation(scene)['nix']",
    "recording": "pc.simulate(scene, 0.1).plot('nix')",
    "body of a recording": "pc.simulate(scene, 0.1)['nix']",
    "study": "pc.tradeoff(scene, -1.0)",
    "nested": "pc.lyapunov(scene, 1.0, integrator='nix')",
    "film": "pc.film(scene, 'film.nix', duration=1.0)",
    "style": "pc.film(scene, 'film.gif', duration=1.0, style=pc.styles.Points(size=-1.0))",
    "camera": "pc.Orbit(azimuth='north')",
    "file": "pc.load('missing.npz')",
    "provenance": "pc.provenance('missing.gif')",
    "event": "pc.simulate(scene, 0.1, events=[pc.Event(lambda state: 1 / (state.time < 0.05))])",
    "event of adaptive steps": (
        "pc.Simulation(scene, dt=pc.AdaptiveStep()).run(0.1, events=[pc.Event(lambda state: 1 / (state.time < 0.05))])"
    ),
    "events of a recording": "pc.simulate(scene, 0.1).events['nix']",
    "divergence": "pc.simulate(pc.Scene(ball, pc.CentralForce((0.0, 0.0), 1e6, 1.0)), 1.0, dt=0.1)",
    "warning": (
        "warnings.simplefilter('error')\npc.Simulation(pc.Scene(ball, pc.CentralForce((0.0, 0.0), 1e6, 1.0)), dt=0.1)"
    ),
}


def files_of(errors: str) -> list[str]:
    """The files in tracebacks, in the order in which Python prints them."""
    return re.findall(r'File "(.*?)", line', errors)


@pytest.fixture(scope="module")
def tracebacks() -> dict[str, list[str]]:
    """The files in the traceback of each mistake."""
    with closing(Forks(**{FULL: ""})) as forks:
        return {name: files_of(forks.run(BALL + mistake).stderr) for name, mistake in MISTAKES.items()}


def entries(code: str, **environment: str) -> list[str]:
    """The files in the tracebacks of a script that fails."""
    program = [sys.executable, "-c", code]
    known = {name: value for name, value in os.environ.items() if name != FULL}
    done = subprocess.run(program, capture_output=True, text=True, env={**known, **environment})
    assert done.returncode == 1, done.stderr
    return files_of(done.stderr)


def own(file: str) -> bool:
    """Whether a file is part of the package."""
    return Path(file).is_relative_to(Path(pc.__file__).parent)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_traceback_of_a_mistake_has_the_users_line_alone(mistake, tracebacks):
    files = tracebacks[mistake]
    assert not any(map(own, files))
    assert files[-1] == "<script>"


CALLBACK = """
def pull(time, x, v):
    return inner(x)
def inner(x):
    return 1 / 0 * x
pc.Simulation(pc.Scene(ball, pc.CustomForce(pull))).step()
"""


def test_frames_of_the_users_own_functions_stay():
    # pull and inner in the cause, and the line that calls the package.
    assert entries(BALL + CALLBACK) == ["<string>"] * 3


def test_internal_errors_keep_all_frames():
    @entrance
    def step():
        raise pc.InternalError("please report")

    with pytest.raises(pc.InternalError) as caught:
        step()
    assert [entry.name for entry in caught.traceback] == ["test_internal_errors_keep_all_frames", "entered", "step"]


def test_all_frames_are_shown_when_asked_for():
    files = entries(BALL + MISTAKES["function"], **{FULL: "full"})
    assert sum(map(own, files)) >= 3
