"""How a scene is computed: the choices beside it, checked, and the rules for choosing the time step."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias, TypedDict

from physcore.checks import MOST, count, flag, is_word, number, shown, span, word
from physcore.errors import SceneError
from physcore.numerics.contacts import Contacts, ContactSolver, contact_solver
from physcore.numerics.defaults import default_integrator, is_magnetic, is_small
from physcore.numerics.fluids import FluidMethod, Fluids, fluid_methods
from physcore.numerics.integrators import (
    INTEGRATORS,
    INTEGRATORS_BY_NAME,
    RATTLE,
    Boris,
    GaussRadau15,
    Integrator,
    SemiImplicitEuler,
    VelocityVerlet,
    made,
)
from physcore.scene.contents import ItemKey
from physcore.scene.records import kind_of
from physcore.scene.scene import Scene
from physcore.spelling import KeywordError, did_you_mean

DivergenceRule = Literal["raise", "ignore", "substep"]
Precision = Literal["f32", "f64", "auto"]
PRECISIONS: tuple[Precision, ...] = ("f32", "f64", "auto")
DIVERGENCE_RULES: tuple[DivergenceRule, ...] = ("raise", "substep", "ignore")
LimitKind = Literal["stability", "accuracy", "none"]

MAX_ENERGY_GROWTH = {"raise": 1e6, "ignore": 1e6, "substep": 1.0}
"""How many times the largest energy so far the energy balance may rise, where nothing is said. A step that is to be
taken again in parts has to be noticed before it has spoilt the state."""

FRAMES_PER_SECOND = 30.0
"""The frame rate where none is asked for."""

MOST_THREADS = 1024
"""More than any machine has; a larger number is a mistake, and would take the system's threads."""

STEPS_PER_FREE_FRAME = 4
"""Steps per frame where nothing limits the time step."""


@dataclass(frozen=True)
class AutoStep:
    """Choose the time step from the limit of stability of the scene.

        recording = pc.simulate(scene, duration=0.5, dt=pc.AutoStep(safety=0.2))

    Args:
        safety: the largest fraction of the limit to use, above 0 and at most 1. At one half, Verlet runs the fastest
            oscillation 5 % too fast (arcsin(½)/½ = 1.047); the error of slower ones falls with their frequency squared.
            A fraction near 1 of the limit of springs as they stand would not hold when they turn: the step is never
            above the certified limit, which does.
        resolve: whether the fastest oscillation is resolved too: after ten periods an undamped one is off by at most
            half a percent of its amplitude. Verlet then takes 140 steps in a period. Methods of first order, implicit
            methods, and systems other than bodies keep to `safety` alone.

    Raises:
        SceneError: a value is out of range.
    """

    safety: float = 0.5
    resolve: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "safety", number(self.safety, "AutoStep.safety", above=0.0, most=1.0))
        object.__setattr__(self, "resolve", flag(self.resolve, "AutoStep.resolve"))


@dataclass(frozen=True)
class AdaptiveStep:
    """Let the time step follow the motion: small where it is fast, large where it is slow.

        comet = pc.Particles([[1.0, 0.0]], velocities=[[0.0, 0.3]])
        sun = pc.CentralForce((0.0, 0.0), strength=1.0, exponent=-2)
        recording = pc.simulate(pc.Scene(comet, sun), duration=5.0, dt=pc.AdaptiveStep())

    Without a tolerance, for conservative scenes and any integrator: each frame interval, or what `run` is given, is
    halved as often as need be, and a step is as long as `safety` times the scene's limit allows at its beginning *and*
    at its end; it is tried, and taken back where the end asks for less. Such a choice is the same backwards in time,
    but for rare steps, so that with a symplectic integrator the energy has no drift of one sign.

    With a tolerance, for scenes with friction or drag: the step follows the integrator's own estimate of its error,
    for which there are two: DormandPrince5(), and BogackiShampine3() for errors of a hundredth, or where stability
    limits the step. One whose error is larger than the tolerance is taken back. GaussRadau15() has a tolerance of its
    own.

    All particles share the step. Each step looks at the limits of all particles, on one thread, which for springs and
    pairs takes as long as about ten evaluations of their forces: there it pays where the step changes by more than
    that in a run. A step that diverges is halved up to ten times before that is an error.

    Args:
        safety: the largest fraction of the limit to use, above 0 and at most 1. The limit of a central force is a
            hundredth of a turn at the particle's present distance.
        tolerance: the largest error of one step [m]: of any particle's position, or of its velocity times the step.

    Sources: D. M. Hernandez, W. Dehnen, Mon. Not. R. Astron. Soc. 522, 4639 (2023); E. Hairer, S. P. Nørsett,
    G. Wanner, "Solving Ordinary Differential Equations I", § II.4; G. Söderlind, Numer. Algorithms 31, 281 (2002).

    Raises:
        SceneError: `safety` or `tolerance` is out of range.
    """

    safety: float = 0.5
    tolerance: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "safety", number(self.safety, "AdaptiveStep.safety", above=0.0, most=1.0))
        if self.tolerance is not None:
            object.__setattr__(self, "tolerance", number(self.tolerance, "AdaptiveStep.tolerance", above=0.0))


