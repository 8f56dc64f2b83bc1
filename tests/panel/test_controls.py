"""Controls: their ranges, and the values that they take."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: pc.Slider(2.0, 1.0), r"^Slider.upper: must be above the lower end 2, got 1$"),
        (lambda: pc.Slider(1.0, 1.0), r"^Slider.upper: must be above"),
        (lambda: pc.Slider(0.0, 1.0, 3.0), r"^Slider.value: must be ≤ 1, got 3$"),
        (lambda: pc.Slider(0.0, float("inf")), r"^Slider.upper: must be finite"),
        (lambda: pc.Slider("0", 1.0), r"^Slider.lower: must be a number"),
        (lambda: pc.Slider(0.0, 1.0, logarithmic=True), r"^Slider.lower: must be > 0 on a logarithmic scale, got 0$"),
        (lambda: pc.Switch(1), r"^Switch.value: must be True or False, got 1$"),
        (lambda: pc.Choice(()), r"^Choice.options: must be words or numbers, at least one, got none$"),
        (lambda: pc.Choice("ab"), r"^Choice.options: must be a list of words or numbers, got 'ab'$"),
        (lambda: pc.Choice(("a", "a")), r"^Choice.options\[1\]: 'a' is there twice$"),
        (lambda: pc.Choice(("a", None)), r"^Choice.options\[1\]: must be a word or a number, got None$"),
        (lambda: pc.Choice(("a", "b"), "c"), r"^Choice.value: must be one of 'a', 'b', got 'c'$"),
    ],
)
def test_a_control_that_has_no_valid_value_is_refused(wrong, message):
    with pytest.raises(pc.SceneError, match=message):
        wrong()


def test_values_at_the_start():
    assert pc.Slider(1.0, 2.0).value == 1.0
    assert pc.Switch().value is False
    assert pc.Choice(("a", "b")).value == "a"
    assert pc.Choice([1, 2.5], 2.5).value == 2.5


def test_whole_ends_make_whole_values():
    slider = pc.Slider(1, 20, 5)
    assert slider.whole
    assert slider.checked(7.0, "n") == 7
    assert isinstance(slider.checked(7.0, "n"), int)
    with pytest.raises(pc.SceneError, match=r"^n: must be a whole number, got 7.5$"):
        slider.checked(7.5, "n")
    assert not pc.Slider(1, 20, 5.0).whole
    assert pc.Slider(np.int64(1), 20).whole


@pytest.mark.parametrize("value", [True, "3", None, float("nan"), 11.0, [3.0]])
def test_a_slider_refuses_what_is_no_number_of_its_range(value):
    with pytest.raises(pc.SceneError, match=r"^set.k: "):
        pc.Slider(0.0, 10.0).checked(value, "set.k")
