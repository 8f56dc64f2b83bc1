"""Bending by the angles between faces: energies of bent plates, forces, momenta, vibrations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import physcore as pc
from physics.laboratory import EPSILON, Array, modal_frequency, simulation, unwarned

RIGIDITY = 0.3
"""Bending rigidity B [N·m]."""


def sheet(columns: int, rows: int, spacing: float = 1.0, **more: object) -> pc.SpringNetwork:
    """The faces of a cloth, without springs."""
    cloth = pc.cloth((columns, rows), spacing, 0.0, origin=(0.0, 0.0, 0.0))
    values = {"positions": cloth.positions, "faces": cloth.faces, **more}
    return pc.SpringNetwork(values.pop("positions"), [], 0.0, **values)


def dented(seed: int, size: float = 0.3) -> pc.SpringNetwork:
    """A sheet of 4 × 4 particles with a random shape, at rest."""
    flat = sheet(4, 4)
    rng = np.random.default_rng(seed)
    return sheet(
        4,
        4,
        positions=flat.positions + rng.uniform(-size, size, flat.positions.shape),
        mass=rng.uniform(0.5, 2.0, len(flat)),
    )


def bending(body: pc.SpringNetwork, positions: Array | None = None) -> float:
    """The energy of a shape [J]."""
    run = simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY)), pc.VelocityVerlet(), 1e-3)
    if positions is not None:
        run.set(positions=positions)
    return run.energy().by_term["dihedral"]


def angles(body: pc.SpringNetwork, x: Array) -> dict[frozenset[int], float]:
    """The angle at every edge between two faces, by its ends, found from the directions of its faces across it."""
    beyond: dict[frozenset[int], list[int]] = {}
    for face in body.faces.tolist():
        for corner in face:
            beyond.setdefault(frozenset(face) - {corner}, []).append(corner)
    found = {}
    for ends, corners in beyond.items():
        if len(corners) == 2:
            start, end = sorted(ends)
            along = (x[end] - x[start]) / np.linalg.norm(x[end] - x[start])
            one, other = ((arm := x[corner] - x[start]) - (arm @ along) * along for corner in corners)
            # The angle between the directions is π in a plane.
            found[ends] = float(np.arctan2(np.linalg.norm(np.cross(one, other)), -(one @ other)))
            found[ends] *= np.sign(np.cross(along, one) @ other)
    return found


def weights(body: pc.SpringNetwork) -> dict[frozenset[int], float]:
    """|e|²/a of every edge, where each particle corrects a of the sides of its faces so that their sum is isotropic."""
    x, faces = body.positions, body.faces.tolist()
    normals = {k: np.cross(x[b] - x[a], x[c] - x[a]) for k, (a, b, c) in enumerate(faces)}
    shares: dict[frozenset[int], float] = {}
    for particle in range(len(x)):
        star = sorted((k for k, face in enumerate(faces) if particle in face), key=lambda k: sorted(faces[k]))
        normal = sum(np.copysign(1.0, normals[k] @ normals[star[0]]) * normals[k] for k in star)
        axes = np.linalg.svd(normal[None])[2][1:]
        sides = [(k, frozenset(face) - {corner}) for k in star for face in [faces[k]] for corner in face]
        angle = np.array([np.arctan2(*(axes @ np.subtract(*x[sorted(ends)]))) for _, ends in sides])
        terms = np.stack([np.ones_like(angle), *(f(n * angle) for n in (2, 4) for f in (np.cos, np.sin))], axis=1)
        area = np.array([0.5 * np.linalg.norm(normals[k]) for k, _ in sides])
        moments = area @ terms / area.sum()
        matrix = terms.T @ (area[:, None] * terms) / area.sum()
        values, vectors = np.linalg.eigh(matrix)
        # Four times regularized by 1e-3; nothing is left along an eigenvector of a larger value.
        inverse = (1.0 - (1e-3 / (np.maximum(values, 0.0) + 1e-3)) ** 4) / np.maximum(values, 1e-14)
        change = -terms @ vectors @ (inverse * (vectors.T @ (moments * [0.0, 1.0, 1.0, 1.0, 1.0])))
        change *= min(1.0, 0.75 / max(-change.min(), 1e-300))
        factor = (1.0 + change) * area.sum() / (area @ (1.0 + change))
        for (_, ends), share in zip(sides, factor * area / 3.0, strict=True):
            shares[ends] = shares.get(ends, 0.0) + share
    return {ends: float((np.subtract(*x[list(ends)]) ** 2).sum()) / shares[ends] for ends in angles(body, x)}


def slopes(body: pc.SpringNetwork) -> tuple[Array, Array]:
    """The linear angles of a flat sheet as a matrix on heights (H, N), and the weights of the edges in use."""
    force = pc.Dihedral(body, 1.0)
    matrix = np.zeros((len(force.hinges), len(body)))
    for row, (start, end, *corners) in zip(matrix, force.hinges, strict=True):
        edge = body.positions[end] - body.positions[start]
        for corner in corners:
            arm = body.positions[corner] - body.positions[start]
            along = (arm @ edge) / (edge @ edge)
            height = np.linalg.norm(arm - along * edge)
            row[[start, end, corner]] += np.array([along - 1.0, -along, 1.0]) / height
    return matrix, np.array(force.weight)


def gradient(run: pc.Simulation, x: Array) -> Array:
    """∇U (N, 3) by central differences of order four."""
    h = 1e-3
    result = np.empty_like(x)
    for index in np.ndindex(*x.shape):
        energies = []
        for shift in (-2, -1, 1, 2):
            moved = x.copy()
            moved[index] += shift * h
            run.set(positions=moved)
            energies.append(run.energy().potential)
        result[index] = (8.0 * (energies[2] - energies[1]) - (energies[3] - energies[0])) / (12.0 * h)
    run.set(positions=x)
    return result


def forces(body: pc.SpringNetwork, x: Array, v: Array | float = 0.0, **options: float) -> Array:
    """The forces on the particles (N, 3): one explicit step of 1 s changes v by exactly F/m."""
    run = simulation(
        pc.Scene(body, pc.Dihedral(body, RIGIDITY, **options)), pc.ExplicitEuler(), 1.0, on_divergence="ignore"
    )
    run.set(positions=x, velocities=np.broadcast_to(v, x.shape))
    run.step(1)
    return (run.velocities - v) * body.mass[:, None]


@given(seed=st.integers(0, 2**32 - 1))
def test_the_energy_is_that_of_the_angles(seed):
    body = dented(seed)
    x = body.positions + np.random.default_rng(seed + 1).uniform(-0.3, 0.3, body.positions.shape)
    rest, weight = angles(body, body.positions), weights(body)
    turned = {ends: angle - rest[ends] for ends, angle in angles(body, x).items()}
    nearest = {ends: (angle + np.pi) % (2.0 * np.pi) - np.pi for ends, angle in turned.items()}
    expected = sum(0.5 * RIGIDITY * weight[ends] * angle**2 for ends, angle in nearest.items())
    assert bending(body, x) == pytest.approx(expected, rel=1e-9)


@given(seed=st.integers(0, 2**32 - 1))
def test_the_force_is_minus_the_gradient_of_the_energy(seed):
    """At heights of some 0.3 m and more the error of the differences, h⁴ U⁽⁵⁾/30, is below 1e-8 N."""
    body = dented(seed, 0.15)
    x = body.positions + np.random.default_rng(seed + 1).uniform(-0.15, 0.15, body.positions.shape)
    run = simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY)), pc.VelocityVerlet(), 1e-3)
    np.testing.assert_allclose(forces(body, x), -gradient(run, x), rtol=1e-7, atol=1e-7)


@given(seed=st.integers(0, 2**32 - 1))
def test_forces_have_neither_a_sum_nor_a_moment(seed):
    """Four corners of each hinge cancel, damped too: what is left is an ε of each of some 40 hinges' forces."""
    body = dented(seed)
    rng = np.random.default_rng(seed + 1)
    x = body.positions + rng.uniform(-0.3, 0.3, body.positions.shape)
    found = forces(body, x, rng.uniform(-1.0, 1.0, x.shape), damping=0.1)
    size = 40.0 * EPSILON * max(1.0, float(np.abs(found).max()))
    assert np.abs(found.sum(axis=0)).max() <= 10.0 * size
    assert np.abs(np.cross(x, found).sum(axis=0)).max() <= 100.0 * size


