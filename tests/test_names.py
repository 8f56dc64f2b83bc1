"""Names: of bodies where a force or a style acts, of integrators, of what is misspelt, and what is at the top level."""

from __future__ import annotations

import importlib
import inspect
from types import ModuleType

import numpy as np
import pytest

import physcore as pc
from physcore.entrance import entrance
from physcore.spelling import SYNONYMS

BALL = pc.Particles([[0.0, 1.0], [0.5, 1.0]], velocities=[[0.3, 0.0], [0.0, 0.1]], name="ball")
STONE = pc.Particles([[1.0, 2.0]], name="stone")
SHEET = {"shape": (4, 4), "spacing": 0.1, "stiffness": 10.0, "bend_stiffness": 0.0, "mass": 0.01}
FLAT = pc.cloth(**SHEET, origin=(0.0, 0.0, 0.0), name="sheet")
OTHER = pc.cloth(**SHEET, origin=(0.0, 0.0, 1.0), name="other")


def bits(scene: pc.Scene, **numerics: object) -> str:
    simulation = pc.Simulation(scene, dt=1e-3, **numerics)
    simulation.step(20)
    return simulation.state_hash()


@pytest.mark.parametrize("dimension", [2, 3])
def test_gravity_is_down(dimension):
    body = pc.Particles(np.zeros((1, dimension)))
    down = (0.0,) * (dimension - 1) + (-9.81,)
    assert bits(pc.Scene(body, pc.Gravity())) == bits(pc.Scene(body, pc.Gravity(down)))
    simulation = pc.Simulation(pc.Scene(body, pc.Gravity()), dt=1e-3)
    np.testing.assert_array_equal(simulation.acceleration(np.ones((1, dimension))), [down])


@pytest.mark.parametrize(
    "item",
    [
        lambda one, other: pc.Gravity(on=one),
        lambda one, other: pc.Drag(0.5, on=[one]),
        lambda one, other: pc.Floor(0.9995, on=one),
        lambda one, other: pc.Gravitation(1.0, on=one, sources=[other]),
    ],
)
def test_a_name_stands_for_its_body(item):
    named, given = (pc.Scene(BALL, STONE, item(*keys)) for keys in [("ball", "stone"), (BALL, STONE)])
    assert bits(named) == bits(given)
    assert named.hash() == given.hash()
    (acting,) = (*named.forces, *named.boundaries)
    assert all(isinstance(body, pc.Body) for body in acting.bodies() or ())
    assert named.targets(item("ball", "stone")) == given.targets(item(BALL, STONE))


def test_surfaces_are_named_too():
    def scene(one, other):
        return pc.Scene(FLAT, OTHER, pc.Dihedral([one, other], 1e-4), pc.SelfContact(one, 0.01, on=other))

    assert bits(scene("sheet", "other")) == bits(scene(FLAT, OTHER))
    with pytest.raises(pc.SceneError, match=r"SelfContact.on: must be other bodies"):
        pc.SelfContact("sheet", 0.01, on="sheet")
    with pytest.raises(pc.SceneError, match=r"Dihedral.on: must be a SpringNetwork with faces, got Particles\('ball'"):
        pc.Scene(BALL, pc.Dihedral("ball", 1e-4))


def test_styles_are_for_names(tmp_path):
    recording = pc.simulate(pc.Scene(BALL, STONE), 0.05)
    options = {"size": (120, 90)}
    by_name = pc.styles.Points(size=9.0, on="ball")
    by_body = pc.styles.Points(size=9.0, on=BALL)
    pc.film(recording, tmp_path / "name.png", style=by_name, **options)
    pc.film(recording, tmp_path / "body.png", style=by_body, **options)
    assert (tmp_path / "name.png").read_bytes() == (tmp_path / "body.png").read_bytes()
    with pytest.raises(pc.SceneError, match=r"Points.on: nothing is called 'bal'.*did you mean 'ball'\?"):
        pc.film(recording, tmp_path / "no.png", style=pc.styles.Points(on="bal"))
    wave = pc.Wave(pc.Grid((8, 8), 0.1), 1.0, name="pond")
    film = pc.film(pc.Scene(wave), tmp_path / "pond.png", duration=0.1, style=pc.styles.Field(on="pond"), **options)
    assert film.path.exists()
    with pytest.raises(pc.SceneError, match=r"must be a system of the scene"):
        pc.film(recording, tmp_path / "no.png", style=pc.styles.Field(on="ball"))


