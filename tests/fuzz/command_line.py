"""Fuzzing of the command line: exit code 0, 1 or 2, a line on stderr where it failed, and never a traceback."""

from __future__ import annotations

import contextlib
import io
import signal

from hypothesis import strategies as st
from oracle import Late, Target, limited, require

from physcore.__main__ import main

COMMANDS = st.sampled_from(
    ["list", "demo", "demo", "gallery", "tradeoff", "bench", "--version", "--help", "", "x", "\udc80"]
)
WORDS = st.sampled_from(
    [
        *(
            "rope",
            "orbits",
            "missing",
            "-o",
            "-o",
            "--output",
            "--json",
            "--budget",
            "--duration",
            "--help",
            "-h",
            "--",
            "-x",
        ),
        *(
            "out.gif",
            "out.mp4",
            "out.png",
            "out",
            "",
            ".",
            "..",
            "missing/out.gif",
            ".gif",
            "a" * 300 + ".gif",
            "\udc80.gif",
        ),
        *(
            "nan",
            "inf",
            "-1",
            "0",
            "1e308",
            "1e400",
            "0.01",
            "x",
            "--budget=nan",
            "--budget=0",
            "--duration=-1",
            "--duration=nan",
        ),
    ]
)
EXAMPLES = st.tuples(COMMANDS, st.lists(WORDS, max_size=4)).map(lambda pair: [pair[0], *pair[1]])


def check(arguments: list[str]) -> int:
    """Call the command in this process."""
    script = f"physcore {arguments!r}"
    out, errors = io.StringIO(), io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors), limited(0.3):
            code: object = main(arguments)
    except SystemExit as exit:
        code = exit.code
    except Late:
        return 1  # It does what it was asked for.
    except BaseException as error:
        require(isinstance(error, KeyboardInterrupt), f"{type(error).__name__}: {error}"[:120], script)
        raise
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    said = errors.getvalue()
    require(code in (0, 1, 2, None), f"exit code {code}", script)
    require("Traceback" not in said, "a traceback", script)
    if code in (1, 2):
        last = said.strip().rpartition("\n")[2]
        require(
            last.startswith("physcore") and ": " in last,
            "no message at the end of stderr",
            f"{script}  # {last[-200:]}",
        )
        require(
            sum(line.startswith("physcore: ") for line in said.splitlines()) <= 1,
            "more than one message",
            f"{script}  # {said[-300:]}",
        )
    return 1


TARGET = Target("command_line", EXAMPLES, check, share=0.005, quick=20)
