"""Hostile values, written as Python: what a failing call prints can be pasted into a script."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from types import CodeType
from typing import Any

import numpy as np
from hypothesis import strategies as st

import physcore as pc

NUMBERS = [
    *(
        "0",
        "1",
        "-1",
        "3",
        "0.5",
        "-0.0",
        "1e-9",
        "1e9",
        "5e-324",
        "-5e-324",
        "1e-300",
        "1e308",
        "-1e308",
        "1e39",
        "1e16",
    ),
    *("float('nan')", "float('inf')", "-float('inf')", "sys.float_info.max", "10**400", "-(10**400)", "2**31", "2**53"),
    *("2**53 + 1", "2**63", "2**64", "True", "False", "1j", "complex(1.0)", "Fraction(1, 3)", "Fraction(10**400, 3)"),
    *(
        "Decimal('1e400')",
        "Decimal('NaN')",
        "np.float16(1)",
        "np.float32('nan')",
        "np.longdouble('1e400')",
        "np.int8(-1)",
    ),
    *("np.uint64(2**63)", "np.bool_(True)", "np.complex64(1)", "np.datetime64('2020')", "np.timedelta64(1, 's')"),
    *("np.ma.masked", "np.array(1.0)", "np.array(np.nan)", "np.array(2)"),
]
"""Numbers, and what is almost one."""

TEXTS = [
    *(
        "''",
        "'x'",
        "'auto'",
        "'\\0'",
        "'\\ud800'",
        "'1'",
        "'nan'",
        "'1e400'",
        "'{}'",
        "'%s'",
        "'a' * 10_000",
        "b''",
        "b'x'",
    ),
    *("bytearray(b'1')", "memoryview(b'abc')", "np.str_('auto')", "Path('x')", "Path('missing/x')"),
]
"""Words, and what is almost one."""

ARRAYS = [
    *("[]", "()", "[[]]", "np.empty(0)", "np.empty((0, 2))", "np.empty((2, 0))", "np.empty((3, 0, 2))", "np.ones(3)"),
    *("np.ones((3, 2))", "np.ones((3, 3))", "np.ones((1, 1, 1, 1))", "[0.0, 1.0]", "(0.0, 1.0)", "(0.0, 0.0, 1.0)"),
    *("[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]", "np.eye(3)[:, ::-1]", "np.arange(3)", "np.array([0, 1])", "[0, 1, 2]"),
    *("np.array([1.0, np.nan])", "np.array([1.0, np.inf, 0.0])", "np.full((3, 2), 1e308)", "np.full((3, 2), -np.inf)"),
    *("np.ones((3, 2), '>f8')", "np.ones((3, 2), 'f2')", "np.full(3, np.longdouble('1e400'))", "np.ones(3, complex)"),
    *(
        "np.array([2**63], 'u8')",
        "np.array([-1, 5])",
        "np.array([True, False, True])",
        "[True, False]",
        "np.ones((6, 4))[::2, ::2]",
    ),
    *(
        "np.asfortranarray(np.ones((3, 2)))",
        "readonly(np.ones((3, 2)))",
        "np.array(['a', 'b'])",
        "np.array([b'a', b'b'])",
    ),
    *(
        "np.array([None, 1.0])",
        "np.array([1, 'x', []], dtype=object)",
        "np.array([10**400, 1], dtype=object)",
        "[10**400, 0]",
    ),
    *("np.ma.masked_array([1.0, 2.0, 3.0], [0, 1, 0])", "np.ma.array([1.0, 2.0, 3.0])", "np.zeros(2, [('a', 'f8')])"),
    *(
        "np.array(['2020', '2021'], 'M8[s]')",
        "np.matrix([[1.0, 2.0]])",
        "[[1.0], [1.0, 2.0]]",
        "[1, [2, [3]]]",
        "[None, None]",
    ),
    *(
        "[float('nan')] * 2",
        "[float('inf'), -float('inf')]",
        "['x', 'y']",
        "[[0, 1], [1, 0.5]]",
        "loop()",
        "deep(70)",
        "deep(2000)",
    ),
]
"""Arrays and lists, and what is almost one."""

THINGS = [
    *(
        "None",
        "...",
        "NotImplemented",
        "object()",
        "int",
        "float",
        "pc.Drag",
        "pc.Particles",
        "pc.Scene",
        "type",
    ),
    *(
        "lambda: 0",
        "lambda *arguments: arguments",
        "{}",
        "{'a': 1}",
        "{0: 1.0}",
        "set()",
        "{1.0}",
        "slice(1)",
        "range(3)",
    ),
    *(
        "iter([1.0, 2.0])",
        "(x for x in (0.0, 1.0))",
        "pc.Drag(1.0)",
        "pc.VelocityVerlet()",
        "pc.WendlandC2()",
        "pc.AutoStep()",
    ),
    *("pc.Particles([[5.0, 5.0]])", "pc.Floor(-9.0)", "styles.Points()", "film.Orbit()", "film.Window((0, 0), (1, 1))"),
    *("film.DARK", "np", "Ellipsis", "Exception('x')", "Lying()", "Word('auto')", "Real(2.0)"),
]
"""What is nothing of the kind."""

WRAPPERS = [
    *(
        "[{0}]",
        "({0},)",
        "[{0}, {1}]",
        "({0}, {1})",
        "({0}, {1}, {0})",
        "[[{0}, {1}]]",
        "[[{0}, 0.0], [{1}, 1.0], [0.0, 2.0]]",
    ),
    *(
        "np.array([{0}, {1}])",
        "np.array({0}, dtype=object)",
        "np.full(3, {0})",
        "np.full((3, 2), {0})",
        "{{{0}: {1}}}",
        "[{0}] * 3",
    ),
]
"""What is made of others."""


class Lying:
    """Something that says it has entries and has none."""

    def __len__(self) -> int:
        return 2

    def __getitem__(self, index: object) -> object:
        raise IndexError


class Word(str):
    """A text of a class of the user's."""