def test_a_shape_at_rest_stays_at_rest():
    """Angles are those at rest to rounding, an ε of 1 rad, and so are the torques; 1 s of that moves nothing."""
    body = dented(5)
    run = simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY)), pc.VelocityVerlet(), 1e-2)
    run.step(100)
    assert np.abs(run.positions - body.positions).max() <= 1e3 * EPSILON
    assert run.energy().potential <= 1e3 * EPSILON**2


@pytest.mark.parametrize("stretch", [1.0, 1.25, 1.5])
@given(curvature=st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3))
def test_a_cloth_bends_as_a_plate_in_every_direction(stretch, curvature):
    """½ B ((κ_x + κ_y)² − 2 (1 − ν) (κ_x κ_y − κ_xy²)) per area with ν = −1/3, once the particles where eight edges
    meet have moved to where the energy is least. Four cells are a period of the mesh. Weights are regularized.
    """
    flat = sheet(9, 9)
    body = sheet(9, 9, positions=flat.positions * [1.0, stretch, 1.0])
    turns, weight = slopes(body)
    x, y, _ = body.positions.T
    column, row = np.arange(81) % 9, np.arange(81) // 9
    kx, ky, kxy = curvature
    middle = body.positions[pc.Dihedral(body, 1.0).hinges[:, :2]].mean(axis=1)
    inside = np.ones(len(middle))
    for axis, side in ((0, 1.0), (1, stretch)):
        # Edges on the border of the period count half.
        inside *= np.interp(
            middle[:, axis] - 4.0 * side, [-1.01 * side, -side, side, 1.01 * side], [0.0, 0.5, 0.5, 0.0]
        )
        inside *= np.where(np.abs(middle[:, axis] - 4.0 * side) < 0.99 * side, 2.0, 1.0)
    bent, moved = turns @ (0.5 * kx * x**2 + 0.5 * ky * y**2 + kxy * x * y), turns @ ((column + row) % 2 - 0.0)
    share = inside * weight
    least = share @ bent**2 - (share @ (bent * moved)) ** 2 / (share @ moved**2)
    plate = (kx + ky) ** 2 - 8.0 / 3.0 * (kx * ky - kxy**2)
    assert 0.5 * least / (4.0 * stretch) == pytest.approx(0.5 * plate, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("direction", [0.0, 0.2, 0.5, 1.1, np.pi / 2])
def test_equilateral_triangles_bend_alike_in_every_direction(direction):
    """Six triangles of side l = 1 about a particle have six edges between them, each with √3/6 l² about it. The angles
    of a shape on a cylinder differ from those of a small bend by O(l²/R²).
    """
    around = np.arange(6) * np.pi / 3.0
    x = np.array([[0.0, 0.0, 0.0], *np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=1)])
    body = pc.SpringNetwork(x, [], 0.0, faces=[[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    along, across = np.array(
        [[np.cos(direction), np.sin(direction), 0.0], [-np.sin(direction), np.cos(direction), 0.0]]
    )
    errors = []
    for radius in (20.0, 40.0):
        turn = (x @ along) / radius
        height = radius * (1.0 - np.cos(turn))
        bent = np.outer(x @ across, across) + np.outer(radius * np.sin(turn), along) + np.outer(height, [0.0, 0.0, 1.0])
        errors.append(bending(body, bent) / (0.5 * RIGIDITY / radius**2 * np.sqrt(3.0)) - 1.0)
    assert abs(errors[0]) < 1.0 / 20.0**2
    assert errors[1] == pytest.approx(errors[0] / 4.0, rel=0.02)


def equilateral(columns: int, rows: int) -> pc.SpringNetwork:
    """Equilateral triangles of side 1 between rows of particles, of which every second is shifted by half a side."""
    column, row = np.arange(columns * rows) % columns, np.arange(columns * rows) // columns
    x = np.stack([column + 0.5 * (row % 2), np.sqrt(0.75) * row, 0.0 * row], axis=1)
    faces = []
    for k in range(columns * (rows - 1)):
        if k % columns < columns - 1:
            low, up = (k, k + 1), (k + columns, k + columns + 1)
            odd = (k // columns) % 2
            faces += [[*low, up[odd]], [low[1 - odd], *up[::-1]]]
    return pc.SpringNetwork(x, [], 0.0, faces=faces)


SHEETS = {
    "cloth": lambda count: sheet(count + 2, 5),
    "cloth across": lambda count: turned(sheet(5, count + 2)),
    "equilateral": lambda count: equilateral(count + 2, 5),
}


def turned(body: pc.SpringNetwork) -> pc.SpringNetwork:
    """A sheet with its rows along x."""
    return pc.SpringNetwork(body.positions[:, [1, 0, 2]], [], 0.0, faces=body.faces)


@pytest.mark.parametrize("kind", SHEETS)
def test_a_cantilever_sags_as_in_textbooks(kind):
    """q L⁴/(8 D (1 − ν²)) under a load q per area on a strip with free sides, ν = −1/3. The strip is level between the
    first two columns, which are held. The clamp keeps it flat across too, so that the sag is less by O(b/L), which
    halves with twice the length; what is left after extrapolation is of order (b/L)² = 1/64. Heights are those at which
    the forces of the engine balance the load.
    """
    errors = []
    for count in (16, 32):
        body = SHEETS[kind](count)
        x = body.positions[:, 0]
        columns = np.unique(np.round(x, 9))
        level = columns[2 if kind == "equilateral" else 1]
        held = x <= level + 1e-9
        area = np.zeros(len(body))
        for face in body.faces:
            (a, b), (c, d) = (body.positions[face[1:], :2] - body.positions[face[0], :2]).tolist()
            area[face] += abs(a * d - b * c) / 6.0
        turns, weight = slopes(body)
        stiffness = RIGIDITY * turns.T @ (weight[:, None] * turns)
        load = 1e-9
        height = np.zeros(len(body))
        height[~held] = np.linalg.solve(stiffness[np.ix_(~held, ~held)], load * area[~held])
        found = forces(body, body.positions + np.outer(height, [0.0, 0.0, 1.0]))[~held, 2]
        np.testing.assert_allclose(found, -load * area[~held], rtol=1e-5, atol=1e-3 * load)
        length = x.max() - 0.5 * level
        expected = load * length**4 / (8.0 * RIGIDITY * (1.0 - 1.0 / 9.0))
        errors.append(height[np.argmax(x)] / expected - 1.0)
    assert abs(2.0 * errors[1] - errors[0]) < 1.0 / 64.0
    assert -0.1 < errors[0] < errors[1] < 0.0


def hinge(angle: float) -> Array:
    """Two right triangles at an edge of length 1, the second turned against the first."""
    return np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -np.cos(angle), np.sin(angle)]])


@pytest.mark.parametrize("rest", [0.0, 0.7, -2.5, 3.0])
def test_angles_are_followed_all_the_way_to_a_fold(rest):
    """Energies are those of the nearest turn from the rest, and continuous where it changes."""
    body = pc.SpringNetwork(hinge(rest), [], 0.0, faces=[[0, 1, 2], [1, 0, 3]])
    (weight,) = pc.Dihedral(body, RIGIDITY).weight
    for angle in np.linspace(-np.pi, np.pi, 25):
        nearest = abs((angle - rest + np.pi) % (2.0 * np.pi) - np.pi)
        assert bending(body, hinge(angle)) == pytest.approx(0.5 * RIGIDITY * weight * nearest**2, rel=1e-9, abs=1e-25)


@given(seed=st.integers(0, 2**32 - 1))
def test_neither_the_sense_nor_the_order_of_faces_matters(seed):
    body = dented(seed)
    rng = np.random.default_rng(seed)
    x = body.positions + rng.uniform(-0.2, 0.2, body.positions.shape)
    shuffled = rng.permuted(rng.permutation(body.faces), axis=1)
    other = sheet(4, 4, positions=body.positions, mass=body.mass, faces=shuffled)
    np.testing.assert_allclose(forces(other, x), forces(body, x), rtol=1e-9, atol=1e-9)


def test_a_mirror_image_bends_alike():
    body = dented(2)
    x = body.positions + np.random.default_rng(3).uniform(-0.2, 0.2, body.positions.shape)
    mirror = np.array([1.0, 1.0, -1.0])
    image = sheet(4, 4, positions=mirror * body.positions, mass=body.mass)
    assert bending(image, mirror * x) == bending(body, x)
    assert np.array_equal(forces(image, mirror * x), mirror * forces(body, x))


def test_a_clamped_strip_swings_as_a_beam_does():
    """ω² = 1.8751⁴ (8/9) B b/(λ L⁴) for the width b and the mass λ per length (Landau and Lifshitz, Theory of
    elasticity, § 25, problem 5).

    Its sides are free, so that B (1 − ν²) is the rigidity, with ν = −1/3. Where two columns are held, the strip is
    level at their middle, from which its length counts. The clamp keeps the strip flat across, which raises ω² by
    O(b/L), 4/30 of a half.
    """
    columns, rows = 31, 5
    held = np.arange(columns * rows) % columns < 2
    share = np.outer([0.5, *[1.0] * (rows - 2), 0.5], [*[1.0] * (columns - 1), 0.5]).ravel()
    body = sheet(columns, rows, mass=share, fixed=held)
    stiffness = -np.stack([forces(body, body.positions + shift)[:, 2] for shift in lifted(len(body), 1e-5)]) / 1e-5
    root = np.sqrt(body.mass[~held])
    squares, modes = np.linalg.eigh(stiffness[np.ix_(~held, ~held)] / np.outer(root, root))
    expected = 1.87510407**4 * 8.0 / 9.0 * RIGIDITY / (columns - 1.5) ** 4
    assert 1.0 < squares[0] / expected < 1.07
    shape = np.zeros(len(body))
    shape[~held] = 1e-6 * modes[:, 0] / root
    run = pc.Simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY)), pc.VelocityVerlet(), 0.25)
    run.set(positions=body.positions + np.outer(shape, [0.0, 0.0, 1.0]))
    series = []
    for _ in range(400):
        run.step(10)
        series.append(float((body.mass * shape) @ run.positions[:, 2]))
    # What is measured over 10 dt = τ is 2 sin(ω τ/2)/τ, which is ω to (ω τ)²/24 < 1e-5.
    assert modal_frequency(np.array(series), 10 * run.dt) == pytest.approx(np.sqrt(squares[0]), rel=1e-4)


