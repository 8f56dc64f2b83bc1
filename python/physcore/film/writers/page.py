"""Writer of pages: one file of HTML that plays the film in a browser, offline."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from physcore.errors import SceneWarning, warn
from physcore.film.page.packing import BITS, Pack
from physcore.film.page.tape import Tape
from physcore.film.page.track import Track
from physcore.film.writers.base import Film, FilmJob, Writer
from physcore.film.writers.budget import FARTHEST, FEWEST, Cut
from physcore.film.writers.gif import GifWriter
from physcore.progress import Progress
from physcore.simulation.energy import Energy
from physcore.storage.files import replacing

FITS = 5_000_000
"""Size of a page that its coordinates are rounded for, if no other is asked for [bytes]."""
SMALL = 240
"""Longest side of the GIF that is shown without WebGL [pixels]."""
FEW = (16, 8, 4)
"""Largest numbers of frames of that GIF, the first with which it fits."""
LIGHT = 300_000
"""Size that it should have [bytes]."""
POINTS = 600
"""Largest number of points of the curve of energy."""
PARTS = ("page.html", "page.css", "vectors.js", "shaders.js", "packing.js", "drawing.js", "liquids.js", "player.js")
"""The template of a page, and what is put into it: nothing else is loaded."""
MARK = re.compile(r"@\{([a-z.]+)\}")
"""A place of the template."""
RECORD = re.compile(r'<script type="application/json" id="provenance">(.*?)</script>', re.DOTALL)
"""The provenance record of a page."""


class PageWriter(Writer):
    """Page with all shapes of the film, which the browser draws."""

    suffixes: ClassVar = (".html",)
    name: ClassVar = "a page"
    captioned: ClassVar = False
    blends: ClassVar = False

    def write(self, job: FilmJob, target: Path) -> Film:
        """Write a page: all shapes are kept, and rounded so that they fit into the allowed bytes, if possible."""
        renderer, size = job.renderer, job.renderer.size
        tape, lines, energies = _recorded(job)
        facts = _facts(job, tape, lines, energies)
        gif = _fallback(job)
        heading, (_, _, (figure, credit)) = renderer.heading, renderer.parts
        title = heading.title
        texts = {
            "title": escape(title or "physcore"),
            "heading": escape(title),
            "subtitle": escape(heading.subtitle),
            "formula": escape(heading.formula),
            "figure": escape(figure),
            "credit": escape(credit),
            "provenance": _safe(job.provenance),
            "gif": base64.b64encode(gif).decode(),
            "width": str(size[0]),
            "height": str(size[1]),
        }
        for bits in BITS:
            page = _page(texts | {"film": base64.b64encode(packed(tape, facts, bits)).decode()})
            if len(page) <= (job.max_bytes or FITS):
                break
        with replacing(target) as file:
            file.write(page)
        film = Film(target, len(page), size, renderer.count, job.rate)
        if job.max_bytes is None and film.bytes > FITS:
            warn(
                f"{film}: pages above 5 MB open slowly, and coordinates are rounded to {bits} bits already; give it "
                "fewer frames per second or fewer particles, or write an .mp4",
                SceneWarning,
            )
        return film

    @staticmethod
    def provenance(path: Path) -> str | None:
        """The provenance record in a page."""
        found = RECORD.search(path.read_text("utf-8"))
        return None if found is None else found[1]


def packed(tape: Tape, facts: dict[str, Any], bits: int) -> bytes:
    """The film as a raw stream of deflate: the length of its description, this as JSON, and the packed arrays."""
    pack = Pack(bits)
    tracks = [_track(pack, track, tape.count) for track in tape.tracks]
    head = json.dumps(facts | {"tracks": tracks}, separators=(",", ":"), allow_nan=False).encode()
    head += b" " * (-len(head) % 4)
    return pack.deflated(len(head).to_bytes(4, "little") + head)


def _recorded(job: FilmJob) -> tuple[Tape, list[str], list[list[Energy | None]]]:
    """The tape of a film, with the labels and the energies of each frame."""
    tape, lines, energies = Tape(), list[str](), list[list[Energy | None]]()
    with Progress(job.renderer.count, "recording", job.progress) as bar:
        for index, (line, each) in enumerate(job.renderer.record(tape)):
            lines.append(line)
            energies.append(each)
            bar.update(index + 1)
    return tape, lines, energies


def _facts(job: FilmJob, tape: Tape, lines: list[str], energies: list[list[Energy | None]]) -> dict[str, Any]:
    """All of a film but its tracks."""
    renderer = job.renderer
    bars, legend, _ = renderer.parts
    return {
        "size": renderer.size,
        "count": tape.count,
        "rate": job.rate,
        "hold": job.repeat.hold,
        "bounce": job.repeat.loop == "bounce",
        "lines": _once(lines),
        "texts": _once(tape.texts),
        "eyes": {panel: _once(eyes) for panel, eyes in tape.eyes.items()},
        "bars": [
            [bar.name, bar.low, bar.high, np.round(bar.table[:: max(1, len(bar.table) // 16)]).astype(int).tolist()]
            for bar in bars
        ],
        "legend": legend,
        "names": renderer.heading.titles,
        "energy": _curves(energies),
        **renderer.space,
    }


def _curves(energies: list[list[Energy | None]]) -> list[dict[str, Any]]:
    """The energies of each panel at some of the frames; none if they are not known, or not finite."""
    if any(each is None for frame in energies for each in frame) or len({len(frame) for frame in energies}) != 1:
        return []
    some = np.unique(np.linspace(0, len(energies) - 1, min(len(energies), POINTS)).round().astype(int)).tolist()
    curves = []
    for panel in range(len(energies[0])):
        known = [each for index in some if (each := energies[index][panel]) is not None]
        rows = {name: [float(f"{getattr(each, name):.6g}") for each in known]
                for name in ("kinetic", "potential", "internal", "total")}  # fmt: skip
        if not np.isfinite(list(rows.values())).all():
            return []
        curves.append({"frames": some, "unit": known[0].units.symbol("J"), **rows})
    # Tracers and reactions have none.
    return curves if any(any(curve["total"]) or any(curve["kinetic"]) for curve in curves) else []


def _track(pack: Pack, track: Track, count: int) -> dict[str, Any]:
    """The description of a track, whose arrays are added to a pack."""
    fixed = {name: pack.still(value) if isinstance(value, np.ndarray) else value for name, value in track.fixed.items()}
    names = next(iter(track.frames.values())) if track.frames else {}
    frames = [track.frames.get(index) for index in range(1 if track.still else count)]
    dimension = 3 if track.deep else 2
    streams = {
        name: pack.moving(
            name, [None if each is None else each[name] for each in frames], dimension if name == "places" else 0
        )
        for name in names
    }
    return {
        "kind": track.kind, "panel": track.panel, "deep": track.deep, "still": track.still, **fixed,
        "streams": streams,
    }  # fmt: skip


def _fallback(job: FilmJob) -> bytes:
    """The film as a small GIF of few frames, drawn by the renderer."""
    width, height = job.renderer.size
    scale = min(1.0, SMALL / max(width, height))
    job.renderer.resize((max(16, 2 * round(scale * width / 2)), max(16, 2 * round(scale * height / 2))))
    for few in FEW:
        stride = -(-job.renderer.count // few)
        rate = min(job.rate, GifWriter.fastest * stride)
        cut = Cut(stride=stride, colors=FEWEST, tolerance=FARTHEST)
        content = GifWriter.content(replace(job, rate=rate, max_bytes=None, progress=False), cut)
        if len(content) <= LIGHT:
            break
    return content


def _page(texts: dict[str, str]) -> bytes:
    """The template with everything in its places."""
    parts = {name: (files("physcore.film.page") / name).read_text("utf-8") for name in PARTS}
    everything = parts | texts
    return MARK.sub(lambda place: everything[place[1]], parts[PARTS[0]]).encode()


def _safe(text: str) -> str:
    """JSON that no browser takes for the end of a script."""
    return text.replace("<", "\\u003c")


def _once(values: list[Any]) -> list[Any]:
    """A list with one entry for each frame; if all are equal, the first one alone."""
    return values[:1] if all(each == values[0] for each in values) else values
