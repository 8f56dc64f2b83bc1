"""Elementary functions and small products have the same bits on every processor, and what computes uses no others."""

from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physcore import arithmetic

PACKAGE = Path(__file__).parents[1] / "python" / "physcore"
FREE = ("film", "output", "gallery", "studies/diagnosis")
"""Folders that make pictures, files, scripts and sentences of results, and no result."""
ALLOWED = {"abs", "ceil", "floor", "gcd", "inf", "isfinite", "isinf", "isnan", "nan", "pi", "prod", "sqrt", "tau"}
"""What `math` has that is rounded alike everywhere, exactly or correctly."""
OTHERS = {
    *("exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "logaddexp", "sin", "cos", "tan", "arcsin", "arccos"),
    *("arctan", "arctan2", "angle", "sinh", "cosh", "tanh", "power", "float_power", "hypot", "cbrt", "linalg", "fft"),
    *("dot", "vdot", "inner", "matmul", "einsum", "tensordot", "convolve", "correlate", "polyfit", "polyval", "cov"),
    *("geomspace", "logspace", "corrcoef", "trapezoid", "unwrap", "sinc"),
}
"""What NumPy computes by vector instructions that processors differ in, by the C library or by BLAS."""

vectors = st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3)


def other_bits(source: str) -> list[tuple[int, str]]:
    """The lines of a source that compute with functions of the processor, the C library or BLAS, and which."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            found.append((node.lineno, "@"))
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
            if not (isinstance(node.left, ast.Constant) and isinstance(node.right, (ast.Constant, ast.UnaryOp))):
                found.append((node.lineno, "**"))
        elif isinstance(node, ast.Attribute):
            owner = node.value.id if isinstance(node.value, ast.Name) else ""
            denied = node.attr in OTHERS if owner == "np" else owner == "math" and node.attr not in ALLOWED
            if denied or node.attr == "dot":
                found.append((node.lineno, node.attr))
    return sorted(found)


def test_results_depend_on_no_function_of_the_processor():
    names = {path.relative_to(PACKAGE).as_posix(): path for path in sorted(PACKAGE.rglob("*.py"))}
    computing = {name: path for name, path in names.items() if not name.startswith(FREE)}
    assert len(computing) > 100
    found = {name: other_bits(path.read_text(encoding="utf-8")) for name, path in computing.items()}
    assert not {name: places for name, places in found.items() if places}


def test_such_functions_are_found():
    source = "a @ b\nx**2\nnp.exp(x)\nmath.log(x)\nx.dot(y)\nnp.sqrt(x) + math.sqrt(2.0) + 2**53\n"
    assert other_bits(source) == [(1, "@"), (2, "**"), (3, "exp"), (4, "log"), (5, "dot")]


@pytest.mark.parametrize("name", ["exp", "log", "sin", "cos"])
@given(x=st.floats(1e-3, 300.0))
def test_functions_are_right_to_two_units_in_the_last_place(name, x):
    value, reference = float(getattr(arithmetic, name)(x)), getattr(math, name)(x)
    assert abs(value - reference) <= 2.0 * math.ulp(reference)


@given(x=st.floats(-1e3, 1e3), y=st.floats(-1e3, 1e3))
def test_angles_are_right_to_two_units_in_the_last_place(x, y):
    assert abs(float(arithmetic.arctan2(y, x)) - math.atan2(y, x)) <= 2.0 * math.ulp(math.atan2(y, x))


def test_functions_keep_shapes_and_broadcast():
    x = np.arange(1.0, 7.0).reshape(2, 3).T
    assert arithmetic.exp(x).shape == (3, 2)
    assert arithmetic.power(x, 2.0).shape == (3, 2)
    np.testing.assert_allclose(arithmetic.power(x, [[2.0, 0.5]]), np.stack([x[:, 0] ** 2, x[:, 1] ** 0.5], 1), 1e-15)
    assert arithmetic.log(1.0).shape == ()


@given(rows=st.lists(vectors, min_size=1, max_size=4), coefficients=st.lists(vectors, min_size=3, max_size=3))
def test_products_are_those_of_matrices(rows, coefficients):
    one, other = np.array(rows), np.array(coefficients)
    # Each of three products and two sums is off by half a unit in the last place of at most the sum of sizes.
    bound = 5.0 * 2.0**-53 * (np.abs(one) @ np.abs(other)) + 1e-300
    assert (np.abs(arithmetic.combined(one, other) - one @ other) <= 2.0 * bound).all()


def test_orthonormal_rows_are_a_decomposition():
    rows = np.random.default_rng(1).normal(size=(5, 3, 7))
    basis, left = arithmetic.orthonormal(rows)
    np.testing.assert_allclose(basis @ basis.swapaxes(1, 2), np.broadcast_to(np.eye(3), (5, 3, 3)), atol=1e-14)
    r = np.linalg.qr(rows.swapaxes(1, 2))[1]
    np.testing.assert_allclose(left, np.abs(np.diagonal(r, axis1=1, axis2=2)), rtol=1e-13)


@pytest.mark.parametrize("rank", [0, 1, 4, 6])
def test_the_row_space_has_the_rank_and_projects_rows_onto_themselves(rank):
    rng = np.random.default_rng(rank)
    rows = rng.normal(size=(9, rank)) @ rng.normal(size=(rank, 6))
    rows /= max(np.linalg.norm(rows, axis=1).max(), 1.0)
    basis = arithmetic.row_space(rows.copy(), 1e-9)
    assert basis.shape == (rank, 6)
    np.testing.assert_allclose(basis @ basis.T, np.eye(rank), atol=1e-14)
    np.testing.assert_allclose(rows @ basis.T @ basis, rows, atol=1e-13)