@pytest.mark.parametrize("kind", [pc.RungeKutta4, pc.PEFRL, pc.SemiImplicitEuler])
def test_integrators_have_names(kind):
    scene = pc.Scene(BALL, pc.Gravity())
    assert bits(scene, integrator=kind.__name__) == bits(scene, integrator=kind())
    assert pc.Simulation(scene, integrator={"bodies": kind.__name__}).integrator == kind()
    assert pc.stability_limit(scene, kind.__name__) == pc.stability_limit(scene, kind())
    trade = pc.tradeoff(scene, 0.01, budget=1e-3, integrators=[kind.__name__], dts=[1e-3])
    assert {row.integrator for row in trade.rows} == {kind()}


@pytest.mark.parametrize("hold", [{"pinned": "left"}, {"fixed": "left"}, {"fixed": [0, 4, 8, 12]}])
def test_builders_hold_what_is_pinned_or_fixed(hold):
    for body in (pc.cloth(**SHEET, **hold), pc.soft_body((4, 4), 0.1, 1.0, **hold)):
        assert np.flatnonzero(body.fixed).tolist() == [0, 4, 8, 12]
    both = pc.rope(4, 1.0, 1.0, pinned="start", fixed=[-1])
    assert both.fixed.tolist() == [True, False, False, True]


def test_a_block_of_fluid_is_a_fluid_in_a_block():
    water = pc.Fluid.block((0.0, 0.0), (0.4, 0.2), 0.05, viscosity=0.1, name="water")
    same = pc.Fluid(pc.block((0.0, 0.0), (0.4, 0.2), 0.05), 0.05, viscosity=0.1, name="water")
    assert pc.Scene(water).hash() == pc.Scene(same).hash()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: pc.Scene(BALL, pc.Drag(1.0, on="bal")), r"forces\[0\].on: nothing is called 'bal'; .* 'ball'\?"),
        (lambda: pc.Scene(BALL).index("Ball"), r"did you mean 'ball'\?"),
        (lambda: pc.Simulation(pc.Scene(BALL), "VelocityVerlt"), r"did you mean 'VelocityVerlet'\?"),
        (lambda: pc.Simulation(pc.Scene(BALL), precision="F32"), r"did you mean 'f32'\?"),
        (lambda: pc.Simulation(pc.Scene(BALL), on_divergence="substeps"), r"did you mean 'substep'\?"),
        (lambda: pc.simulate(pc.Scene(BALL), 0.1, channels=("position",)), r"did you mean 'positions'\?"),
        (lambda: pc.cloth((3, 3), 0.1, 1.0, pinned="top corner"), r"did you mean 'top corners'\?"),
        (lambda: pc.tradeoff(pc.Scene(BALL), 0.1, integrators=["RungeKuta4"]), r"did you mean 'RungeKutta4'\?"),
        (lambda: pc.film(pc.Scene(BALL), "x.png", duration=0.1, quality="hihg"), r"did you mean 'high'\?"),
    ],
)
def test_what_is_nearly_a_word_is_suggested(call, message):
    with pytest.raises((pc.SceneError, KeyError), match=message):
        call()


def test_a_word_that_is_like_no_other_is_not():
    with pytest.raises(pc.SceneError) as caught:
        pc.Simulation(pc.Scene(BALL), precision="quick")
    assert "did you mean" not in str(caught.value)


def test_what_films_are_made_with_is_at_the_top_level():
    module = importlib.import_module("physcore.film")
    for name in ("DARK", "LIGHT", "Corotating", "Follow", "Keyframes", "Orbit", "Theme", "Window", "provenance"):
        assert getattr(pc, name) is getattr(module, name)
        assert name in dir(module)
    assert sorted(dir(pc)) == sorted([*pc.__all__, "__version__"])
    with pytest.raises(AttributeError, match=r"no attribute 'Windw'; did you mean 'Window'\?"):
        _ = pc.Windw