StepRule = AutoStep | AdaptiveStep
"""How to choose the time step."""


BODIES = "bodies"
"""The key of all bodies together among integrators: they are one system."""

Integrators: TypeAlias = Integrator | str | Mapping[ItemKey, Integrator | str]
"""One integrator for all that it can drive, or one for each item."""


class Options(TypedDict, total=False):
    """The numerical choices as keyword arguments; `Simulation` explains them."""

    integrator: Integrators
    dt: float | StepRule | Literal["auto"]
    precision: Precision
    threads: int | None
    max_energy_growth: float | None
    on_divergence: DivergenceRule
    fluids: Fluids
    contacts: Contacts


def require_options(given: Iterable[str], caller: str) -> None:
    """Check the names of numerical choices.

    Raises:
        KeywordError: a name is unknown.
    """
    for name in given:
        if name not in Options.__annotations__:
            raise KeywordError(caller, name, Options.__annotations__)


@dataclass(frozen=True)
class Numerics:
    """Numerical choices, checked, with every "auto" but the time step's resolved."""

    integrator: Integrator
    """The integrator of the bodies; of the first system where there are none."""
    dt: float | StepRule
    precision: Literal["f32", "f64"]
    threads: int | None
    max_energy_growth: float
    on_divergence: DivergenceRule
    integrators: Mapping[str, Integrator] = field(default_factory=dict)
    """Where not all are the same: that of each system by its path, of the bodies by the key "bodies"; else empty."""
    fluids: Mapping[str, FluidMethod] = field(default_factory=dict)
    """The method of each fluid by its path."""
    contacts: ContactSolver | None = None
    """The solver of the contacts of rigid bodies, if there are any."""

    @property
    def adaptive(self) -> AdaptiveStep | None:
        """The rule of steps that follow the motion, if they do: AdaptiveStep, or that of the integrator itself."""
        if isinstance(self.dt, AutoStep) and isinstance(self.integrator, GaussRadau15):
            return AdaptiveStep(self.dt.safety, self.integrator.tolerance)
        return self.dt if isinstance(self.dt, AdaptiveStep) else None

    @property
    def resolves(self) -> bool:
        """Whether the time step resolves the fastest oscillation."""
        return isinstance(self.dt, AutoStep) and self.dt.resolve


