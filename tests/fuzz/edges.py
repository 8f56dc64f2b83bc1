"""`make edges`: what becomes of the edge values of every public argument, as a table for out/edges.md."""

from __future__ import annotations

import os
import re
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from entrances import Entrance, entrances, prepare
from oracle import Late, limited
from values import NAMES, evaluate

import physcore as pc

VALUES = {
    **{
        "0": "0",
        "−1": "-1",
        "5e-324": "5e-324",
        "1e308": "1e308",
        "10⁴⁰⁰": "10**400",
        "NaN": "float('nan')",
        "inf": "float('inf')",
    },
    **{"True": "True", "None": "None", '"x"': "'x'", "[]": "[]", "4 × 4": "np.ones((4, 4))", "class": "pc.Drag"},
}
"""The columns of the table."""
TAKEN, LONG = "✓", "…"
SECONDS = 0.5
"""After this a run that was accepted is stopped [s]."""
PATIENCE = 30.0
"""The same for what is no run, and has no reason to take long [s]."""

HEAD = f"""# Edge values

What physcore does with edge values of every public argument, all other arguments being valid. Written by `make edges`;
do not edit.

{TAKEN}: accepted. {LONG}: accepted, and stopped after {SECONDS:g} s. A letter: refused with a message of that kind
(below), here without its path and without what was given; in bold: an error that is none of
physcore's. "4 × 4" is an array of ones, "class" is `pc.Drag`. The numerics of `simulate`, `film` and `export` are those
of `Simulation`.
"""


def outcome(entrance: Entrance, name: str, source: str) -> str:
    """What a call with this argument gives: TAKEN, LONG, or what the message says was expected."""
    values: dict[str, Any] = {
        key: evaluate(text) for key, text in {**entrance.parameters, name: source}.items() if text is not None
    }
    rest = [NAMES["PARTICLES"], values.pop(entrance.rest)] if entrance.rest else []
    function = evaluate(entrance.source)
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"), limited(SECONDS if entrance.long else PATIENCE):
            warnings.simplefilter("ignore")
            result = function(*rest, **values)
            if hasattr(result, "__next__"):
                next(result)
        return TAKEN
    except Late:
        return LONG
    except pc.PhyscoreError as error:
        return expected(error)
    except Exception as error:
        return (
            f"{type(error).__name__}"
            if entrance.keys and isinstance(error, KeyError)
            else f"**{type(error).__name__}**"
        )


def expected(error: pc.PhyscoreError) -> str:
    """A message without its path, what was given and hints."""
    text = str(error.args[0] if error.args else error).partition("\n")[0]
    text = re.sub(r"^[^\s:]+: ", "", text)
    text = re.split(r",? got |; |\(the default", text)[0]
    text = re.sub(r"/\S*/", "", text)
    return re.sub(r"[-+]?\d[\d.,]*(e[-+]?\d+)?", "#", text) if len(text) > 60 else text


def rows(slow: bool) -> list[tuple[str, list[str]]]:
    """A row for each argument of what is slow to call, or of what is not: its name, and the outcome of each value."""
    chosen = [entrance for entrance in entrances() if entrance.slow is slow]
    arguments = [
        (entrance, name) for entrance in chosen for name in entrance.parameters if name not in entrance.numerics
    ]
    return sorted(
        (f"{entrance.name}.{name}", [outcome(entrance, name, source) for source in VALUES.values()])
        for entrance, name in arguments
    )


def letter(index: int) -> str:
    """a, b, …, z, aa, ab, …"""
    return (letter(index // 26 - 1) if index >= 26 else "") + chr(ord("a") + index % 26)


def table() -> str:
    """All of it as Markdown."""
    found = [*rows(slow=False), *rows(slow=True)]
    kinds: dict[str, str] = {}
    for _, cells in found:
        for cell in cells:
            if cell not in (TAKEN, LONG):
                kinds.setdefault(cell, letter(len(kinds)))
    lines = [HEAD, f"| argument | {' | '.join(VALUES)} |", f"|---|{'---|' * len(VALUES)}"]
    lines += [f"| `{name}` | {' | '.join(kinds.get(cell, cell) for cell in cells)} |" for name, cells in found]
    lines += [
        "",
        "| | message |",
        "|---|---|",
        *(f"| {short} | {kind.replace('|', chr(92) + '|')} |" for kind, short in kinds.items()),
    ]
    return "\n".join(lines) + "\n"


def faults() -> list[str]:
    """Edge values that give another error than those of physcore, or take long; without what is slow to call."""
    return [
        f"{name} of {column}: {cell}"
        for name, found in rows(slow=False)
        for column, cell in zip(VALUES, found, strict=True)
        if cell == LONG or cell.startswith("**")
    ]


def main() -> int:
    """Write the table to a file; with --check, print the faults instead."""
    path, checking = Path(sys.argv[-1]).resolve(), "--check" in sys.argv
    output = os.fdopen(os.dup(1), "w")  # A fault may close what it takes for a number of a file.
    os.fsync = lambda descriptor: None  # type: ignore[assignment]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        prepare()
        if not checking:
            path.write_text(table(), encoding="utf-8")
            return 0
        found = faults()
        print("\n".join(found), file=output)
        return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