def lifted(count: int, height: float) -> Array:
    """Shifts of one particle each along z, shape (count, count, 3)."""
    return height * np.eye(count)[:, :, None] * np.array([0.0, 0.0, 1.0])


def limit(body: pc.SpringNetwork) -> float:
    """The largest stable step [s]."""
    return float(pc.Simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY))).plan.dt_limit)


def hessian(body: pc.SpringNetwork, x: Array) -> Array:
    """The stiffness matrix over the roots of masses (3 N, 3 N) by central differences of forces [1/s²]."""
    root = np.repeat(np.sqrt(body.mass), 3)
    columns = []
    for index in np.ndindex(*x.shape):
        shift = np.zeros_like(x)
        shift[index] = 1e-5
        columns.append((forces(body, x - shift) - forces(body, x + shift)).ravel() / 2e-5)
    return np.array(columns) / np.outer(root, root)


@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_steps_up_to_the_limit_are_stable(seed):
    """The limit is below 2/ω of the fastest mode: by a tenth for flat sheets, by a half for crumpled ones."""
    body = sheet(6, 5) if seed is None else dented(seed)
    x = body.positions.copy()
    if seed is not None:
        x += np.random.default_rng(seed + 1).uniform(-0.3, 0.3, x.shape)
    fastest = float(np.linalg.eigvalsh(hessian(body, x))[-1])
    run = pc.Simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY)), pc.VelocityVerlet(), dt=pc.AdaptiveStep())
    run.set(positions=x)
    found = run.plan.dt_limit
    assert found <= 2.0 / np.sqrt(fastest)
    assert found >= (0.9 if seed is None else 0.5) * 2.0 / np.sqrt(fastest)


