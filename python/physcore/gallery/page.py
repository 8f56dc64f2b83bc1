"""HTML page of all demos: the films, their captions, their checks and their numerics, to be opened from disk."""

from __future__ import annotations

import inspect
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from pathlib import Path
from time import process_time
from types import ModuleType
from typing import cast

import physcore
from physcore.checks import count, file_path
from physcore.errors import FileError
from physcore.gallery import COSTS, Cost, caption, costs, demo
from physcore.gallery.figure import Figure
from physcore.simulation.recording import Recording
from physcore.storage.files import replacing, require_writable
from physcore.storage.pictures import opened

INDEX = "index.html"
"""Name of the page's file."""
WIDE = 1.8
"""Aspect ratio from which on a film takes two columns, if there are two."""


@dataclass(frozen=True)
class Entry:
    """Entry of one demo on the page."""

    name: str
    caption: str
    film: str
    """Name of the film's file, beside the page."""
    size: tuple[int, int]
    """Width and height of the film [pixels]."""
    figure: Figure
    numerics: tuple[str, ...]
    """Numerics of each recording, and the drift of its energy."""
    source: str
    """Source code of the demo."""
    cost: Cost

    @property
    def title(self) -> str:
        """The title: the name with spaces and a capital letter."""
        return self.name.replace("_", " ").capitalize().replace("3d", "3D")


def gallery(
    directory: str | os.PathLike[str], names: Sequence[str], progress: bool | None = None, *, jobs: int = 1
) -> Iterator[Entry]:
    """Run demos, write their films and a page that shows them, and yield each entry when its film is complete.

    Files appear under their names when they are complete. After each film, the page is written with all films so far,
    and their costs are written to costs.json.

    Args:
        directory: the output directory; it is created if necessary.
        names: names of the demos, in the order of the page.
        progress: whether to show progress bars; with several jobs there are none.
        jobs: number of demos run at once, each in its own process and with its share of the threads. The most expensive
            ones are started first.

    Raises:
        SceneError: `jobs` is not a whole number above zero.
        FileError: a file cannot be written.
        KeyError: there is no such demo.
    """
    folder, chosen = file_path(directory, "directory"), {name: demo(name) for name in names}
    at_once = min(count(jobs, "jobs", least=1), max(len(chosen), 1))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{folder}: cannot be made a folder: {error.strerror or error}") from error
    for name in (INDEX, COSTS, *(f"{name}.gif" for name in chosen)):
        require_writable(folder / name)
    entries: dict[str, Entry] = {}
    made = (_entry(name, folder, progress) for name in chosen) if at_once == 1 else _shared(chosen, folder, at_once)
    for entry in made:
        entries[entry.name] = entry
        ready = [entries[name] for name in chosen if name in entries]
        for name, text in ((INDEX, page(ready)), (COSTS, _cost_table(ready))):
            with replacing(folder / name) as file:
                file.write(text.encode())
        yield entry


def _shared(names: Iterable[str], folder: Path, jobs: int) -> Iterator[Entry]:
    """The entries of demos that run in several processes, in order of completion."""
    from concurrent.futures import ProcessPoolExecutor, as_completed
    from multiprocessing import get_context

    known, threads = costs(), max((os.cpu_count() or 1) // jobs, 1)
    order = sorted(names, key=lambda name: known[name].seconds if name in known else math.inf, reverse=True)
    with ProcessPoolExecutor(jobs, get_context("spawn"), _limit_threads, (threads,)) as workers:
        running = [workers.submit(_entry, name, folder, False) for name in order]
        try:
            for done in as_completed(running):
                yield done.result()
        finally:
            workers.shutdown(wait=False, cancel_futures=True)


def _limit_threads(threads: int) -> None:
    """Set the number of threads of this process."""
    os.environ["PHYSCORE_NUM_THREADS"] = str(threads)


def _entry(name: str, folder: Path, progress: bool | None) -> Entry:
    """Run a demo and write its film."""
    shown, film, start = demo(name), f"{name}.gif", process_time()
    recordings = shown.main(folder / film, progress)
    seconds = process_time() - start
    source, numerics = inspect.getsource(cast(ModuleType, shown)), tuple(_numerics(recordings))
    cost = Cost(round(seconds, 1), (folder / film).stat().st_size)
    return Entry(name, caption(name), film, _size(folder / film), shown.figure(recordings), numerics, source, cost)


def _cost_table(entries: Sequence[Entry]) -> str:
    """The costs of the demos as JSON, one line for each."""
    lines = (f'  "{entry.name}": {json.dumps(vars(entry.cost))}' for entry in entries)
    return "{\n" + ",\n".join(lines) + "\n}\n"


def page(entries: Sequence[Entry]) -> str:
    """The page in HTML: one file without scripts and external content."""
    failed = sum(not entry.figure.holds for entry in entries)
    verdict = f"{failed} of {len(entries)} figures do not hold" if failed else "every figure holds"
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>physcore: gallery</title>
<style>
{_style()}</style>
</head>
<body>
<header>
<h1>physcore</h1>
<p>Demos of version {escape(physcore.__version__)}. Each is one short script and measures something whose value is
known: <strong class="{"failed" if failed else "holds"}">{verdict}</strong>.</p>
</header>
<main>
{"".join(map(_article, entries))}</main>
</body>
</html>
"""


def _article(entry: Entry) -> str:
    """The HTML of one demo."""
    width, height = entry.size
    wide = ' class="wide"' if width >= WIDE * height else ""
    mark, word = ("holds", "✓") if entry.figure.holds else ("failed", "✗ does not hold:")
    figure = escape(str(entry.figure)).replace(" %", "&nbsp;%")
    numerics = "".join(f"<li>{escape(line)}</li>\n" for line in entry.numerics)
    return f"""<article id="{escape(entry.name)}"{wide}>
<img src="{escape(entry.film)}" width="{width}" height="{height}" loading="lazy" alt="{escape(entry.caption)}">
<h2>{escape(entry.title)}</h2>
<p>{escape(entry.caption)}</p>
<p class="{mark}">{word} {figure}</p>
<ul>
{numerics}</ul>
<details>
<summary>Source</summary>
<pre><code>{escape(entry.source)}</code></pre>
</details>
</article>
"""


def _numerics(recordings: Mapping[str, Recording]) -> Iterator[str]:
    """The numerics of each recording, as one line of text."""
    for title, recording in recordings.items():
        plan, number, drift = recording.plan, recording.scene.particles, float(abs(recording.energy.drift).max())
        yield (
            f"{title}: {number} particle{'s' * (number > 1)} in {plan.dimension}D, "
            f"{plan.integrator}, dt = {plan.dt:.3g} s, {plan.precision}; energy drift at most {drift:.1e}"
        )


def _style() -> str:
    return files("physcore.gallery").joinpath("page.css").read_text(encoding="utf-8")


def _size(film: Path) -> tuple[int, int]:
    with opened(film) as image:
        return image.size