@pytest.mark.parametrize(
    ("call", "name", "meant"),
    [
        (pc.Particles, "velocity", "velocities"),
        (pc.cloth, "dampng", "damping"),
        (pc.Fluid, "viscosty", "viscosity"),
        (pc.simulate, "acuracy", "accuracy"),
        (pc.simulate, "integrater", "integrator"),
        (pc.film, "titel", "title"),
        (pc.film, "integrater", "integrator"),
        (pc.Drag, "quadratc", "quadratic"),
        (pc.AutoStep, "safty", "safety"),
        (pc.Orbit, "azimut", "azimuth"),
        (pc.Window, "lowr", "lower"),
        (pc.styles.Points, "colour", "color"),
    ],
)
def test_what_is_nearly_a_keyword_is_suggested(call, name, meant):
    given = {
        pc.Particles: ([[0.0, 0.0]],),
        pc.cloth: ((3, 3), 0.1, 1.0),
        pc.Fluid: ([[0.0, 0.0]], 0.1),
        pc.simulate: (pc.Scene(BALL), 0.1),
        pc.film: (pc.Scene(BALL), "never.png"),
        pc.Window: ((0.0, 0.0), (1.0, 1.0)),
    }.get(call, ())
    message = rf"^{call.__name__}\(\) got an unexpected keyword argument '{name}'; did you mean '{meant}'\?$"
    with pytest.raises(TypeError, match=message):
        call(*given, **{name: 1})


def test_a_type_error_of_another_function_stays_as_it_is():
    @entrance
    def outer(size, **others):
        raise TypeError("inner() got an unexpected keyword argument 'size'")

    with pytest.raises(TypeError, match=r"^inner\(\) got an unexpected keyword argument 'size'$"):
        outer(size=1)


def test_classes_keep_their_signatures():
    assert list(inspect.signature(pc.Particles).parameters)[:2] == ["positions", "velocities"]
    assert list(inspect.signature(pc.Orbit).parameters)[:1] == ["azimuth"]
    assert "style" in inspect.signature(pc.film).parameters


def test_messages_call_bodies_by_their_names():
    low = pc.Particles([[0.5, -1.0]], name="low")
    with pytest.raises(pc.SceneError, match=r"^bodies\['low'\].positions\[0\]: "):
        pc.Simulation(pc.Scene(BALL, low, pc.Floor()))
    with pytest.raises(pc.SceneError, match=r"^bodies\[0\].positions\[0\]: "):
        pc.Simulation(pc.Scene(pc.Particles([[0.5, -1.0]]), pc.Floor()))
    water, milk = (
        pc.Fluid.block((at, 0.0), (at + 1.0, 1.0), 0.1, name=name) for at, name in [(0, "water"), (0.5, "milk")]
    )
    with pytest.raises(pc.SceneError, match=r"particles of bodies\['water'\] and bodies\['milk'\]"):
        pc.Scene(water, milk)
    spring = pc.SpringNetwork([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 1e8, velocities=[[0, 0], [1, 0]], name="spring")
    with pytest.warns(pc.StabilityWarning), pytest.raises(pc.SimulationDiverged) as caught:
        pc.Simulation(pc.Scene(BALL, spring), dt=1.0).step(100)
    assert caught.value.particle in (2, 3)
    assert f"of particle {caught.value.particle} ({caught.value.particle - 2} of 'spring') has" in str(caught.value)
    assert caught.value.element == f"particle {caught.value.particle}"


@pytest.mark.parametrize(
    ("ask", "meant"),
    [
        (lambda: pc.simulate(pc.Scene(BALL), 0.1, integrator="RK4"), "RungeKutta4"),
        (lambda: pc.simulate(pc.Scene(BALL), 0.1, integrator="leapfrog"), "VelocityVerlet"),
        (lambda: pc.Spring, "SpringNetwork"),
        (lambda: pc.heat_equation, "ReactionDiffusion"),
    ],
)
def test_a_word_of_other_packages_is_understood(ask, meant):
    with pytest.raises((pc.SceneError, AttributeError), match=f"did you mean '{meant}'"):
        ask()


def test_synonyms_lead_to_names_and_hide_none():
    assert set(SYNONYMS) <= set(pc.__all__)
    words = [word for words in SYNONYMS.values() for word in words]
    assert len(words) == len(set(words))
    assert not {word.casefold() for word in words} & {name.casefold() for name in pc.__all__}


@pytest.mark.parametrize("module", [pc, pc.styles, pc.materials, pc.units], ids=lambda module: module.__name__)
def test_completion_shows_public_names_alone(module):
    assert len(dir(module)) > 5
    for name in dir(module):
        value = getattr(module, name)
        assert not name.startswith("_") or name == "__version__"
        assert not isinstance(value, ModuleType) or module is pc
        assert not isinstance(value, float) or module is pc.units