def vibrating(damping: float = 0.0) -> pc.Scene:
    """A dented sheet, with springs along its edges, that vibrates freely."""
    body = dented(4)
    cloth = pc.cloth((4, 4), 1.0, 1.0, origin=(0.0, 0.0, 0.0), bend_stiffness=0.0)
    velocities = np.random.default_rng(0).uniform(-0.3, 0.3, body.positions.shape)
    net = pc.SpringNetwork(body.positions, cloth.pairs, 5.0, mass=body.mass, velocities=velocities, faces=body.faces)
    return pc.Scene(net, pc.Dihedral(net, RIGIDITY, damping))


@pytest.mark.parametrize(
    ("integrator", "order"), [(pc.VelocityVerlet(), 2), (pc.RungeKutta4(), 4), (pc.BlanesMoan4(), 4)]
)
@pytest.mark.parametrize("damping", [0.0, 0.2])
def test_the_budget_closes_to_the_order_of_the_integrator(integrator, order, damping):
    """The power that bending damps away is integrated with the method's own stages."""
    order = min(order, 2) if damping and not isinstance(integrator, pc.RungeKutta4) else order
    errors = []
    for steps in (200, 400):
        run = simulation(vibrating(damping), integrator, 2.0 / steps)
        start = run.energy().balance
        found = []
        for _ in range(20):
            run.step(steps // 20)
            found.append(run.energy().balance - start)
        errors.append(np.sqrt(np.mean(np.square(found))))
    assert np.log2(errors[0] / errors[1]) > order - 0.3
    assert (run.energy().dissipated_by["damping"] > 1e-3) == (damping > 0.0)


def test_the_energy_of_a_free_sheet_does_not_drift():
    """Verlet's swings by (ω dt)²; what is left after ten times as long is no larger."""
    run = simulation(vibrating(), pc.VelocityVerlet(), 0.02)
    start = run.energy().balance
    swings = []
    for _ in range(10):
        errors = []
        for _ in range(50):
            run.step(10)
            errors.append(abs(run.energy().balance - start))
        swings.append(max(errors))
    assert max(swings) < 3.0 * swings[0]


def test_damping_takes_the_share_of_a_mode():
    """A hinge between two held corners and two free ones of mass m = 1: θ'' + 2 w (c θ' + B θ) = 0 for heights of 1 m:
    γ = w c, ω² = 2 w B − γ².
    """
    body = pc.SpringNetwork(hinge(0.0), [], 0.0, faces=[[0, 1, 2], [1, 0, 3]], fixed=[0, 1])
    run = simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY, 0.1)), pc.RungeKutta4(), 0.01)
    run.set(positions=hinge(0.0) + np.outer([0, 0, 1e-6, 1e-6], [0.0, 0.0, 1.0]))
    run.step(300)
    (weight,) = pc.Dihedral(body, RIGIDITY).weight
    gamma = 0.1 * weight
    omega = np.sqrt(2.0 * weight * RIGIDITY - gamma**2)
    expected = 1e-6 * np.exp(-gamma * 3.0) * (np.cos(omega * 3.0) + gamma / omega * np.sin(omega * 3.0))
    assert run.positions[2, 2] == pytest.approx(expected, rel=1e-6)