class Real(float):
    """A number of a class of the user's."""


def loop() -> list[Any]:
    """A list that holds itself."""
    result: list[Any] = []
    result.append(result)
    return result


def deep(levels: int) -> list[Any]:
    """A list in a list in a list …"""
    result: list[Any] = [1.0]
    for _ in range(levels):
        result = [result]
    return result


def readonly(values: np.ndarray) -> np.ndarray:
    """The same array, which cannot be written to."""
    values.flags.writeable = False
    return values


def boom(error: BaseException) -> None:
    """Raise it."""
    raise error


NAMES: dict[str, Any] = {
    **{"pc": pc, "np": np, "sys": sys, "math": math, "Path": Path, "Decimal": Decimal, "Fraction": Fraction},
    **{"film": sys.modules["physcore.film"], "styles": pc.styles, "Lying": Lying, "Word": Word, "Real": Real},
    **{"loop": loop, "deep": deep, "readonly": readonly, "boom": boom},
}
"""What these texts may name."""


@lru_cache(maxsize=8192)
def _compiled(source: str) -> CodeType:
    return compile(source, "<fuzz>", "eval")


def evaluate(source: str, **more: object) -> Any:
    """The value of an expression."""
    return eval(_compiled(source), {**NAMES, **more} if more else NAMES)


def _written(number: float) -> str:
    return repr(number) if math.isfinite(number) else f"float('{number}')"


ATOM = st.sampled_from([*NUMBERS, *TEXTS, *ARRAYS, *THINGS])
NUMBER = st.one_of(
    st.sampled_from(NUMBERS), st.floats().map(_written), st.integers(-(2**70), 2**70).map(str), st.sampled_from(NUMBERS)
)
"""Any number: the usual suspects, any float, any integer."""
PART = st.one_of(NUMBER, ATOM)
HOSTILE = st.one_of(ATOM, NUMBER, ATOM, st.builds(str.format, st.sampled_from(WRAPPERS), PART, PART))
"""Any value. Strategies are made once: to make one takes longer than to draw from it."""


def parts(value: object, depth: int = 3) -> Iterator[np.ndarray]:
    """The arrays and numbers of a result, as arrays of floats."""
    if isinstance(value, (float, np.floating, np.ndarray)):
        values = np.asarray(value)
        if values.dtype.kind == "f":
            yield values
    elif depth > 0 and isinstance(value, (list, tuple)):
        for entry in value[:8]:
            yield from parts(entry, depth - 1)
