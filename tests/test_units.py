"""Scenes in units of their own: the same bits, defaults that are the same quantities, and no word of the SI."""

from __future__ import annotations

import copy
import math
import pickle
import re
import sys
import warnings
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from contracts.scenes import SCENES
from physcore.film import DARK
from physcore.film.film_renderer import FilmRenderer
from physcore.film.labels import drawing
from physcore.simulation.serial import unpack_scene
from physcore.simulation.sources import sources
from physcore.studies.audit import audit
from physcore.studies.forecast import forecast
from physcore.units import constants
from physcore.units.symbols import DERIVED, SYMBOLS
from physcore.units.systems import Default

OWN = pc.units.system(length=(2.0, "ell"), time=(0.5, "tau"), mass=(4.0, "mu"), charge=(0.25, "q"))
"""Units by powers of two, so that all conversions are exact, and the arithmetic of two scenes has the same bits."""
ASTRONOMICAL = pc.units.system(length=pc.units.AU, time=pc.units.day, mass=pc.units.solar_mass)
BARE = pc.units.dimensionless

WALL_TIME = re.compile(r"about \d+ (?:s|minutes|hours|days)\b|in [\d.e-]+ s[,;]|1 s = |[\d.]+ per second")
"""Times of the machine and of the film, which are in seconds."""
SI_WORDS = re.compile(
    r"(?:(?<=[\d)\]…])|(?<=inf)) ?/?\b(?:m|s|kg|C|K|J|N|W|Pa|Hz|V|T)(?:[·/²³]\S*)?(?=$|[\s,;:.)])"
    r"|\[(?:m|s|1/s|kg|C|K|J|N|W|Pa|Hz|V|T|kg·\S*|m/\S*|m[²³])\]|\b(?:seconds?|meters?|joules?)\b"
)
"""Units of the SI in a text."""


def left(text: str) -> list[str]:
    """The words of the SI in a text."""
    return [found[0] for found in SI_WORDS.finditer(WALL_TIME.sub("", text))]


def in_units(scene: pc.Scene, units: pc.units.UnitSystem) -> pc.Scene:
    """A scene of the same numbers in other units."""
    return unpack_scene({**scene.packed(), "units": asdict(units)})


def test_words_of_the_si_are_found():
    text = "dt = 0.5 s, (0, 1) m, energy [J], 3/s, at 2 m/s: 7 kg·m/s. 1e-3 N/m; inf s"
    assert len(left(text)) == 8
    assert not left("dt 0.5 d, 3 balls, 2 sunny days, 5 more s, about 3 s, frames [a], 2 N₂")


@pytest.mark.parametrize("name", [name for name, case in SCENES.items() if not case.numerics or case.adaptive])
def test_units_change_no_bit_and_all_words(name):
    case = SCENES[name]
    plain = case.scene()
    try:
        packed = plain.packed()
    except pc.FileError:
        pytest.skip("a function cannot be copied into another scene")
    scenes = [unpack_scene(packed), *(in_units(plain, units) for units in (OWN, BARE))]
    runs = [case.simulation(scene) for scene in scenes]
    for run in runs:
        case.advance(run, 2)
        text = "\n".join(map(str, [run.plan, run.energy(), *run.budgets().values(), pc.diagnose(run)]))
        html = run.plan._repr_html_() + run.energy()._repr_html_()
        if run.scene.units.is_si:
            assert left(text)
        else:
            assert not left(text)
            assert not left(re.sub(r"<[^>]*>", " ", html))
    assert len({run.state_hash() for run in runs}) == 1


def dust(charge: Any = 0.0, **options: Any) -> list[pc.Particles]:
    """Three particles."""
    places, speeds = np.array([[0.0, 0.0], [1.0, 0.25], [-0.5, 1.5]]), np.array([[0.5, 0.0], [0.0, 0.25], [0.0, 0.0]])
    return [pc.Particles(places, speeds, mass=[1.0, 2.0, 0.5], charge=charge, **options)]