def test_a_face_that_has_lost_its_area_feels_no_force():
    body = pc.SpringNetwork(hinge(0.5), [], 0.0, faces=[[0, 1, 2], [1, 0, 3]])
    flat = hinge(0.5)
    flat[2] = (0.5, 0.0, 0.0)
    assert not forces(body, flat, damping=0.1).any()
    assert bending(body, flat) == 0.0


def test_several_networks_bend_as_each_does():
    one, other = dented(1), dented(2)
    dust = pc.Particles([[9.0, 9.0, 9.0]])
    both = pc.Scene(one, dust, other, pc.Dihedral([other, one], RIGIDITY))
    rng = np.random.default_rng(0)
    moved = [body.positions + rng.uniform(-0.2, 0.2, body.positions.shape) for body in (one, other)]
    run = simulation(both, pc.VelocityVerlet(), 1e-3)
    run.set(positions=np.concatenate([moved[0], dust.positions, moved[1]]))
    expected = bending(one, moved[0]) + bending(other, moved[1])
    assert run.energy().by_term["dihedral"] == pytest.approx(expected, rel=1e-12)


def test_it_stands_in_the_plan():
    body = sheet(4, 3)
    with unwarned():
        plan = pc.Simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY)), dt=1e-3).plan
    assert "dihedral" in plan.stages
    assert "dihedral: 13 hinges" in str(plan)


