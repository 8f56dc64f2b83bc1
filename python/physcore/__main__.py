"""The command line: `physcore list`, `demo`, `live`, `gallery`, `tradeoff` and `bench`."""

from __future__ import annotations

import argparse
import inspect
import math
import os
import sys
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, cast

import physcore
from physcore.errors import PhyscoreError
from physcore.spelling import did_you_mean

INTERRUPTED = 130
"""Exit code after Ctrl-C: 128 + 2 (SIGINT), the convention of shells."""
QUICK = 6.0
"""Largest processor time of a demo that `physcore gallery --quick` runs [s]."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code: 0, 1 when it failed, 2 when the arguments are not valid."""
    options = _parser().parse_args(arguments)
    try:
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except PhyscoreError as error:
        print(f"physcore: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("physcore: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()  # The reader closed the pipe (`physcore list | head`): no message reaches anybody.
        return 0
    except OSError as error:
        print(f"physcore: cannot write: {error.strerror}", file=sys.stderr)
        sys.stdout = None  # Python would try again, and fail, at its end.
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="physcore", description="Films of simulated physics, with their energy budgets, from demos."
    )
    parser.add_argument("--version", action="version", version=f"physcore {physcore.__version__}")
    parser.set_defaults(run=lambda options: _help(parser))
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    commands.add_parser(
        "list", help="name the demos, with the processor time that each takes and the size of its film"
    ).set_defaults(run=_list)
    demo = commands.add_parser("demo", help="run a demo: write its film, print its audit")
    demo.add_argument("name", nargs="?", metavar="NAME", help="one of `physcore list` (default: the first)")
    demo.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="the film to write: .gif, .webp, .apng, .mp4, .html, or .png for its last frame (default: NAME.gif)",
    )
    demo.add_argument("--source", action="store_true", help="print a script that makes the film, and do not run it")
    demo.add_argument(
        "--particles", type=int, metavar="N", help="how many particles, where a demo has them by number, as two_dams"
    )
    demo.set_defaults(run=_demo)
    live = commands.add_parser("live", help="play a demo or the scene of a script, with a page in the browser")
    live.add_argument("name", metavar="NAME", help="one of `physcore list`, or a script such as cloth.py")
    live.add_argument("--port", type=int, default=0, help="port of the page, of this machine alone (default: any)")
    live.set_defaults(run=_live)
    page = commands.add_parser("gallery", help="run the demos: write their films and a page that shows them")
    page.add_argument("names", nargs="*", metavar="NAME", help="some of `physcore list` (default: all)")
    page.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="where to write index.html and the films"
    )
    page.add_argument(
        "--quick", action="store_true", help=f"leave out the demos that take more than {QUICK:g} s of processor time"
    )
    page.add_argument(
        "-j", "--jobs", type=int, default=1, metavar="N", help="how many demos to run at once (default: 1)"
    )
    page.set_defaults(run=_gallery)
    trade = commands.add_parser("tradeoff", help="measure what speed costs in accuracy in a demo")
    trade.add_argument("name", metavar="NAME", help="one of `physcore list`")
    trade.add_argument("-o", "--output", type=Path, metavar="FILE", help="a figure to write, such as trade.png")
    trade.add_argument("--json", type=Path, metavar="FILE", help="where to write all that was measured")
    trade.add_argument(
        "--budget", type=float, default=60.0, metavar="SECONDS", help="how long to measure (default: 60)"
    )
    trade.add_argument("--duration", type=float, metavar="SECONDS", help="how long to simulate (default: as the demo)")
    trade.set_defaults(run=_tradeoff)
    bench = commands.add_parser("bench", help="measure the speed of this machine")
    bench.set_defaults(run=_bench)
    return parser


def _help(parser: argparse.ArgumentParser) -> int:
    parser.print_help()
    return 0


def _list(options: argparse.Namespace) -> int:
    from physcore.gallery import DEMOS, caption, costs

    width, known = max(map(len, DEMOS)), costs()
    for name in DEMOS:
        seconds, size = (
            (f"{known[name].seconds:.0f}", f"{known[name].bytes / 1e6:.1f}") if name in known else ("?", "?")
        )
        print(f"{name:<{width}}  {seconds:>4} s  {size:>4} MB  {caption(name)}")
    return 0


def _demo(options: argparse.Namespace) -> int:
    from physcore.film.writers import WRITERS
    from physcore.film.writers.beside import videos_beside
    from physcore.gallery import DEFAULT, caption, demo
    from physcore.storage.formats import writable
    from physcore.studies.audit import audit

    name = options.name or DEFAULT
    if not _exists(name):
        return 2
    if options.source:
        print(inspect.getsource(cast(ModuleType, demo(name))), end='\n\nif __name__ == "__main__":\n    main()\n')
        return 0
    chosen, numbers = demo(name), {}
    if options.particles is not None:
        if not hasattr(chosen, "PARTICLES"):
            print(f"physcore: {name} has no --particles", file=sys.stderr)
            return 2
        numbers = {"particles": options.particles}
    try:
        path = Path(options.output or f"{name}.gif")
        writable(path, WRITERS)
        print(caption(name), flush=True)
        if numbers:
            print(_ahead(chosen, options.particles), flush=True)
    except PhyscoreError as error:
        print(f"physcore: {error}", file=sys.stderr)
        return 2
    with videos_beside() as films, warnings.catch_warnings():
        # Demos limit the size of their GIFs.
        warnings.filterwarnings("ignore", message=".*only GIFs are made to fit")
        recordings = chosen.main(path, progress=True, **numbers)
    for title, recording in recordings.items():
        print(f"\n{title}: {audit(recording)}")
    print(f"\nChecked: {chosen.figure(recordings)}.")
    print(f"\nThe film is {_written(path)} ({path.stat().st_size / 1e6:.1f} MB).")
    for video in films[1:]:
        print(
            f"As a video it is {_written(video.path)} ({video.bytes / 1e6:.1f} MB). "
            "Use MP4 or WebP for the web, and GIF where a GIF is needed."
        )
    return 0


