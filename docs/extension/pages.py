"""Execution of a page: its blocks of code run one after the other in a process of their own, as one script.

`python pages.py FOLDER < blocks.json` is that process: it runs blocks in a folder, and writes its outcome.json.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import re
import subprocess
import sys
import traceback
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

BLOCK = re.compile(r"^(?P<fence>`{3,})\{run\}[^\n]*\n(?P<body>.*?)^(?P=fence)\s*$", re.MULTILINE | re.DOTALL)
"""A block of a page that is executed."""
OPTION = re.compile(r":[a-z-]+:.*\n")
PICTURES = (".gif", ".png", ".svg", ".webp")


@dataclass(frozen=True)
class Outcome:
    """Result of a block: what it printed, and the names of the pictures that it wrote."""

    text: str
    pictures: list[str]
    error: str = ""


@dataclass(frozen=True)
class Page:
    """An executed page: its folder, all its code as a script, and an outcome for each block that ran."""

    folder: Path
    script: Path
    outcomes: list[Outcome]


def blocks(source: str) -> list[str]:
    """The code of the blocks of a page, without their options."""
    return [re.sub(rf"\A(?:{OPTION.pattern})*\n*", "", match["body"]) for match in BLOCK.finditer(source)]


def executed(path: Path, folder: Path) -> Page:
    """Execute a page, unless this has been done with the same code and the same package.

    A lock keeps processes that build in parallel from doing it twice.
    """
    import fcntl  # Not on every system; the rest of this module is used by tests.

    code = blocks(path.read_text(encoding="utf-8"))
    key = hashlib.sha256(json.dumps([code, package()]).encode()).hexdigest()[:16]
    target = folder / f"{path.stem}-{key}"
    target.mkdir(parents=True, exist_ok=True)
    script = target / f"{path.stem}.py"
    script.write_text("\n\n".join(block.strip("\n") for block in code) + "\n", encoding="utf-8")
    with (target / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        found = target / "outcome.json"
        if not found.exists():
            command = [sys.executable, __file__, str(target)]
            drawing = {"MPLBACKEND": "agg", "MATPLOTLIBRC": str(Path(__file__).with_name("matplotlibrc"))}
            subprocess.run(command, input=json.dumps(code), text=True, check=True, env=os.environ | drawing)
        outcomes = [Outcome(**values) for values in json.loads(found.read_text(encoding="utf-8"))]
        if any(outcome.error for outcome in outcomes):
            found.unlink()
    return Page(target, script, outcomes)


@cache
def package() -> str:
    """A digest of the installed package, the engine included."""
    import physcore

    root = Path(physcore.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(root.rglob("*")):
        if path.suffix in {".py", ".so", ".pyd"}:
            digest.update(path.read_bytes())
    return digest.hexdigest()


def main(folder: Path, code: list[str]) -> None:
    """Run blocks in a folder, in one namespace; the first that fails is the last. Warnings are errors."""
    import warnings

    warnings.simplefilter("error", UserWarning)
    os.chdir(folder)
    names = {"__name__": "__main__"}
    outcomes: list[Outcome] = []
    for number, block in enumerate(code, 1):
        before = _pictures()
        printed, error = io.StringIO(), ""
        try:
            with contextlib.redirect_stdout(printed):
                exec(compile(block, f"block {number}", "exec"), names)
        except Exception:
            error = traceback.format_exc()
        fresh = [name for name, time in _pictures().items() if before.get(name) != time]
        outcomes.append(Outcome(printed.getvalue(), fresh, error))
        if error:
            break
    text = json.dumps([asdict(outcome) for outcome in outcomes])
    Path("outcome.json").write_text(text, encoding="utf-8")


def _pictures() -> dict[str, int]:
    """Pictures in the working directory, in the order of their writing, with the time of it."""
    found = [(path.stat().st_mtime_ns, path.name) for path in Path().iterdir() if path.suffix in PICTURES]
    return {name: time for time, name in sorted(found)}


if __name__ == "__main__":
    main(Path(sys.argv[1]), json.loads(sys.stdin.read()))
