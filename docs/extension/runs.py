"""Directives for code that runs when the site is built.

`{run}` shows a block of code, what it printed, and the pictures that it wrote.

`{films}` shows a card for each page of a chapter: a frame of its film, and the film itself under the pointer.
"""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import directives
from pages import Page, executed, package
from PIL import Image
from sphinx.addnodes import download_reference
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

logger = logging.getLogger(__name__)
POSTER = 0.7
"""Which part of a film has passed at the frame that stands for it."""


def page_of(directive: SphinxDirective, name: str) -> Page:
    """The executed page of this name."""
    path = Path(directive.env.doc2path(name))
    directive.env.note_dependency(str(path))
    return executed(path, Path(directive.config.runs_folder))


def picture(directive: SphinxDirective, path: Path, alt: str, classes: list[str]) -> nodes.image:
    """A picture of a run."""
    source = Path(directive.env.doc2path(directive.env.docname)).parent
    return nodes.image(uri=os.path.relpath(path, source), alt=alt, loading="lazy", classes=classes)


def download(directive: SphinxDirective, path: Path) -> nodes.Node:
    """A link to download a file."""
    target = os.path.relpath(path, Path(directive.env.doc2path(directive.env.docname)).parent)
    link = download_reference(reftarget=target, refdoc=directive.env.docname, refdomain="", refexplicit=False)
    link += nodes.literal(path.name, path.name)
    return link


class Run(SphinxDirective):
    """A block of code with its results."""

    has_content = True
    option_spec = {"alt": directives.unchanged_required}  # noqa: RUF012

    def run(self) -> list[nodes.Node]:
        """Show code, text and pictures; an exception of the code is an error of the build."""
        number = self.env.temp_data.get("runs", 0)
        self.env.temp_data["runs"] = number + 1
        page = page_of(self, self.env.docname)
        code = "\n".join(self.content)
        shown: list[nodes.Node] = [nodes.literal_block(code, code, language="python")]
        if number >= len(page.outcomes):  # A block before it failed.
            return shown
        outcome = page.outcomes[number]
        if outcome.error:
            logger.error("this code failed:\n%s", outcome.error, location=self.get_location())
        if outcome.text:
            text = outcome.text.rstrip("\n")
            shown.append(nodes.literal_block(text, text, language="text", classes=["printed"]))
        if outcome.pictures and "alt" not in self.options:
            logger.warning("a picture needs its :alt: text", location=self.get_location())
        alt = self.options.get("alt", "")
        shown += [picture(self, page.folder / name, alt, ["run"]) for name in outcome.pictures]
        if number == len(page.outcomes) - 1:
            words = nodes.Text("All code of this page: ")
            shown.append(nodes.paragraph("", "", words, download(self, page.script), classes=["download"]))
        return shown


class Films(SphinxDirective):
    """A card for each page in the table of contents of a page: a frame of its film, and its title."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Show a grid of cards, which link to the pages."""
        grid = nodes.container(classes=["films"])
        for name in contents(Path(self.env.doc2path(self.arguments[0])), self.arguments[0]):
            page = page_of(self, name)
            title = Path(self.env.doc2path(name)).read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
            film = next((page.folder / each for run in page.outcomes for each in run.pictures), None)
            if film is None:
                logger.warning("%s has no film", name, location=self.get_location())
                continue
            link = nodes.reference(refuri=self.env.app.builder.get_relative_uri(self.env.docname, name))
            link += picture(self, poster(film), title, ["poster"])
            link += picture(self, film, "", ["film"])
            link += nodes.inline(title, title)
            card = nodes.container(classes=["card"])
            card += nodes.paragraph("", "", link)
            grid += card
        return [grid]


def contents(path: Path, name: str) -> list[str]:
    """The names of the pages in the table of contents of a page."""
    (entries,) = re.findall(r"```\{toctree\}\n(?::.*\n)*((?:.+\n)*)```", path.read_text(encoding="utf-8"))
    folder = name.rpartition("/")[0]
    return [f"{folder}/{entry}" for entry in entries.split()]


def poster(film: Path) -> Path:
    """One frame of a film, as a PNG beside it."""
    path = film.parent / "posters" / f"{film.stem}.png"
    if not path.exists():
        path.parent.mkdir(exist_ok=True)
        with Image.open(film) as frames:
            frames.seek(int(POSTER * (getattr(frames, "n_frames", 1) - 1)))
            frames.convert("RGB").save(path)
    return path


def state() -> str:
    """A digest of what pages depend on beside their text: the package, and the code of the site."""
    digest = hashlib.sha256(package().encode())
    for path in sorted(Path(__file__).parent.iterdir()):
        digest.update(path.read_bytes() if path.is_file() else b"")
    return digest.hexdigest()


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives."""
    app.add_config_value("runs_state", state(), "env")  # Another value than before reads all pages anew.
    app.add_config_value("runs_folder", "runs", "env")
    app.add_directive("run", Run)
    app.add_directive("films", Films)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