def _ahead(chosen: Any, particles: int) -> str:
    """Estimate the time and the memory of a demo with `particles` particles, before it begins.

    The first steps alone underestimate the time: as the flow breaks up, the steps become shorter. A rehearsal with few
    particles measures by which factor the whole run takes longer.
    """
    from physcore.studies.forecast import forecast, rehearsed, words

    def simulation(count: int) -> physcore.Simulation:
        return physcore.Simulation(chosen.scene(count), **chosen.NUMERICS)

    longer = rehearsed(simulation(chosen.PARTICLES), chosen.DURATION) if particles > chosen.PARTICLES else 1.0
    whole = simulation(particles)
    ahead = forecast(whole, chosen.DURATION)
    return (
        f"{len(whole.positions)} particles: {ahead} at the pace of the first ones, and {words(longer * ahead.seconds)} "
        f"at that of a rehearsal; {whole.plan.memory / 1e6:.0f} MB and the recording"
    )


def _live(options: argparse.Namespace) -> int:
    from physcore.panel.scripts import play_script

    script = options.name.endswith(".py")
    if not script and not _exists(options.name):
        return 2
    try:
        panels = play_script(options.name, options.port) if script else [_played(options.name, options.port)]
    except PhyscoreError as error:
        print(f"physcore: {error}", file=sys.stderr)
        return 2
    try:
        for panel in panels:
            panel.wait()
    finally:
        for panel in panels:
            panel.close()
    return 0


def _played(name: str, port: int) -> physcore.Panel:
    """A panel of a demo."""
    from physcore.gallery import demo

    chosen = demo(name)
    method = getattr(chosen, "METHOD", None)  # the method of a fluid demo, where it is not the default
    numerics = getattr(chosen, "NUMERICS", {} if method is None else {"fluids": method})
    return physcore.live(lambda: chosen.scene(), port=port, **numerics)


def _gallery(options: argparse.Namespace) -> int:
    from physcore.gallery import DEMOS, costs
    from physcore.gallery.page import INDEX, gallery

    names = list(dict.fromkeys(options.names)) or list(DEMOS)
    if not all(map(_exists, names)):
        return 2
    known = {name: cost.seconds for name, cost in costs().items()}
    if options.quick:
        slow = [name for name in names if known.get(name, math.inf) > QUICK]
        names = [name for name in names if name not in slow]
        print(f"Left out: {', '.join(slow) or 'nothing'}.")
    # A demo without a measured time counts as an average one.
    weights = {name: known.get(name, sum(known.values()) / max(len(known), 1)) for name in names}
    failed, done, start = [], 0.0, time.monotonic()
    for number, entry in enumerate(gallery(options.output, names, progress=True, jobs=options.jobs), 1):
        done += weights[entry.name]
        left = (time.monotonic() - start) * max(sum(weights.values()) / done - 1.0, 0.0) if done else 0.0
        film = options.output / entry.film
        print(f"{entry.name}: {entry.figure}")
        print(f"  {_written(film)} ({film.stat().st_size / 1e6:.1f} MB)")
        print(f"  {number} of {len(names)} demos; about {_minutes(left)} left", flush=True)
        if not entry.figure.holds:
            failed.append(entry.name)
    print(f"\nThe page is {_written(options.output / INDEX)}.")
    if failed:
        print(f"physcore: the figures of {', '.join(failed)} do not hold", file=sys.stderr)
    return 1 if failed else 0


def _minutes(seconds: float) -> str:
    """A time in seconds, from 100 s on in minutes, as text."""
    return f"{seconds:.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} min"


def _tradeoff(options: argparse.Namespace) -> int:
    from physcore.gallery import caption, demo
    from physcore.storage.files import require_writable
    from physcore.studies.figures import require_plottable

    if not _exists(options.name):
        return 2
    try:
        if options.output is not None:
            require_plottable(options.output)
        if options.json is not None:
            require_writable(options.json)
    except PhyscoreError as error:
        print(f"physcore: {error}", file=sys.stderr)
        return 2
    print(caption(options.name))
    chosen = demo(options.name)
    duration = chosen.DURATION if options.duration is None else options.duration
    method = getattr(chosen, "METHOD", None)  # the method of a fluid demo, where it is not the default
    fluids = None if method is None else [method]
    trade = physcore.tradeoff(chosen.scene(), duration, fluids=fluids, budget=options.budget, progress=True)
    print(f"\n{trade}\n\n{trade.explain()}")
    if options.output is not None:
        trade.plot(options.output)
        print(f"\nThe figure is {_written(options.output)}.")
    if options.json is not None:
        trade.save(options.json)
    return 0


def _written(path: Path) -> str:
    """The absolute path of a file as text; bytes that are not valid text are written as escape sequences."""
    return os.fsencode(path.resolve()).decode(errors="backslashreplace")


def _exists(name: str) -> bool:
    """Whether a demo of this name exists; if not, print the names of all demos."""
    from physcore.gallery import DEMOS

    if name in DEMOS:
        return True
    print(f"physcore: no demo {name!r}; `physcore list` names them{did_you_mean(name, DEMOS)}", file=sys.stderr)
    return False


def _bench(options: argparse.Namespace) -> int:
    from physcore.studies.benchmark import main as bench

    bench()
    return 0


if __name__ == "__main__":
    sys.exit(main())
