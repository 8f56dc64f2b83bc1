"""What velocity Verlet would gain from damping at the velocity of the step's end: `python benches/damping.py`.

`VelocityVerlet` takes forces that depend on velocity at the predicted velocity v + h a. Taken at the velocity of the
step's end, vₙ₊₁ = (vₙ₊½ + h/2 f(xₙ₊₁))/(1 + γh/2), damping limits no step: the scheme is that of central differences,
stable for ωh < 2 at every damping ratio ξ (K.-J. Bathe, "Finite Element Procedures", § 9.2.1). With springs that are
damped γ is a matrix, and each step solves equations with it. Both are measured here on one oscillator and on a rope, in
its linear motion along itself, whose masses are joined by damped springs.
"""

from __future__ import annotations

import numpy as np
from measure import table

Array = np.ndarray

RATIOS = (0.0, 0.01, 0.1, 0.5, 1.0, 3.0)
COUNT = 16
"""Masses of the rope: of 1 kg, with springs of 1 N/m between each two and at both ends."""


def step(stiffness: Array, damping: Array, h: float, *, implicit: bool) -> Array:
    """The matrix of a step of M = 1, on (x, v, a) or on (x, v)."""
    one, none = np.eye(len(stiffness)), np.zeros_like(stiffness)
    if not implicit:
        half = np.hstack([none, one, 0.5 * h * one])
        x = np.hstack([one, none, none]) + h * half
        predicted = half + np.hstack([none, none, 0.5 * h * one])
        a = -stiffness @ x - damping @ predicted
        return np.vstack([x, half + 0.5 * h * a, a])
    half = np.hstack([-0.5 * h * stiffness, one - 0.5 * h * damping])
    x = np.hstack([one, none]) + h * half
    v = np.linalg.solve(one + 0.5 * h * damping, half - 0.5 * h * stiffness @ x)
    return np.vstack([x, v])


def limit(stiffness: Array, damping: Array, *, implicit: bool) -> float:
    """The largest stable step, by bisection: up to 2/ω stability is one interval."""
    low, high = 0.0, 2.1 / np.sqrt(np.linalg.eigvalsh(stiffness)[-1])
    for _ in range(25):
        middle = 0.5 * (low + high)
        radius = np.abs(np.linalg.eigvals(step(stiffness, damping, middle, implicit=implicit))).max()
        low, high = (middle, high) if radius <= 1.0 + 1e-7 else (low, middle)
    return low


def exponential(matrix: Array) -> Array:
    """exp by its series, of the matrix halved until its norm is at most 1/2: 18 terms leave 2⁻¹⁹/19! = 2e-23."""
    halvings = max(0, int(np.ceil(np.log2(np.linalg.norm(matrix, 1)))) + 1)
    scaled = matrix / 2.0**halvings
    term = total = np.eye(len(matrix))
    for order in range(1, 19):
        term = term @ scaled / order
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def error(stiffness: Array, damping: Array, h: float, steps: int, *, implicit: bool) -> float:
    """The largest error of the positions after each of some steps, from the slowest mode at rest with amplitude 1."""
    _, modes = np.linalg.eigh(stiffness)
    x = modes[:, 0] / np.abs(modes[:, 0]).max()
    size = len(x)
    jacobian = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])
    exact = np.concatenate([x, 0.0 * x])
    found = exact if implicit else np.concatenate([x, 0.0 * x, -stiffness @ x])
    flow, matrix = exponential(h * jacobian), step(stiffness, damping, h, implicit=implicit)
    largest = 0.0
    for _ in range(steps):
        exact, found = flow @ exact, matrix @ found
        largest = max(largest, float(np.abs(found[:size] - exact[:size]).max()))
    return largest


def compare(name: str, stiffness: Array, steps: int) -> None:
    """Print limits and errors; damping grows with stiffness, and gives the fastest mode the damping ratio ξ."""
    fastest = np.sqrt(np.linalg.eigvalsh(stiffness)[-1])

    def row(ratio: float) -> tuple[float, ...]:
        damping, ways = 2.0 * ratio / fastest * stiffness, (False, True)
        limits = (fastest * limit(stiffness, damping, implicit=way) for way in ways)
        return ratio, *limits, *(error(stiffness, damping, 0.1 / fastest, steps, implicit=way) for way in ways)

    title = f"{name}: stable up to ω·h; error of the slowest mode in {steps} steps of ω·h = 0.1"
    columns = ("ξ of the fastest mode", "limit, predicted", "implicit", "error, predicted", "implicit")
    table(title, columns, map(row, RATIOS))


if __name__ == "__main__":
    compare("One oscillator of ω = 1/s", np.eye(1), 126)
    compare(f"Rope of {COUNT}", 2.0 * np.eye(COUNT) - np.eye(COUNT, k=1) - np.eye(COUNT, k=-1), 500)