def trajectory(bodies: list[pc.Particles], force: pc.Force, units: pc.units.UnitSystem | None, dt: float) -> np.ndarray:
    """The positions after some steps."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", pc.SceneWarning)
        run = pc.Simulation(pc.Scene(*bodies, force, units=units), "VelocityVerlet", dt=dt)
    run.step(50)
    return run.positions


FORCES = {
    "constant": (pc.Gravitation, 1e7),
    "k": (pc.Coulomb, 1.0),
    "g": (pc.Gravity, 1.0),
}
"""Forces with defaults, and a mass [kg] at which 50 steps of 1/64 s move particles by parts of a meter."""


@pytest.mark.parametrize(("kind", "scale"), FORCES.values(), ids=FORCES)
def test_defaults_of_forces_are_the_same_quantities_in_all_units(kind, scale):
    # All conversions are powers of two, so that each operation gives the same digits in both scenes.
    places = np.array([[0.0, 0.0], [1.0, 0.25], [-0.5, 1.5]])
    speeds = np.array([[0.5, 0.0], [0.0, 0.25], [0.0, 0.0]])
    mass, charge = scale * np.array([1.0, 2.0, 0.5]), 1e-5 * np.array([0.25, -0.5, 1.0])
    si = pc.Particles(places, speeds, mass=mass, charge=charge)
    own = pc.Particles(places / 2.0, speeds * (0.5 / 2.0), mass=mass / 4.0, charge=charge / 0.25)
    expected = trajectory([si], kind(), None, 1.0 / 64.0)
    moved = trajectory([own], kind(), OWN, 1.0 / 32.0)
    assert np.abs(expected - places - speeds * 50.0 / 64.0).max() > 1e-4
    assert np.array_equal(2.0 * moved, expected)


def test_the_default_air_of_wind_is_the_same_in_all_units():
    def flag(unit: float, mass: float) -> pc.SpringNetwork:
        # A stiffness [kg/s²] of 60 in the SI.
        stiffness = 60.0 if unit == 1.0 else 60.0 / 4.0 * 0.25
        return pc.cloth((5, 4), 0.125 / unit, stiffness, mass=mass, axes=((1, 0, 0), (0, 0, 1)), pinned="left")

    def end(body: pc.SpringNetwork, speed: float, units: pc.units.UnitSystem | None, dt: float) -> np.ndarray:
        run = pc.Simulation(pc.Scene(body, pc.Wind((speed, speed, 0.0)), units=units), "VelocityVerlet", dt=dt)
        run.step(50)
        return run.positions

    expected = end(flag(1.0, 0.0625), 4.0, None, 1.0 / 256.0)
    moved = end(flag(2.0, 0.0625 / 4.0), 4.0 * 0.5 / 2.0, OWN, 1.0 / 128.0)
    assert np.abs(expected[:, 1]).max() > 1e-3
    assert np.array_equal(2.0 * moved, expected)


def test_no_default_with_a_dimension_is_forgotten():
    # The docstrings state the unit of each argument; a default that is neither 0 nor 1 has to be converted.
    kinds = [each for each in vars(pc).values() if isinstance(each, type) and issubclass(each, (pc.Force, pc.Boundary))]
    checked = 0
    for kind in kinds:
        for name, entry in kind.__dataclass_fields__.items():
            stated = re.search(rf"^\s*{name}: .*?(?=^\s*\w+: |\Z)", kind.__doc__ or "", re.M | re.S)
            if stated and re.search(r"\[[^\]1]", stated[0]) and isinstance(entry.default, float):
                assert isinstance(entry.default, Default) or entry.default in (0.0, 1.0), (kind, name)
                checked += 1
    assert checked > 10


def test_a_year_of_a_planet_takes_a_year():
    # A mass of 1 M☉ at 1 AU: by Kepler's law 2π√(AU³/GM☉), 365.2569 d. The circular speed is that in AU/d.
    period = 2.0 * math.pi * math.sqrt(pc.units.AU**3 / 1.3271244e20) / pc.units.day
    assert abs(period - 365.25) < 0.01
    speed = 2.0 * math.pi / period
    sun, earth = pc.Particles([[0.0, 0.0]], fixed=True), pc.Particles([[1.0, 0.0]], [[0.0, speed]], mass=1e-12)
    run = pc.simulate(pc.Scene(sun, earth, pc.Gravitation(), units=ASTRONOMICAL), duration=365.25, fps=4.0 / 365.25)
    x, y = run[earth].positions[-1, 0]
    # The default resolves an orbit to 1 % after ten turns, 1e-3 of an orbit's radius after one: 1e-3 in the angle.
    assert abs(math.hypot(x, y) - 1.0) < 1e-3
    assert abs(math.atan2(y, x) + 2.0 * math.pi * (1.0 - 365.25 / period)) < 1e-3
    assert abs(run.times[-1] - 365.25) < 1e-9


def test_constants_are_in_units_of_the_system():
    assert ASTRONOMICAL.AU == 1.0
    assert ASTRONOMICAL.year == 365.25
    assert ASTRONOMICAL.solar_mass == 1.0
    # The Gaussian constant squared, G in AU³/(M☉·d²), whose value of the IAU of 1976 is 0.01720209895² (to 1e-8).
    assert abs(ASTRONOMICAL.gravitational_constant / 0.01720209895**2 - 1.0) < 1e-7
    # c = 173.1446 AU/d.
    assert abs(ASTRONOMICAL.speed_of_light - 173.1446) < 1e-4
    atomic = pc.units.system(length="nm", time="ps", mass="u", charge="e")
    # Coulomb's constant of GROMACS' units, kJ·mol⁻¹·nm·e⁻² = u·nm³/(ps²·e²): 138.935458.
    assert abs(atomic.coulomb_constant - 138.935458) < 1e-5
    assert pc.units.SI.gravitational_constant == pc.units.gravitational_constant
    assert {name for name, value in vars(constants).items() if isinstance(value, float)} == set(constants.UNITS)
    assert set(constants.UNITS) <= set(dir(pc.units)) & set(dir(ASTRONOMICAL))
    with pytest.raises(AttributeError, match="did you mean 'solar_mass'"):
        ASTRONOMICAL.solar_mas  # noqa: B018


@pytest.mark.parametrize("system", [BARE, pc.units.system(length=(1e-300, "tiny"))], ids=["dimensionless", "tiny"])
def test_constants_without_a_value_are_no_attributes(system):
    # G = 6.7e-11 m³/(kg·s²) is beyond 1e308 with a meter of 1e300.
    with pytest.raises(AttributeError, match=r"no value in a dimensionless system|beyond the range of numbers"):
        system.gravitational_constant  # noqa: B018
    present = {name for name in constants.UNITS if hasattr(system, name)}
    assert present == set(dir(system)) & set(constants.UNITS)
    assert ("year" in present) == (system != BARE)


@given(
    st.sampled_from(sorted({*constants.UNITS.values(), *DERIVED, "kg/m³", "N/m", "m/s²", "kg·m²/s"})),
    st.floats(1e-6, 1e6),
    *[st.floats(1e-6, 1e6)] * 4,
)
def test_conversions_are_those_of_the_dimension(unit, value, length, time, mass, charge):
    system = pc.units.system(length=(length, "ell"), time=(time, "tau"), mass=(mass, "mu"), charge=(charge, "q"))
    powers = {"m": length, "s": time, "kg": mass, "C": charge}
    symbols = {"ell": "m", "tau": "s", "mu": "kg", "q": "C"}
    # The symbol of the system is read back by another way: each symbol by the number behind it.
    above, _, below = system.symbol(unit).partition("/")
    expected = value
    for part, sign in ((above, -1), (below, 1)):
        for symbol, power in re.findall(r"(ell|tau|mu|q)([²³⁴]?)", part):
            expected *= powers[symbols[symbol]] ** (sign * ("²³⁴".index(power) + 2 if power else 1))
    # At most ten factors, each rounded once in both.
    assert math.isclose(system.convert(value, unit), expected, rel_tol=20 * 2.0**-52)


@pytest.mark.parametrize(
    ("value", "unit"), [(1.0, "ft"), (1.0, "km/s"), (1.0, "m/s**2"), (math.nan, "m"), ("1", "m"), (1.0, 3), (1.0, None)]
)
def test_what_cannot_be_converted_is_refused(value, unit):
    with pytest.raises(pc.SceneError, match=r"convert\.(value|unit): must be"):
        OWN.convert(value, unit)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"length": 3.0}, r"length: must be a unit of length"),
        ({"length": "Au"}, "did you mean 'AU'"),
        ({"time": pc.units.AU}, "time: must be a unit of time"),
        ({"length": (-1.0, "x")}, "finite value above 0"),
        ({"length": (math.nan, "x")}, "finite value above 0"),
        ({"length": (2.0, "")}, "must have a symbol"),
        ({"length": (2.0, "a b")}, "must have a symbol"),
        ({"length": (2.0, "m²")}, "must have a symbol"),
        ({"length": (2.0, "m")}, "'m' is the symbol"),
        ({"length": (2.0, "s")}, "'s' is the symbol"),
        ({"mass": (2.0, "N")}, "unit of the SI"),
        ({"length": (2.0, "K")}, "unit of the SI"),
        ({"mass": (2.0, "mol")}, "unit of the SI"),
        ({"mass": "earth"}, "did you mean 'earth_mass'"),
        ({"length": pc.units.day}, "86400.0 is a time$"),
        ({"mass": "year"}, "'year' is a time$"),
        ({"time": "km"}, "'km' is a length$"),
        ({"length": pc.units.speed_of_light}, "299792458.0 is in m/s$"),
        ({"charge": "electron_volt"}, "'electron_volt' is in J$"),
        ({"length": np.ones(2)}, r"got array\(\[1., 1.\]\)$"),
        ({"length": (2.0, "x"), "time": (3.0, "x")}, "different symbols"),
        ({"charge": pc.units.electron_charge}, "charge: must be a unit of charge"),
        ({"mass": None}, "mass: must be a unit of mass"),
    ],
)
def test_what_is_no_unit_is_refused(options, message):
    with pytest.raises(pc.SceneError, match=message):
        pc.units.system(**options)


def test_systems_of_units_are_values():
    again = pc.units.system(length="AU", time="day", mass=(pc.units.solar_mass, "M☉"))
    assert again == ASTRONOMICAL
    assert hash(again) == hash(ASTRONOMICAL)
    assert pickle.loads(pickle.dumps(again)) == again == copy.deepcopy(again)
    assert pc.units.system() == pc.units.SI
    assert eval(repr(OWN), {"units": pc.units}) == OWN
    with pytest.raises(AttributeError):
        again.length = again.time  # type: ignore[misc]
    with pytest.raises(TypeError, match="did you mean 'length'"):
        pc.units.system(lenght=1.0)  # type: ignore[call-arg]
    with pytest.raises(pc.SceneError, match="units: must be a system of units"):
        pc.Scene(pc.Particles([[0.0, 0.0]]), units="AU")  # type: ignore[arg-type]
    assert all(symbol in symbols for symbols in SYMBOLS.values() for symbol in symbols)


@pytest.mark.parametrize("force", [pc.Gravity(), pc.Gravitation(), pc.Coulomb()], ids=lambda each: type(each).__name__)
def test_a_default_with_a_dimension_is_refused_without_units(force):
    with pytest.raises(pc.SceneError, match=r"forces\[0\]\.(constant|acceleration): must be given.*the default is"):
        pc.Scene(pc.Particles([[0.0, 0.0]], charge=1.0), force, units=BARE)


def test_the_defaults_of_a_fluid_are_refused_with_their_values():
    water = pc.Fluid.block((0.0, 0.0), (4.0, 4.0), 0.5, name="water")
    # 1000 kg/m³ are 1000 · 2³/4 mu/ell³.
    with pytest.raises(pc.SceneError, match=r"bodies\['water'\].density: .*density=2000 mu/ell³"):
        pc.Scene(water, units=OWN)
    pc.Scene(pc.Fluid.block((0.0, 0.0), (4.0, 4.0), 0.5, density=2000.0, viscosity=0.001), units=OWN)


def test_a_value_that_is_given_is_not_converted():
    given = pc.Scene(pc.Particles([[0.0, 0.0]]), pc.Gravitation(pc.units.gravitational_constant), units=OWN)
    assert given.forces[0].constant == pc.units.gravitational_constant  # type: ignore[attr-defined]


def test_files_keep_units(tmp_path: Path):
    scene = pc.Scene(*dust(1e-6), pc.Gravitation(), pc.Coulomb(), units=OWN)
    pc.Simulation(scene).save(tmp_path / "simulation.npz")
    recording = pc.simulate(scene, 0.1, events=[pc.Event.crossing(0, "x", 0.01)])
    recording.save(tmp_path / "recording.npz")
    loaded, read = pc.load(tmp_path / "simulation.npz"), pc.load(tmp_path / "recording.npz")
    assert isinstance(read, pc.Recording)
    assert loaded.scene.units == read.scene.units == OWN
    assert loaded.scene.forces[0].constant == scene.forces[0].constant  # type: ignore[attr-defined]  # converted once
    assert str(read.energy) == str(recording.energy)
    assert str(read.plan) == str(recording.plan)
    assert len(read.events[0]) == 1
    assert str(read.events) == str(recording.events) != "no events"
    assert str(read.events[0]) == str(recording.events[0])
    assert read.events[0].units == read.events[0][0].units == pickle.loads(pickle.dumps(read)).events[0].units == OWN
    assert read.scene.hash() == scene.hash() == pickle.loads(pickle.dumps(scene)).hash()
    pc.film(recording, tmp_path / "film.png", size=(160, 120))
    assert pc.provenance(tmp_path / "film.png")[0]["units"] == asdict(OWN)


def test_scenes_in_the_si_have_no_entry_of_units():
    # So that files of earlier versions and hashes of scenes stay as they are.
    assert "units" not in pc.Scene(*dust(), pc.Gravitation()).packed()
    plain, named = (pc.Scene(*dust(), pc.Gravitation(1.0), units=units) for units in (None, pc.units.SI))
    assert plain.hash() == named.hash() != pc.Scene(*dust(), pc.Gravitation(1.0), units=OWN).hash()


@pytest.mark.parametrize(
    "damage",
    [
        {"length": {"symbol": "ell", "value": -1.0}},
        {"length": {"symbol": "m", "value": 7.0}},
        {"length": {"symbol": 3, "value": 7.0}},
        {"length": {"symbol": "", "value": None}},
        {"length": None},
    ],
)
def test_forged_units_are_refused(damage):
    tree = pc.Scene(*dust(), units=OWN).packed()
    with pytest.raises(pc.FileError, match="units"):
        unpack_scene({**tree, "units": {**tree["units"], **damage}})


def written(recording: Any, monkeypatch: pytest.MonkeyPatch, **options: Any) -> str:
    """All texts of a film."""
    texts: list[str] = []

    def spied(function: Any, place: int) -> Any:
        """A function that notes one of its arguments."""

        def call(*arguments: Any, **options: Any) -> Any:
            texts.append(arguments[place])
            return function(*arguments, **options)

        return call

    for module in [each for name, each in sys.modules.items() if name.startswith("physcore.film")]:
        if getattr(module, "write", None) is drawing.write:
            monkeypatch.setattr(module, "write", spied(drawing.write, 1))
        if hasattr(module, "text_width"):  # of diagrams and curves, which place each word by it
            monkeypatch.setattr(module, "text_width", spied(module.text_width, 0))
    found = sources(recording, None, None, {})
    style = options.pop("style", None)
    with FilmRenderer(found, (640, 480), style, None, DARK, None, False, **options) as renderer:
        for _ in renderer.frames():
            pass
    return "\n".join(texts)


def scenes(units: pc.units.UnitSystem | None) -> dict[str, tuple[pc.Scene, Any]]:
    """Scenes with color bars of all quantities, and a style for each."""
    water = pc.Fluid.block((0.0, 0.0), (0.4, 0.4), 0.1, density=1000.0, viscosity=1e-3)
    rods = pc.SpringNetwork([[0, 0], [1, 0], [2, 0]], [[0, 1], [1, 2]], math.inf, fixed=[0])
    grid, line = pc.Grid((12, 12), spacing=0.1), pc.Grid((24,), spacing=0.1)
    pull = pc.Gravity((0.0, -9.81))
    items: dict[str, tuple[list[Any], Any]] = {
        "points": ([*dust(1.0), pull, pc.Drag(0.1), pc.Coulomb(1.0)], pc.styles.Points("speed")),
        "energies": ([*dust(1.0), pull, pc.Coulomb(1.0)], pc.styles.Points("energy")),
        "arrows": ([*dust(), pull, pc.Drag(0.1)], [pc.styles.Points("body"), pc.styles.Arrows("acceleration")]),
        "water": ([water, pull, pc.Box((0.0, 0.0), (1.0, 1.0))], pc.styles.Fluid("pressure")),
        "rods": ([rods, pull], None),
        "wave": ([pc.Wave(grid, speed=1.0, displacement=lambda x, y: np.exp(-50 * (x - 0.6) ** 2))], None),
        "string": ([pc.Wave(line, speed=1.0, displacement=lambda x: np.exp(-5 * (x - 1.2) ** 2))], None),
        "packet": ([pc.Schrodinger(line, pc.wave_packet(line, 1.2, 2.0, 0.3))], None),
    }
    return {name: (pc.Scene(*parts, units=units), style) for name, (parts, style) in items.items()}


@pytest.mark.parametrize("name", scenes(None))
def test_films_and_reports_have_no_word_of_the_si(name, monkeypatch):
    texts = []
    for units in (None, OWN, BARE):
        scene, style = scenes(units)[name]
        fields = ("positions", "velocities", "pressures") if scene.fluids else None
        recording = pc.simulate(scene, 0.1, fps=10, channels=fields)
        inset: Any = {"inset": "energy"} if scene.bodies else {}
        options = {"labels": ("time", "dt", "energy"), "scale_bar": True, "rate": 25.0, "style": style, **inset}
        words = [written(recording, monkeypatch, **options), repr(recording), audit(recording), str(recording.plan)]
        words += [str(recording.energy), recording.energy._repr_html_(), str(recording.budgets)]
        words += [str(pc.diagnose(recording)), (recording._repr_html_() or "") if name == "points" else ""]
        texts.append("\n".join(re.sub(r"<[^>]*>", " ", text) for text in words))
    plain, own, bare = texts
    assert len(left(plain)) > 8
    assert not left(own)
    assert not left(bare)
    assert "ell" in own


def messages(units: pc.units.UnitSystem | None) -> list[str]:
    """Warnings and errors of a scene."""
    found: list[str] = []

    def note(call: Any) -> None:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                call()
            except pc.PhyscoreError as error:
                found.append(f"{error} {getattr(error, 'hint', '')} {getattr(error, 'cause', '')}")
        found.extend(str(each.message) for each in caught)

    net = pc.SpringNetwork([[0, 0], [1.5, 0]], [[0, 1]], 100.0, rest_length=1.0)
    swing, free = pc.Scene(net, units=units), pc.Scene(*dust(), units=units)
    repelled = pc.Scene(*dust(), pc.CentralForce((0.0, 0.0), -1.0, exponent=1), units=units)
    note(lambda: pc.simulate(swing, 100.0, dt=1.0))
    note(lambda: next(pc.Simulation(swing).frames(1e8, 1e-8)))  # warns of many steps, before it takes any
    note(lambda: pc.simulate(swing, 1e30, fps=1e10))
    note(lambda: pc.Simulation(swing, dt=1e-9).run(1e10))
    note(lambda: pc.Scene(pc.Fluid([[0, 0]], 1.0, 1.0, 1.0), pc.Fluid([[0.1, 0]], 1.0, 1.0, 1.0), units=units))
    note(lambda: pc.simulate(pc.Scene(*dust(radius=5.0), pc.Box((0, 0), (1, 1)), units=units), 1.0))
    note(lambda: pc.simulate(pc.Scene(pc.Particles([[0, 0], [0, 0]]), pc.Gravitation(1.0), units=units), 1.0))
    note(
        lambda: pc.film(
            pc.simulate(free, 0.1), "film.gif", camera=lambda time: None if time else pc.Window((0, 0), (1, 1))
        )
    )
    note(lambda: pc.simulate(pc.Scene(*dust(), pc.Gravity(lambda t: (math.nan if t else 0, 0)), units=units), 1.0))
    note(lambda: pc.simulate(swing, 0.1, accuracy=1e-18))
    note(lambda: pc.simulate(free, 0.1, events=[pc.Event(lambda state: math.nan if state.time > 0.05 else 1.0)]))
    note(lambda: list(pc.Simulation(free).frames(0.1, events=[pc.Event(lambda state: [[1.0]])])))
    note(lambda: pc.lyapunov(repelled, 60.0, interval=20.0))
    return found


def test_messages_have_no_word_of_the_si():
    plain, own, bare = map(messages, (None, OWN, BARE))
    assert len(plain) == len(own) == len(bare) >= 10
    assert sum(bool(left(each)) for each in plain) >= 8
    assert not left("\n".join(own + bare))


def findings(units: pc.units.UnitSystem | None) -> dict[str, str]:
    """A diagnosis of each symptom whose figures have a unit, and notes of plans."""
    swing = pc.Scene(pc.SpringNetwork([[0, 0], [1.5, 0]], [[0, 1]], 100.0, rest_length=1.0), units=units)
    loose = pc.Fluid(pc.block((0.0, 0.0), (1.0, 1.0), 0.1), 0.05, 1000.0, 1e-3, velocities=(1.0, 0.0))
    pressed = pc.Particles([[0.0, 0.0], [0.25, 0.0]], [[1.0, 0.0], [0.0, 0.0]], radius=0.1)
    ball, grid = pc.Particles([[0.0, 5.0]], radius=0.1), pc.Grid((64,), spacing=0.1)
    rough = pc.Wave(grid, speed=1.0, displacement=np.random.default_rng(1).normal(size=64))
    front = pc.ReactionDiffusion(grid, pc.Reaction(("n",), lambda n: (900.0 * n * (1.0 - n),)), {"n": 1.0}, {"n": 0.5})
    kicks = np.random.default_rng(1).normal(size=(36, 2))
    net = pc.cloth((6, 6), 0.05, 200.0, mass=0.004, velocities=kicks, pinned="top")
    film = pc.Fluid.block((0.0, 0.0), (1.0, 0.2), 0.1, density=1000.0, viscosity=1e-3)
    pull, ring = pc.Gravity(lambda time: (0.0, -1.0)), pc.CentralForce((0.0, 0.0), 1.0, exponent=1)
    shake = pc.Gravity(lambda time: (0.0, math.sin(300.0 * time)))
    passing = pc.Event.crossing(0, "x", 0.26)
    pair = pc.Particles([[-0.5, 0.0], [0.5, 0.0]], [[0.0, -0.5], [0.0, 0.5]])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        broken = pc.simulate(swing, 10.0, dt=0.139)
        shaken = pc.simulate(pc.Scene(net, units=units), 1.0)
        found = {
            "unstable": pc.diagnose(pc.Simulation(swing, dt=1.0)),
            "drift": pc.diagnose(broken),
            "slow": pc.diagnose(pc.Simulation(swing, dt=1e-7), 1.1),
            "scatters": pc.diagnose(pc.Simulation(pc.Scene(loose, units=units))),
            "penetrates": pc.diagnose(pc.simulate(pc.Scene(pressed, pc.SoftSpheres(1.0), units=units), 0.2)),
            "coarse": pc.diagnose(pc.Simulation(pc.Scene(rough, units=units))),
            "jitters": pc.diagnose(shaken),
            "front": pc.Simulation(pc.Scene(front, units=units)).plan,
            "untouched": pc.simulate(pc.Scene(ball, pc.Floor(), units=units), 0.1).plan,
            "adaptive": pc.Simulation(swing, "DormandPrince5", dt=pc.AdaptiveStep(tolerance=1e-6)).plan,
            "forecast": forecast(pc.Simulation(swing), 1.0),
            "limit": pc.stability_limit(swing, "PEFRL", measured=True),
            "events": (watched := pc.simulate(pc.Scene(*dust(), units=units), 1.0, events=[passing])).events,
            "occurrences": watched.events[0],
            "exponents": pc.lyapunov(pc.Scene(*dust(), ring, units=units), 1.0, interval=0.1),
            "thin": pc.Simulation(pc.Scene(film, pc.Gravity((0.0, -1.0)), pc.Floor(), units=units)).plan,
            "functions of time": pc.Simulation(pc.Scene(*dust(), pull, units=units), dt=0.01).plan,
            "alternation": pc.Simulation(pc.Scene(*dust(), shake, units=units), dt=0.01).plan,
            "encounter": pc.Simulation(pc.Scene(pair, pc.Gravitation(1.0), units=units)).plan,
        }
    return {name: str(each) for name, each in found.items()}


def test_findings_have_no_word_of_the_si():
    plain, own, bare = map(findings, (None, OWN, BARE))
    assert [name for name, text in plain.items() if not left(text)] == []
    assert {name: left(text) for name, text in (*own.items(), *bare.items()) if left(text)} == {}


METHODS = ["VelocityVerlet", "RungeKutta4"]


def test_tradeoffs_have_no_word_of_the_si(tmp_path: Path):
    trade = pc.tradeoff(
        pc.Scene(*dust(), pc.Gravitation(1.0, softening=0.1), units=OWN), 0.5, integrators=METHODS, budget=0.1
    )
    text = "\n".join([str(trade), trade.explain(), re.sub(r"<[^>]*>", " ", trade._repr_html_())])
    assert not left(text.replace("seconds", ""))
    assert "dt [tau]" in text
    assert "error [ell]" in text
    assert trade.plot(tmp_path / "trade.png").get_ylabel().endswith("[ell]")
    limit = str(pc.stability_limit(in_units(SCENES["network 3D"].scene(), OWN), "PEFRL", measured=True))
    assert "tau" in limit
    assert not left(limit)


def test_plots_have_the_units_of_the_scene():
    pytest.importorskip("matplotlib")
    recording = pc.simulate(pc.Scene(*dust(), pc.Gravity((0.0, -1.0)), units=OWN), 0.2)
    labels = {name: recording.plot(name).get_ylabel() for name in ("energy", "momentum", "positions")}
    assert labels == {
        "energy": "energy [mu·ell²/tau²]",
        "momentum": "momentum [mu·ell/tau]",
        "positions": "positions [ell]",
    }
    assert recording[0].plot("velocities").get_ylabel() == "velocities [ell/tau]"
    bare = pc.simulate(pc.Scene(*dust(), pc.Gravity((0.0, -1.0)), units=BARE), 0.2).plot("energy")
    assert (bare.get_xlabel(), bare.get_ylabel()) == ("time", "energy")


def test_exports_have_the_units_of_the_scene(tmp_path: Path):
    recording = pc.simulate(pc.Scene(*dust(), units=OWN), 0.1, fps=20)
    for suffix in ("xyz", "pvd"):
        pc.export(recording, tmp_path / f"own.{suffix}")
        assert "length=ell time=tau mass=mu charge=q" in (tmp_path / f"own.{suffix}").read_text()
    h5py = pytest.importorskip("h5py")
    pc.export(recording, tmp_path / "own.h5md")
    with h5py.File(tmp_path / "own.h5md") as file:
        units = dict(file["parameters/units"].attrs)
    assert units["velocity"] == "ell tau-1"
    assert units["energy"] == "mu ell2 tau-2"
    pc.export(pc.simulate(pc.Scene(*dust(), units=BARE), 0.1, fps=20), tmp_path / "bare.h5md")
    with h5py.File(tmp_path / "bare.h5md") as file:
        assert not dict(file["parameters/units"].attrs)


def test_panels_have_the_same_units(tmp_path: Path):
    recordings = [pc.simulate(pc.Scene(*dust(), units=units), 0.1) for units in (None, OWN)]
    with pytest.raises(pc.SceneError, match="panels must have the same units"):
        pc.film(recordings, tmp_path / "film.png")


def test_the_script_of_the_documentation_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any):
    document = (Path(__file__).parents[1] / "docs" / "units.md").read_text("utf-8")
    script = document.split("```python\n")[1].split("```")[0]
    monkeypatch.chdir(tmp_path)
    exec(script, {})
    assert "M☉·AU²/d²" in capsys.readouterr().out
    assert (tmp_path / "year.gif").stat().st_size > 1000


def test_rewording_twice_changes_nothing_more():
    text = "dt = 0.5 s is 3 m/s at (0, 1) m with 2 J [m/s], 4 kg·m/s, NaN s and 3/s."
    once = ASTRONOMICAL.reworded(text)
    assert once == "dt = 0.5 d is 3 AU/d at (0, 1) AU with 2 M☉·AU²/d² [AU/d], 4 M☉·AU/d, NaN d and 3/d."
    assert ASTRONOMICAL.reworded(once) == once
    assert BARE.reworded(text) == "dt = 0.5 is 3 at (0, 1) with 2, 4, NaN and 3."
    assert pc.units.SI.reworded(text) is text


@given(st.text(), st.sampled_from(["rope of 3 m long", "it's 3 m, or 2 s", '"3 m" and it\'s 4 m, too']))
def test_rewording_keeps_names(text, known):
    for name in (text, known):
        found = ASTRONOMICAL.reworded(f"particles' gap of 3 m: bodies[{name!r}] and (1 of {name!r}) at 2 m/s")
        assert found == f"particles' gap of 3 AU: bodies[{name!r}] and (1 of {name!r}) at 2 AU/d"


def test_rewording_keeps_the_errors_of_functions():
    def failing(time: float) -> tuple[float, float]:
        if time > 0.0:
            raise ValueError("lost below 5 m\nafter 3 s")
        return 0.0, 0.0

    body = pc.Particles([[0.0, 0.0]])
    with pytest.raises(pc.SceneError, match=r"raised ValueError: lost below 5 m\nafter 3 s$"):
        pc.simulate(pc.Scene(body, pc.Gravity(failing), units=ASTRONOMICAL), 1.0)
    event = pc.Event(lambda state: failing(state.time)[0])
    with pytest.raises(pc.SceneError, match=r"raised ValueError: lost below 5 m\nafter 3 s$"):
        pc.simulate(pc.Scene(body, units=ASTRONOMICAL), 1.0, events=[event])


def test_a_diverged_run_names_bodies_as_they_are():
    net = pc.SpringNetwork([[0, 0], [1.5, 0]], [[0, 1]], 100.0, rest_length=1.0, name="rope of 3 m, or 4 s")
    with (
        pytest.warns(pc.StabilityWarning),
        pytest.raises(pc.SimulationDiverged, match=r"\(1 of 'rope of 3 m, or 4 s'\).* dt = \S+ d would hold"),
    ):
        pc.simulate(pc.Scene(net, units=ASTRONOMICAL), 100.0, dt=1.0)


def test_the_documentation_lists_all_symbols():
    document = (Path(__file__).parents[1] / "docs" / "units.md").read_text("utf-8")
    listed = re.search(r"^- Symbols are (.*?)^- ", document, re.M | re.S)
    assert listed
    for symbols, kind in re.findall(r"`([^`()]+)` of (\w+)", listed[1]):
        assert set(symbols.split()) == set(SYMBOLS[kind])
    assert len(re.findall(r"` of ", listed[1])) == len(SYMBOLS)