def check(options: Options, scene: Scene) -> Numerics:
    """Check numerical choices, and make those for a scene that were left open.

    Raises:
        SceneError: a choice is not valid; the message starts with its name.
    """
    threads = options.get("threads")
    rule = word(options.get("on_divergence", "raise"), "on_divergence", DIVERGENCE_RULES)
    growth = options.get("max_energy_growth")
    step = options.get("dt", "auto")
    automatic = is_word(step, "auto")
    chosen, dt = _integrators(options.get("integrator", "auto"), scene, automatic), _dt(step, scene)
    integrator = next(iter(chosen.values()))
    for each in chosen.values():
        if isinstance(dt, AutoStep) and each.self_adaptive and len(chosen) > 1:
            raise SceneError(
                f"dt: {type(each).__name__}() chooses the steps of the bodies, and other items of this scene would "
                "have to take the same: give dt a number, or AdaptiveStep()"
            )
        if isinstance(dt, AdaptiveStep) and dt.tolerance is not None and each.self_adaptive:
            kind = type(each).__name__
            raise SceneError(
                f"dt: {kind}() has a tolerance of its own: leave dt out, and write {kind}(tolerance=…) or {kind}()"
            )
        if isinstance(dt, AdaptiveStep) and dt.tolerance is not None and not each.embedded:
            able = " or ".join(f"{kind.__name__}()" for kind in suited(scene) if kind.embedded)
            raise SceneError(
                f"dt: AdaptiveStep(tolerance=…) needs an integrator that estimates its errors, {able}, "
                f"got {type(each).__name__}(); without a tolerance the step follows the scene's limit"
            )
    return Numerics(
        integrator=integrator,
        integrators=chosen if len(set(chosen.values())) > 1 else {},
        dt=dt,
        precision=_precision(options.get("precision", "auto"), scene),
        threads=None if threads is None else count(threads, "threads", least=1, most=MOST_THREADS),
        max_energy_growth=MAX_ENERGY_GROWTH[rule] if growth is None else number(growth, "max_energy_growth", above=0.0),
        on_divergence=rule,
        fluids=fluid_methods(options.get("fluids", "auto"), scene),
        contacts=contact_solver(options.get("contacts", "auto"), scene),
    )


def suited(scene: Scene) -> list[type[Integrator]]:
    """The integrators with steps of a given length that resolve the motion of a scene; Boris' in a magnetic field,
    with rods those that hold them.
    """
    items = [BODIES] * bool(scene.bodies) + [kind_of(type(each)) for each in scene.systems]
    others = (*(() if is_magnetic(scene) else (Boris,)), *(() if scene.has_rods else (RATTLE,)))
    kinds = [kind for kind in INTEGRATORS if any(map(kind.advances, items)) and not (kind.self_adaptive or kind.stiff)]
    return [kind for kind in kinds if kind not in others and (kind.holds_rods or not scene.has_rods)]


def _integrators(value: object, scene: Scene, automatic: bool) -> dict[str, Integrator]:
    """The integrator of the bodies, if there are any, and of each further system, by their paths; `automatic` says
    whether the time step is.

    Raises:
        SceneError: something is no integrator or no item, or an integrator cannot drive what it is to.
    """
    paths: dict[str, tuple[str, Integrator]] = {}
    if scene.bodies:
        paths[BODIES] = (BODIES, default_integrator(scene, automatic))
    paths |= {
        str(scene.system(each)): (kind_of(type(each)), INTEGRATORS_BY_NAME[each.default_integrator]())
        for each in scene.systems
    }
    chosen: dict[str, Integrator | None] = {}
    if isinstance(value, Mapping):
        for key, given in value.items():
            path = _path(key, scene)
            own = _integrator(given, f"integrator[{shown(key)}]", paths[path][0])
            if chosen.setdefault(path, own) != own:
                raise SceneError(f"integrator[{shown(key)}]: all bodies have one integrator, which is there already")
    else:
        one = _integrator(value, "integrator", None)
        driven = [path for path, (kind, _) in paths.items() if one is None or one.advances(kind)]
        if not driven:
            _integrator(value, "integrator", next(iter(paths.values()))[0])  # says which can
        chosen = dict.fromkeys(driven, one)
    return {path: chosen.get(path) or default for path, (_, default) in paths.items()}


def _path(key: object, scene: Scene) -> str:
    """The path of an item that an integrator is for.

    Raises:
        SceneError: there is no such item.
    """
    path = scene.system(key)
    if path is not None:
        return path
    try:
        if not (scene.bodies and is_word(key, BODIES)):
            scene.index(key)  # type: ignore[arg-type]
    except KeyError:
        known = [BODIES] * bool(scene.bodies) + [str(scene.system(each)) for each in scene.systems]
        raise SceneError(
            f"integrator[{shown(key)}]: is no item of this scene, which has {', '.join(map(repr, known))}"
        ) from None
    return BODIES


