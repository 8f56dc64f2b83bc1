"""Identities of values and functions: equal in every process for equal ones, different for different ones."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from functools import partial

import numpy as np
import pytest

import physcore as pc
from physcore.storage.identity import identity


def height(recording):
    return recording.positions[-1, :, 1].min()


def above(limit):
    return lambda recording: recording > limit


class Scaled:
    def __init__(self, factor):
        self.factor = factor

    def __call__(self, recording):
        return self.factor * recording

    def method(self, recording):
        return recording


def recursive():
    def inner(count):
        return 0 if count == 0 else inner(count - 1)

    return inner


DIFFERENT = [
    None, True, 1, 1.5, "1", 1 + 2j, b"1", [1], [1, 2], {"a": 1}, {"b": 1}, {1: 2},
    np.zeros(3), np.zeros(4), np.ones(3), np.zeros(3, dtype=np.float32), np.zeros((1, 3)), range(3), slice(1, 2),
    math.sin, math.cos, np.sin, np.max, height, above(1.0), above(2.0), recursive(),
    lambda x: 1.0, lambda x: 2.0, lambda x, y=1: x, lambda x, y=2: x, lambda x, *, y=1: x,
    partial(height, 1), partial(height, 2), partial(height, a=1), partial(Scaled, 1),
    Scaled(1.0), Scaled(2.0), Scaled(1.0).method, Scaled, np,
    pc.PEFRL(), pc.VelocityVerlet(), pc.AutoStep(0.4), pc.AutoStep(0.3), pc.Particles([[0.0, 0.0]]),
    pc.Particles([[0.0, 1.0]]), pc.Gravity(),
]  # fmt: skip


def test_different_values_have_different_identities():
    found = [json.dumps(identity(value, "value")) for value in DIFFERENT]
    assert len(set(found)) == len(found)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (1.5, np.float64(1.5)),
        ((1, 2), [1, 2]),
        (above(1.0), above(1.0)),
        (np.arange(6)[::2], np.array([0, 2, 4])),
        (Scaled(1.0), Scaled(1.0)),
        (pc.Particles([[0.0, 0.0]], name="ball"), pc.Particles([[0.0, 0.0]], name="ball")),
        (recursive(), recursive()),
    ],
)
def test_equal_values_have_equal_identities(one, other):
    assert identity(one, "value") == identity(other, "value")


def test_what_cannot_be_recognized_is_refused(tmp_path):
    with open(tmp_path / "file", "w", encoding="utf-8") as file:
        for value in (file, [file], lambda: file, partial(height, file), np.array([file])):
            with pytest.raises(pc.SceneError, match=r"^measure: .* cannot be recognized in another process"):
                identity(value, "measure")


def test_a_function_is_the_same_one_in_another_module_and_another_process(tmp_path):
    source = (
        "def sag(recording, power=2):\n    return recording.positions[-1] ** power\n\nbend = lambda recording: 3.5\n"
    )
    program = (
        "import json\nfrom physcore.storage.identity import identity\n"
        "print(json.dumps([identity(sag, ''), identity(bend, '')]))"
    )
    (tmp_path / "helper.py").write_text(source, encoding="utf-8")
    (tmp_path / "script.py").write_text(f"{source}\n{program}\n", encoding="utf-8")
    (tmp_path / "other.py").write_text(f"from helper import sag, bend\n{program}\n", encoding="utf-8")

    def printed(name):
        return subprocess.run([sys.executable, tmp_path / name], capture_output=True, text=True, check=True).stdout

    assert printed("script.py") == printed("other.py")


def test_code_without_source_is_recognized_by_itself():
    def made(text):
        namespace = {}
        exec(text, namespace)
        return identity(namespace["f"], "f")

    assert made("def f(x): return x + 1") == made("def f(x): return x + 1")
    assert made("def f(x): return x + 1") != made("def f(x): return x + 2")
    assert made("def f(x): return x in {1, 'a'}") == made("def f(x): return x in {'a', 1}")


def test_a_key_stands_for_the_functions_of_a_scene():
    body = pc.Particles([[0.0, 0.0]])

    def scene(strength, mass=1.0):
        return pc.Scene(body, pc.CustomForce(lambda time, x, v: -strength * x), pc.Gravity((0.0, -mass)))

    with pytest.raises(pc.FileError, match=r"forces\[0\].function: .* this function is code"):
        scene(1.0).hash()
    assert scene(1.0).hash("linear") == scene(2.0).hash("linear") != scene(1.0).hash("cubic")
    assert scene(1.0).hash("linear") != scene(1.0, mass=2.0).hash("linear")
    plain = pc.Scene(body)
    assert plain.hash("name") not in (plain.hash(), plain.hash("other"))
