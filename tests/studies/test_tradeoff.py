"""The face of `tradeoff`: what it takes, what it gives, and what it says when something is wrong."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import matplotlib.colors
import numpy as np
import pytest

import physcore as pc
from physcore.__main__ import main

pytestmark = pytest.mark.usefixtures("clock_of_work")

SCENE = pc.Scene(
    pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 100.0, fixed=[0], name="bob"), pc.Gravity((0.0, -1.0))
)
DUST = pc.Scene(pc.Particles([[0.0, 0.0]], velocities=[[1.0, 0.0]]), pc.Gravity((0.0, -1.0)))


@pytest.fixture(scope="module")
def trade() -> pc.Tradeoff:
    return pc.tradeoff(SCENE, 4.0, integrators=[pc.VelocityVerlet(), pc.RungeKutta4()], budget=2.0, seed=7)


def test_rows_have_what_they_promise(trade):
    for row in trade.rows:
        assert 0.0 < row.least_seconds <= row.seconds
        assert row.evaluations > 0
        assert row.pair_interactions == row.evaluations  # one spring
        assert row.bytes_swept > row.evaluations
        assert row.dt == pytest.approx(4.0 / 32 / round(4.0 / 32 / row.dt), rel=1e-15)
        assert row.error_uncertainty >= 0.0
        assert row.status == "ok"
        assert row.threads is None
        run = pc.Simulation(SCENE, **row.numerics)
        assert run.dt == row.dt
    assert {row.precision for row in trade.rows} == {"f64", "f32"}
    assert trade.scene is SCENE
    assert trade.duration == 4.0


def test_the_front_holds_what_nothing_beats(trade):
    front = trade.front
    assert list(front) == sorted(front, key=lambda row: row.seconds)
    assert all(one.error > two.error for one, two in pairwise(front))
    for row in trade.rows:
        beaten = any(other.seconds <= row.seconds and other.error < row.error for other in trade.rows)
        assert beaten or row in front or any(o.error == row.error and o.seconds <= row.seconds for o in front)


def test_the_best_is_the_fastest_within_an_error_or_the_closest_within_a_time(trade):
    best = trade.best(error=1e-4)
    assert best.error <= 1e-4
    assert all(row.seconds >= best.seconds for row in trade.rows if row.error <= 1e-4)
    quick = trade.best(seconds=best.seconds)
    assert quick.seconds <= best.seconds
    assert all(row.error >= quick.error for row in trade.rows if row.seconds <= best.seconds)


def test_a_wish_that_nothing_meets_says_how_close_one_gets(trade):
    with pytest.raises(pc.PhyscoreError, match="error: no row is within 1e-30 m; the closest is "):
        trade.best(error=1e-30)
    with pytest.raises(pc.PhyscoreError, match="seconds: no row takes 1e-12 s or less; the fastest is "):
        trade.best(seconds=1e-12)
    for wrong in ({}, {"error": 1.0, "seconds": 1.0}):
        with pytest.raises(pc.SceneError, match="either error= or seconds="):
            trade.best(**wrong)


def test_it_can_be_printed_explained_saved_and_drawn(trade, tmp_path):
    text = str(trade)
    assert text.count("\n") == len(trade.rows) + 2
    assert "evaluations" in text
    said = trade.explain()
    for word in ("trajectories can be compared", "RungeKutta4", "extrapolated", "the Pareto front", "Single precision"):
        assert word in said
    trade.save(tmp_path / "trade.json")
    content = json.loads((tmp_path / "trade.json").read_text(encoding="utf-8"))
    assert content["seed"] == 7
    assert content["machine"]["physcore"] == pc.__version__
    assert len(content["rows"]) == len(trade.rows)
    assert content["rows"][0]["integrator"] == "VelocityVerlet"
    axes = trade.plot(tmp_path / "trade.png")
    assert (tmp_path / "trade.png").read_bytes().startswith(b"\x89PNG")
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert trade.plot(axes=axes) is axes
    with pytest.raises(pc.FileError):
        trade.plot(tmp_path / "missing" / "trade.png")
    with pytest.raises(pc.FileError):
        trade.save(tmp_path / "missing" / "trade.json")


def test_variants_of_a_method_are_told_apart_everywhere(tmp_path):
    """By the parameters in which they differ, in the table, the sentences, the file and the figure."""
    methods = [pc.XPBD(1), pc.XPBD(5), pc.VelocityVerlet()]
    trade = pc.tradeoff(SCENE, 0.5, integrators=methods, precisions=["f64"], dts=[0.5 / 32], budget=0.5)
    names = ["XPBD(substeps=1)", "XPBD(substeps=5)", "VelocityVerlet"]
    assert [row.label for row in trade.rows] == names
    assert all(name in str(trade) for name in names)
    assert str(trade.rows[1]).startswith("XPBD(substeps=5), dt = ")
    trade.save(tmp_path / "trade.json")
    rows = json.loads((tmp_path / "trade.json").read_text(encoding="utf-8"))["rows"]
    assert [row["parameters"].get("substeps") for row in rows] == [1, 5, None]
    axes = trade.plot()
    legend = axes.get_legend()
    assert [text.get_text() for text in legend.get_texts()][:3] == names
    colors = [handle.get_color() for handle in legend.get_lines()[:3]]
    hues = [matplotlib.colors.rgb_to_hsv(color)[0] for color in colors]
    assert colors[0] != colors[1]
    assert hues[0] == pytest.approx(hues[1], abs=1e-6)
    assert hues[2] != pytest.approx(hues[0], abs=0.05)


def test_a_film_shows_the_choice_beside_the_reference(trade, tmp_path):
    trade.film(tmp_path / "trade.gif", error=1e-3, fps=5.0)
    assert (tmp_path / "trade.gif").read_bytes().startswith(b"GIF89a")


def test_what_cannot_be_computed_is_left_out_and_said():
    water = pc.Fluid(pc.block((0.0, 0.0), (0.4, 0.2), 0.05), 0.05)
    tank = pc.Scene(water, pc.Gravity((0.0, -1.0)), pc.Box((0.0, 0.0), (0.8, 0.4)))
    trade = pc.tradeoff(tank, 0.1, precisions=["f32"], budget=1.0)
    assert {type(row.integrator) for row in trade.rows} == {pc.SemiImplicitEuler, pc.VelocityVerlet, pc.McLachlan2}
    at_one_moment, backwards = trade.notes
    assert at_one_moment.startswith("Left out: ExplicitEuler f32, RungeKutta4 f32, ")
    assert backwards.startswith("Left out: PEFRL f32, ")
    fit = (
        "(integrator: expected SemiImplicitEuler(), VelocityVerlet(), McLachlan2() for a fluid that carries its density"
    )
    assert fit in at_one_moment
    assert fit in backwards
    assert "nothing has checked it" in trade.explain()
    with pytest.raises(pc.PhyscoreError, match="Left out: RungeKutta4 f32"):
        pc.tradeoff(tank, 0.1, integrators=[pc.RungeKutta4()], precisions=["f32"], budget=1.0)


def test_an_observer_says_what_counts():
    def height(simulation: pc.Simulation) -> float:
        return float(simulation.positions[0, 1])

    trade = pc.tradeoff(DUST, 2.0, integrators=[pc.SemiImplicitEuler()], precisions=["f64"], observe=height, budget=0.5)
    for row in trade.rows:
        assert row.error == pytest.approx(0.5 * 2.0 * row.dt, rel=1e-6, abs=1e-10)  # g t dt/2 too low at the end


def test_methods_that_make_no_error_are_said_to_make_none():
    """Verlet's parabola is exact: what is left is rounding."""
    trade = pc.tradeoff(DUST, 2.0, integrators=[pc.VelocityVerlet()], precisions=["f64"], budget=0.5)
    assert max(row.error for row in trade.rows) < 1e-13
    assert not any(row.certain for row in trade.rows)
    assert trade.best(error=1e-9) in trade.rows


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scene": SCENE.bodies[0]}, "scene: must be a Scene or a function"),
        ({"duration": 0.0}, "duration: must be > 0"),
        ({"duration": "long"}, "duration: must be a number"),
        ({"budget": -1.0}, "budget: must be > 0"),
        ({"integrators": []}, "integrators: must not be empty"),
        ({"integrators": [pc.VelocityVerlet]}, "integrators: must be integrators"),
        ({"precisions": ["f16"]}, "precisions: must be a tuple of"),
        ({"precisions": []}, "precisions: must not be empty"),
        ({"dts": []}, "dts: must not be empty"),
        ({"dts": [0.1, -1.0]}, r"dts\[1\]: must be > 0"),
        ({"seed": -1}, "seed: must be ≥ 0"),
        ({"resolutions": [1, 2]}, "resolutions: the scene must then be a function"),
        ({"scene": lambda n: SCENE}, "resolutions: must be two or more"),
        ({"scene": lambda n: SCENE, "resolutions": [2, 1]}, "resolutions: must be two or more, the coarsest first"),
        ({"scene": lambda n: n, "resolutions": [1, 2]}, "scene: must give a Scene, gave 1 at resolution 1"),
        ({"observe": lambda run: "high"}, "observe: must be an array of real numbers"),
        ({"observe": lambda run: math.nan}, "observe: must be finite"),
        ({"observe": lambda run: np.zeros(1 + run.steps)}, "observe: must always give one shape"),
    ],
)
def test_bad_input_is_named(arguments, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.tradeoff(**{"scene": SCENE, "duration": 1.0, "budget": 0.2, **arguments})


def test_what_does_not_fit_into_memory_is_refused_before_it_is_begun(monkeypatch):
    monkeypatch.setattr("physcore.memory.available", lambda: 1000)
    with pytest.raises(pc.SceneError, match="free"):
        pc.tradeoff(SCENE, 1.0, budget=0.2)


def test_the_command_measures_a_demo(capsys, tmp_path):
    figure, document = tmp_path / "orbits.png", tmp_path / "orbits.json"
    arguments = ["--duration", "2", "--budget", "1", "-o", str(figure), "--json", str(document)]
    assert main(["tradeoff", "orbits", *arguments]) == 0
    output = capsys.readouterr()
    assert "RungeKutta4" in output.out
    assert "The reference is" in output.out
    assert figure.exists()
    assert json.loads(document.read_text(encoding="utf-8"))["duration"] == 2.0
    assert main(["tradeoff", "no-such-demo"]) == 2
    assert "no demo 'no-such-demo'" in capsys.readouterr().err


def test_rows_whose_error_exceeds_the_motion_are_lost():
    """Verlet at half of its limit is off by two radians after ten periods of a spring, where it is opposite."""
    spring = pc.SpringNetwork([[0.0, 0.0], [1.2, 0.0]], [[0, 1]], 100.0, rest_length=1.0, mass=1.0, fixed=[0])
    trade = pc.tradeoff(pc.Scene(spring), 6.283, integrators=["VelocityVerlet"], precisions=["f64"], seed=1)
    rows = {row.status for row in trade.rows}
    assert "lost" in rows
    assert "ok" in rows
    for row in trade.rows:
        assert (row.status == "lost") == (0.2 < row.error < np.inf)
    assert trade.best(error=0.1).status == "ok"