def _integrator(value: object, path: str, item: str | None) -> Integrator | None:
    """An integrator, None where none is named; one that can advance items of a kind, if that is given."""
    if is_word(value, "auto"):
        return None
    value = made(value)
    able = [kind for kind in INTEGRATORS if item is None or kind.advances(item)]
    if isinstance(value, INTEGRATORS) and isinstance(value, tuple(able)):
        return value
    known = ", ".join(f"{kind.__name__}()" for kind in able)
    if isinstance(value, INTEGRATORS):
        raise SceneError(f"{path}: {type(value).__name__}() cannot drive it; {known} can")
    hint = f"; write {value.__name__}()" if isinstance(value, type) else did_you_mean(value, INTEGRATORS_BY_NAME)
    raise SceneError(f"{path}: must be one of {known}, its name, or 'auto', got {shown(value)}{hint}")


def _dt(value: object, scene: Scene) -> float | StepRule:
    """Where there are rods, "auto" is AdaptiveStep(): they turn the faster the farther they have fallen.

    In small scenes it resolves the fastest oscillation.
    """
    if isinstance(value, StepRule):
        return value
    if is_word(value, "auto"):
        return AdaptiveStep() if scene.has_rods else AutoStep(resolve=is_small(scene))
    if isinstance(value, (str, type)):
        raise SceneError(f"dt: must be a number of seconds, 'auto', AutoStep(…) or AdaptiveStep(…), got {shown(value)}")
    return span(value, "dt")


def _precision(value: object, scene: Scene) -> Literal["f32", "f64"]:
    """Double, but for fluids, which leave far more unresolved than single precision does."""
    match word(value, "precision", PRECISIONS):
        case "auto":
            return "f32" if scene.fluids else "f64"
        case chosen:
            return chosen


@dataclass(frozen=True)
class Limit:
    """The largest time step that a scene allows with an integrator."""

    dt: float
    """[s]; inf where nothing limits it, 0.0 where no step is certain to be stable."""
    kind: LimitKind
    """Whether stability or accuracy limits it."""
    term: str
    """The term that binds."""
    stability: float
    """The limit of stability alone [s]."""
    accuracy: float
    """The limit of accuracy alone [s]."""
    certified: float
    """The limit of stability that holds wherever springs turn, while none is shorter than half its rest length [s]."""
    endured: float = math.inf
    """No step above this is stable in the present state [s]: the true limit lies between `stability` and this. Where it
    is known exactly, as for particles under harmonic central forces and linear drag alone, the two are equal, but for
    integrators that are stable on both sides of a resonance; inf where no such step is known."""

    @property
    def kept(self) -> float:
        """The largest step that stays stable wherever springs turn, and that is accurate [s]."""
        return min(self.certified, self.accuracy)


def largest_step(limit: Limit, rule: StepRule, integrator: Integrator, fps: float) -> float:
    """The largest time step [s] that the rule allows.

    Raises:
        SceneError: no time step is certain to be stable.
    """
    if limit.dt <= 0.0:
        others = [kind for kind in (SemiImplicitEuler, VelocityVerlet) if not isinstance(integrator, kind)]
        advice = f", or use {' or '.join(f'{kind.__name__}()' for kind in others)}" if len(others) > 1 else ""
        certain = "certain to be stable" if limit.endured > 0.0 else "stable"
        raise SceneError(
            f"dt: no time step is {certain} with {type(integrator).__name__} in this scene (because of {limit.term}); "
            f"choose dt yourself and accept the growth of energy{advice}"
        )
    if math.isinf(limit.dt):
        return free_step(fps)
    resolved = integrator.resolving if isinstance(rule, AutoStep) and rule.resolve else math.inf
    return min(rule.safety * limit.dt, resolved * limit.stability, limit.certified)


def free_step(fps: float) -> float:
    """The time step where nothing limits it [s]."""
    return 1.0 / (STEPS_PER_FREE_FRAME * fps)


def steps_to(interval: float, dt: float, slack: float) -> int:
    """The fewest steps of dt [s] that fill an interval [s], up to a fraction `slack` of a step.

    Raises:
        SceneError: they are too many to count.
    """
    steps = interval / dt - slack if dt > 0.0 else math.inf
    if steps > MOST:
        raise SceneError(
            f"duration: {interval:g} s are {steps:.1e} steps of {dt:g} s, which is more than can be counted"
        )
    return math.ceil(steps)


def divide(interval: float, largest: float) -> tuple[int, float]:
    """The fewest equal steps of at most `largest` that fill an interval: (number, dt)."""
    steps = max(1, steps_to(interval, largest, 1e-9))
    return steps, interval / steps
