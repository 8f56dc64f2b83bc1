"""The command line: `physcore list`, `physcore demo`, `physcore bench`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import physcore
from physcore.errors import PhyscoreError

INTERRUPTED = 130
"""The exit code after Ctrl-C, as shells have it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; give its exit code: 0, 1 when it failed, 2 when the arguments made no sense."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except PhyscoreError as error:
        print(f"physcore: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("physcore: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()  # The reader has left (`physcore list | head`); there is nobody to complain to.
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="physcore", description="Particles and spring networks with an energy budget that closes."
    )
    parser.add_argument("--version", action="version", version=f"physcore {physcore.__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    commands.add_parser("list", help="name the demos").set_defaults(run=_list)
    demo = commands.add_parser("demo", help="run a demo: write its GIF, print its audit")
    demo.add_argument("name", nargs="?", metavar="NAME", help="one of `physcore list` (default: the first)")
    demo.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="the GIF, or the PNG of its last frame, to write (default: NAME.gif)",
    )
    demo.set_defaults(run=_demo)
    bench = commands.add_parser("bench", help="measure the speed of this machine")
    bench.set_defaults(run=_bench)
    return parser


def _list(options: argparse.Namespace) -> int:
    from physcore.gallery import DEMOS, caption

    width = max(map(len, DEMOS))
    for name in DEMOS:
        print(f"{name:<{width}}  {caption(name)}")
    return 0


def _demo(options: argparse.Namespace) -> int:
    from physcore.audit import audit
    from physcore.film.filming import check_target
    from physcore.gallery import DEMOS, caption, demo

    name = options.name or DEMOS[0]
    if name not in DEMOS:
        print(f"physcore: no demo {name!r}; there are {', '.join(DEMOS)}", file=sys.stderr)
        return 2
    try:
        path = check_target(options.output or f"{name}.gif")
    except PhyscoreError as error:
        print(f"physcore: {error}", file=sys.stderr)
        return 2
    print(caption(name))
    for title, recording in demo(name).main(path, progress=True).items():
        print(f"\n{title}: {audit(recording)}")
    print(f"\nThe film is {path.resolve()} ({path.stat().st_size / 1e6:.1f} MB).")
    return 0


def _bench(options: argparse.Namespace) -> int:
    from physcore.benchmark import main as bench

    bench()
    return 0


if __name__ == "__main__":
    sys.exit(main())