FLAT = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [2.0, 0.0, 0.0]]


def surface(*faces: list[int]) -> pc.SpringNetwork:
    return pc.SpringNetwork(FLAT, [], 0.0, faces=list(faces))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: pc.Dihedral(None, 1.0), "Dihedral.on: must be a SpringNetwork with faces, got None"),
        (lambda: pc.Dihedral([], 1.0), r"Dihedral.on: must be a SpringNetwork with faces, got \(\)"),
        (
            lambda: pc.Dihedral(pc.Particles([[0, 0, 0]]), 1.0),
            "Dihedral.on: must be a SpringNetwork with faces, got Part",
        ),
        (
            lambda: pc.Dihedral(pc.cloth((3, 3), 1.0, 1.0), 1.0),
            "Dihedral.on: must be in 3D, got .*give its positions a z",
        ),
        (lambda: pc.Dihedral(surface(), 1.0), "Dihedral.on: must have faces, got .* without any; say which"),
        (
            lambda: pc.Dihedral([sheet(3, 3), surface()], 1.0),
            r"Dihedral.on\[1\]: must have faces, got .* without any",
        ),
        (
            lambda: pc.Dihedral(surface([0, 1, 2], [0, 1, 3], [0, 1, 4]), 1.0),
            "Dihedral.on: must have one face or two at every edge, got more at that of the particles 0 and 1; give",
        ),
        (
            lambda: pc.Dihedral(surface([0, 1, 2], [2, 1, 0]), 1.0),
            r"Dihedral.on: must have every face once, got \[0, 1, 2\] twice",
        ),
        (
            lambda: pc.Dihedral(surface([0, 1, 2], [0, 1, 5]), 1.0),
            r"must have faces with an area, and the corners of faces\[1\], the particles \[0, 1, 5\], are on a line",
        ),
        (lambda: pc.Dihedral(sheet(3, 3), -1.0), "Dihedral.stiffness: must be ≥ 0"),
        (lambda: pc.Dihedral(sheet(3, 3), 1.0, -1.0), "Dihedral.damping: must be ≥ 0"),
        (lambda: pc.Scene(sheet(3, 3), pc.Dihedral(sheet(3, 3), 1.0)), r"forces\[0\].on: .* is not in the scene"),
    ],
)
def test_what_cannot_bend_is_refused(build, message):
    with pytest.raises(pc.SceneError, match=message):
        build()


@pytest.mark.parametrize("integrator", [pc.XPBD(), pc.ProjectiveDynamics()])
def test_methods_without_its_derivatives_refuse_it(integrator):
    body = sheet(3, 3)
    with pytest.raises(pc.SceneError, match=r"integrator: expected one that evaluates forces, .* for a Dihedral, got"):
        pc.Simulation(pc.Scene(body, pc.Dihedral(body, RIGIDITY)), integrator, 1e-3)
