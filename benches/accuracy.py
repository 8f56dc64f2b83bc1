"""What `simulate(accuracy=…, energy_drift=…)` costs, and whether it keeps its word, on random scenes of every kind.

python benches/accuracy.py [SEED …] [--scenes N] [--only KIND]

Cost is the number of force evaluations of the whole call over that of the run that it returned. The true error is the
largest distance of any particle, at any frame, from a run of another method in double precision, whose step is halved
until that changes it by less than a twentieth of what was allowed; the true drift is that of the recording. A run is at
its limit where no step is both longer, and a whole part of the interval between two frames, and within the limit of its
method: its error cannot be larger, however much was allowed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from statistics import median

import numpy as np
from measure import table

import physcore as pc

SEEDS = (101, 102, 103)
SCENES = 24
RESOLVED = 5e-2
"""How far apart two runs of the reference may be, as a fraction of what was allowed."""
HALVINGS = 9
"""Of the step of the reference, at most."""
MOST = 3_000_000
"""Steps of the reference beyond which it is not halved again: impacts leave it at order one."""
WITHIN = 0.96
"""Steps up to this fraction of a method's limit are tried by the call."""


@dataclass(frozen=True)
class Case:
    """A scene and what is asked of it."""

    kind: str
    scene: pc.Scene
    duration: float
    fps: float
    targets: dict[str, float]


@dataclass
class Outcome:
    """What a call gave."""

    case: Case
    refused: str = ""
    evaluations: int = 0
    """Of the whole call."""
    returned: int = 0
    """Of the run that was returned."""
    seconds: float = 0.0
    again: float = 0.0
    """What recording the returned run alone takes [s]."""
    chosen: str = ""
    at_limit: bool = False
    shares: dict[str, float] = field(default_factory=dict)
    """The true error over what was allowed, by target."""
    resolved: bool = True
    """Whether the reference is good enough to tell."""

    @property
    def cost(self) -> float:
        """In runs that were returned."""
        return self.evaluations / max(1, self.returned)

    @property
    def share(self) -> float:
        """How much of what was allowed was used, of the target that binds."""
        return max(self.shares.values())

    @property
    def kept(self) -> bool:
        """Whether no target was missed."""
        return self.share <= 1.0


def rope(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """Hangs from one end or from both, let go from a slope."""
    count = int(random.integers(4, 16))
    line = pc.rope(
        count,
        1.0,
        10.0 ** random.uniform(2.0, 3.5),
        damping=float(random.choice([0.0, 0.05])),
        mass=1.0 / count,
        direction=(math.cos(slope := random.uniform(-1.2, 0.3)), math.sin(slope)),
        pinned=str(random.choice(["start", "both"])),
    )
    return pc.Scene(line, pc.Gravity((0.0, -9.81))), random.uniform(0.5, 1.5), 1.0


def cloth(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """Hangs by its upper edge, damped."""
    shape = (int(random.integers(3, 10)), int(random.integers(3, 8)))
    sheet = pc.cloth(
        shape,
        0.1,
        random.uniform(50.0, 500.0),
        damping=float(random.choice([0.0, 0.02, 0.1])),
        mass=0.01,
        pinned=str(random.choice(["top", "top corners"])),
    )
    return pc.Scene(sheet, pc.Gravity((0.0, -9.81))), random.uniform(0.3, 1.0), 0.5


def jelly(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """A soft block that turns and wobbles in free flight, or falls to a floor."""
    shape = tuple(int(each) for each in random.integers(3, 6, size=2))
    block = pc.soft_body(shape, 0.1, random.uniform(100.0, 1000.0), damping=random.choice([0.0, 0.1]), mass=0.02)
    spin = random.uniform(-3.0, 3.0)
    places = block.positions + np.array([0.0, 0.2])
    kicks = spin * np.stack([-places[:, 1], places[:, 0]], axis=1) + 0.1 * random.normal(size=places.shape)
    body = pc.SpringNetwork(
        places,
        block.pairs,
        block.stiffness,
        damping=block.damping,
        rest_length=block.rest_length,
        mass=block.mass,
        velocities=kicks,
    )
    floor = [pc.Floor(0.0)] if random.random() < 0.3 else []
    return pc.Scene(body, pc.Gravity((0.0, -9.81)), *floor), random.uniform(0.3, 0.8), 0.5


def orbit(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """Planets around a sun, from where they are nearest."""
    planets = int(random.integers(1, 4))
    e, a, at = random.uniform(0.0, 0.8, planets), random.uniform(0.5, 2.0, planets), random.uniform(0, 7, planets)
    unit = np.stack([np.cos(at), np.sin(at)], axis=1)
    across = np.stack([-np.sin(at), np.cos(at)], axis=1)
    bodies = pc.Particles(
        (a * (1.0 - e))[:, None] * unit, velocities=np.sqrt((1.0 + e) / (1.0 - e) / a)[:, None] * across
    )
    return pc.Scene(bodies, pc.CentralForce((0.0, 0.0), 1.0, exponent=-2.0)), random.uniform(5.0, 30.0), 1.0


def well(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """A few masses in a field that grows, or falls, with a power of the distance."""
    count = int(random.integers(1, 6))
    bodies = pc.Particles(random.uniform(-1.0, 1.0, (count, 3)), velocities=random.normal(scale=0.5, size=(count, 3)))
    exponent = float(random.choice([-1.0, 0.0, 1.0, 2.0, 3.0]))
    force = pc.CentralForce((0.0, 0.0, 0.0), random.uniform(0.5, 20.0), exponent, 0.2)
    return pc.Scene(bodies, force), random.uniform(2.0, 20.0), 1.0


def atoms(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """A warm Lennard-Jones gas in a periodic square."""
    side = int(random.integers(4, 7)) * 1.25
    places = pc.block((0.0, 0.0), (side, side), 1.25)
    speeds = random.normal(scale=random.uniform(0.1, 1.0), size=places.shape)
    scene = pc.Scene(
        pc.Particles(places, speeds), pc.LennardJones(epsilon=1.0, sigma=1.0), pc.Periodic((0.0, 0.0), (side, side))
    )
    return scene, random.uniform(0.5, 2.0), 1.0


def grains(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """Elastic spheres that meet now and then."""
    count = int(random.integers(3, 6))
    places = pc.block((0.0, 0.0), (float(count), float(count)), 1.0)
    spheres = pc.Particles(places, random.normal(size=places.shape), radius=0.4)
    domain = pc.Periodic((0.0, 0.0), (float(count), float(count)))
    return (
        pc.Scene(spheres, pc.SoftSpheres(stiffness=random.uniform(100.0, 1000.0)), domain),
        random.uniform(0.5, 1.5),
        1.0,
    )


def drag(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """Shots in air, with wind."""
    count = int(random.integers(1, 8))
    balls = pc.Particles(np.zeros((count, 3)), velocities=random.normal(scale=20.0, size=(count, 3)))
    air = pc.Drag(random.uniform(0.0, 0.3), random.uniform(0.0, 0.05), tuple(random.normal(scale=5.0, size=3)))
    return pc.Scene(balls, pc.Gravity((0.0, 0.0, -9.81)), air), random.uniform(1.0, 5.0), 20.0


def contacts(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """Balls in a box, with or without air."""
    count = int(random.integers(1, 6))
    places = random.uniform(0.2, 0.8, (count, 2))
    balls = pc.Particles(places, velocities=random.normal(scale=2.0, size=(count, 2)), radius=0.05)
    air = [pc.Drag(quadratic=random.uniform(0.01, 0.3))] if random.random() < 0.7 else []
    return (
        pc.Scene(balls, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (1.0, 1.0)), *air),
        random.uniform(0.3, 1.2),
        1.0,
    )


def network(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """Unequal masses on a lattice out of true, joined by unequal springs."""
    dimension, count = int(random.integers(2, 4)), int(random.integers(2, 16))
    side = math.ceil(count ** (1.0 / dimension))
    lattice = np.stack(np.meshgrid(*[np.arange(side)] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    places = lattice[:count] + random.uniform(-0.15, 0.15, (count, dimension))
    apart = np.linalg.norm(places[:, None] - places[None], axis=2)
    pairs = np.argwhere(np.triu(apart < 1.8, 1))
    if len(pairs) == 0:
        pairs = np.array([[0, 1]])
    body = pc.SpringNetwork(
        places,
        pairs,
        10.0 ** random.uniform(0.0, 3.0, len(pairs)),
        damping=float(random.choice([0.0, 0.3])) * random.uniform(0.0, 1.0, len(pairs)),
        rest_length=apart[pairs[:, 0], pairs[:, 1]] * random.uniform(0.9, 1.1, len(pairs)),
        mass=random.uniform(0.5, 2.0, count),
        velocities=0.3 * random.normal(size=places.shape),
    )
    return pc.Scene(body), random.uniform(1.0, 6.0), 1.0


def chaos(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """A double pendulum on stiff springs, let go from high up, for a few swings."""
    angle = random.uniform(1.6, 3.0)
    places = np.arange(3.0)[:, None] * np.array([math.sin(angle), -math.cos(angle)])
    rods = pc.SpringNetwork(places, [[0, 1], [1, 2]], random.uniform(200.0, 2000.0), fixed=[0])
    return pc.Scene(rods, pc.Gravity((0.0, -9.81))), random.uniform(2.0, 6.0), 1.0


def water(random: np.random.Generator) -> tuple[pc.Scene, float, float]:
    """A column that collapses."""
    spacing = random.uniform(0.04, 0.06)
    column = pc.Fluid(pc.block((0.0, 0.0), (0.3, 0.5), spacing), spacing)
    return pc.Scene(column, pc.Gravity((0.0, -9.81)), pc.Box((0.0, 0.0), (1.0, 1.0))), random.uniform(0.1, 0.3), 0.3


Draw = Callable[[np.random.Generator], tuple[pc.Scene, float, float]]
"""Draws a scene, its duration [s], and its size [m]."""
KINDS: dict[str, tuple[Draw, tuple[float, float]]] = {
    "rope": (rope, (-7.0, -2.0)),
    "cloth": (cloth, (-7.0, -2.0)),
    "jelly": (jelly, (-5.0, -2.0)),
    "orbit": (orbit, (-9.0, -2.0)),
    "well": (well, (-9.0, -2.0)),
    "atoms": (atoms, (-7.0, -2.0)),
    "grains": (grains, (-4.0, -2.0)),
    "drag": (drag, (-9.0, -3.0)),
    "contacts": (contacts, (-5.0, -2.0)),
    "network": (network, (-8.0, -2.0)),
    "chaos": (chaos, (-6.0, -2.0)),
    "water": (water, (-3.0, -1.5)),
}
"""Each kind with the decades of its targets: accuracy as a fraction of the size, drift as it is."""


def draw(seed: int, count: int) -> Iterator[Case]:
    """Some cases, all kinds in turn: half of them ask for accuracy, a quarter for a drift, a quarter for both."""
    names = list(KINDS)
    for index in range(count):
        random = np.random.default_rng([seed, index])
        kind = names[index % len(names)]
        make, (tightest, loosest) = KINDS[kind]
        scene, duration, size = make(random)
        accuracy, drift = 10.0 ** random.uniform(tightest, loosest, 2)
        wanted = random.choice(["accuracy", "accuracy", "drift", "both"]) if kind != "water" else "drift"
        targets = {}
        if wanted != "drift":
            targets["accuracy"] = float(accuracy * size)
        if wanted != "accuracy":
            targets["energy_drift"] = float(drift)
        yield Case(kind, scene, duration, float(random.choice([10.0, 30.0])), targets)


@contextlib.contextmanager
def counted() -> Iterator[list[pc.Simulation]]:
    """Every simulation that is built meanwhile."""
    built: list[pc.Simulation] = []
    original = pc.Simulation.__init__

    def init(self: pc.Simulation, *arguments: object, **options: object) -> None:
        original(self, *arguments, **options)  # type: ignore[arg-type]
        built.append(self)

    pc.Simulation.__init__ = init  # type: ignore[method-assign]
    try:
        yield built
    finally:
        pc.Simulation.__init__ = original  # type: ignore[method-assign]


def measure(case: Case) -> Outcome:
    """Make the call, and look at what it gave."""
    outcome = Outcome(case)
    with counted() as built, contextlib.redirect_stdout(io.StringIO()):
        begin = time.perf_counter()
        try:
            recording = pc.simulate(case.scene, case.duration, case.fps, threads=1, **case.targets)
        except pc.AccuracyError as error:
            outcome.refused = f"best {error.error:.1e} m, drift {error.energy_drift:.1e}"
        outcome.seconds = time.perf_counter() - begin
    outcome.evaluations = sum(run.steps * run.plan.evaluations for run in built)
    built.clear()
    if outcome.refused:
        return outcome
    plan = recording.plan
    assert recording.provenance is not None
    assert recording.provenance.segments is not None
    outcome.returned = sum(each.steps for each in recording.provenance.segments) * plan.evaluations
    per_frame = round(1.0 / (case.fps * plan.dt))
    coarser = 1.0 / (case.fps * (per_frame - 1)) if per_frame > 1 else math.inf
    outcome.chosen = f"{plan.integrator} {per_frame}"
    outcome.at_limit = per_frame == 1 or (plan.limit_kind == "stability" and coarser > WITHIN * plan.dt_limit)
    integrator = getattr(pc, plan.integrator)()
    begin = time.perf_counter()
    pc.simulate(case.scene, case.duration, case.fps, integrator=integrator, dt=plan.dt, threads=1)
    outcome.again = time.perf_counter() - begin
    if "energy_drift" in case.targets:
        outcome.shares["energy_drift"] = float(np.abs(recording.energy.drift).max()) / case.targets["energy_drift"]
    if "accuracy" in case.targets:
        error, doubt = true_error(case, recording)
        outcome.shares["accuracy"] = error / case.targets["accuracy"]
        outcome.resolved = doubt <= RESOLVED
    return outcome


def true_error(case: Case, recording: pc.Recording) -> tuple[float, float]:
    """The largest distance from a reference [m]; and what its last halving changed, over what was allowed."""
    plan = recording.plan
    other: pc.Integrator = pc.DormandPrince5() if plan.integrator != "DormandPrince5" else pc.RungeKutta4()
    limit = pc.stability_limit(case.scene, other)
    steps = math.ceil(1.0 / (case.fps * min(limit, plan.dt, 1.0 / case.fps))) if limit > 0 else 1
    before = None
    doubt = math.inf
    for _ in range(HALVINGS):
        steps *= 2
        run = pc.Simulation(case.scene, other, 1.0 / (case.fps * steps), "f64", threads=1)
        positions = run.record(case.duration, case.fps, ("positions",), progress=False).positions
        if before is not None:
            doubt = farthest(case.scene, positions, before) / case.targets["accuracy"]
        before = positions
        if doubt <= RESOLVED or (before is not None and steps * len(positions) > MOST):
            break
    assert before is not None
    return farthest(case.scene, recording.positions, before), doubt


def farthest(scene: pc.Scene, one: np.ndarray, other: np.ndarray) -> float:
    """The largest distance between two recordings' particles [m]."""
    change = one - other
    if scene.periodic is not None:
        change = scene.periodic.nearest(change)
    return float(np.linalg.norm(change, axis=-1).max())


def main(seeds: tuple[int, ...] = SEEDS[:1], scenes: int = SCENES, only: str = "") -> dict[str, float]:
    """Measure all, and print a row for each."""
    outcomes = []

    def rows() -> Iterator[tuple[object, ...]]:
        for seed in seeds:
            for index, case in enumerate(draw(seed, scenes)):
                if only in ("", case.kind):
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")
                        outcomes.append(measure(case))
                    yield f"{case.kind} {seed}.{index}", *row(outcomes[-1])

    title = f"accuracy= and energy_drift= on {scenes} random scenes from each of the seeds {', '.join(map(str, seeds))}"
    costs = ("evaluations", "cost", "cost in time", "error/allowed")
    table(title, ("scene", "asked for", "chosen, steps per frame", *costs, "remarks"), rows())
    return summary(outcomes)


def row(outcome: Outcome) -> tuple[object, ...]:
    """Cells of one outcome."""
    asked = ", ".join(f"{name.removeprefix('energy_')} {value:.1e}" for name, value in outcome.case.targets.items())
    if outcome.refused:
        return asked, "refused", outcome.evaluations, "", "", "", outcome.refused
    remarks = [] if outcome.kept else ["BROKEN"]
    remarks += ["at its limit"] * outcome.at_limit + ["reference not resolved"] * (not outcome.resolved)
    costs = (outcome.evaluations, outcome.cost, outcome.seconds / outcome.again, outcome.share)
    return asked, outcome.chosen, *costs, ", ".join(remarks)


def summary(outcomes: list[Outcome]) -> dict[str, float]:
    """Medians and extremes; the figures that there are targets for."""
    given = [each for each in outcomes if not each.refused]
    free = [each.share for each in given if not each.at_limit]
    costs, times = [each.cost for each in given], [each.seconds / each.again for each in given]
    broken = sum(not each.kept for each in given)
    total = math.fsum(math.log(each.evaluations) for each in given) / len(given)
    title = f"{len(given)} of {len(outcomes)} were computed, {len(outcomes) - len(given)} refused, {broken} broken"
    spreads = {
        "cost in evaluations [returned runs]": costs,
        "cost in seconds [returned runs]": times,
        "share of what was allowed": [each.share for each in given],
        "share of it, those not at their limit": free,
    }
    columns = ("", "calls", "median", "least", "most", "above a tenth")
    rows = (
        (name, len(each), median(each), min(each), max(each), sum(one > 0.1 for one in each) / len(each))
        for name, each in spreads.items()
        if each
    )
    table(f"{title}; evaluations of a call: geometric mean {math.exp(total):.3g}", columns, rows)
    return {
        "accuracy=, cost": median(costs),
        "accuracy=, share used": median(free),
        "accuracy=, promises broken": float(broken),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("seeds", nargs="*", type=int, default=list(SEEDS))
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--only", default="", choices=["", *KINDS])
    options = parser.parse_args()
    main(tuple(options.seeds), options.scenes, options.only)
