"""The documentation site, as far as it is known without building it; `make docs` runs the code of its pages."""

from __future__ import annotations

import inspect
import re
import sys
from collections import Counter
from pathlib import Path

import pytest

import physcore as pc
from physcore.film.styles import STYLES
from physcore.forces import FORCES
from physcore.gallery import DEMOS
from physcore.numerics.integrators import INTEGRATORS

DOCS = Path(__file__).parents[1] / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md"))
FILMS = sorted(path for path in (DOCS / "eighteen").glob("*.md") if path.stem != "index")

sys.path.insert(0, str(DOCS / "extension"))
from docstrings import restructured  # noqa: E402
from notebooks import EXAMPLES, notebook  # noqa: E402
from pages import BLOCK, blocks  # noqa: E402

PARTS = ["The law", "The script", "What was checked", "What to change"]
FEW = 20
"""Most lines of the script of a film, without imports: some ten, and a few more for shapes that are built."""
WIDE = 104
"""Characters of a line of code that are seen on a page without scrolling."""


def text_of(path: Path) -> str:
    """The text of a page."""
    return path.read_text(encoding="utf-8")


def entries(path: Path) -> list[Path]:
    """Pages in the tables of contents of a page."""
    found = re.findall(r"```\{toctree\}\n(?::.*\n)*((?:.+\n)*)```", text_of(path))
    return [path.parent / f"{name}.md" for block in found for name in block.split()]


def test_every_page_is_once_in_a_table_of_contents():
    listed = Counter(entry.resolve() for path in PAGES for entry in entries(path))
    assert set(listed) == {path.resolve() for path in PAGES} - {DOCS / "index.md"}
    assert set(listed.values()) == {1}


def test_the_order_of_the_gallery_is_that_of_the_films():
    """Each page of a film ends with the demos of its law."""
    pages = [text_of(path) for path in entries(DOCS / "eighteen" / "index.md")]
    lines = [
        line
        for page in pages
        for line in re.findall(r"^- In the gallery \(`physcore demo NAME`\):(.*(?:\n  .*)*)", page, re.M)
    ]
    assert [name for line in lines for name in re.findall(r"`(\w+)`", line)] == list(DEMOS)


def test_the_pages_of_the_api_have_every_public_name_once():
    pages = "".join(text_of(path) for path in DOCS.glob("api/*.md"))
    listed = "".join(re.findall(r"```\{api\}\n(.*?)```", pages, re.DOTALL)).split()
    names = [name for name in listed if not name.startswith(":")]
    assert sorted(names) == sorted(pc.__all__)
    linked = re.findall(r"\{py:obj\}`(\w+) <physcore\.(\w+)>`", text_of(DOCS / "api" / "index.md"))
    assert sorted(name for name, _ in linked) == sorted(pc.__all__)
    assert all(name == target for name, target in linked)


def test_docstrings_become_restructured_text():
    lines = restructured(inspect.cleandoc(pc.Drag.__doc__).splitlines())
    text = "\n".join(lines)
    assert ".. code-block:: python\n\n   ball = pc.Particles([[0.0, 0.0]]" in text
    assert r"F = −(b + c \|u\|) u" in text  # In reStructuredText |u| is a substitution.
    assert ":param linear: b [N·s/m], at least zero." in lines
    (wind,) = (line for line in lines if line.startswith(":param wind:"))
    assert "``wind(time)`` returns one velocity." in wind  # from its third line
    assert ":py:obj:`pc.Flow <physcore.Flow>`" in wind
    assert any(line.startswith(":raises SceneError: a coefficient is negative") for line in lines)


def test_there_are_eighteen_films():
    assert len(FILMS) == 18


@pytest.mark.parametrize("path", FILMS, ids=lambda path: path.stem)
def test_a_film_has_its_parts(path):
    text = text_of(path)
    assert re.findall(r"^## (.*)$", text, re.MULTILINE) == PARTS
    _, law, script, check, change = re.split(r"^## .*$", text, flags=re.MULTILINE)
    assert "$$" in law
    (filmed,) = blocks(script)
    lines = [line for line in filmed.splitlines() if line.strip() and not line.startswith("import ")]
    assert len(lines) <= FEW
    assert f"{path.stem}.gif" in filmed
    checks = "\n".join(blocks(check))
    assert "print(" in checks
    assert "assert " in checks
    assert len(re.findall(r"^- ", change, re.MULTILINE)) >= 3


@pytest.mark.parametrize(
    ("page", "kinds"),
    [("styles", STYLES), ("forces", FORCES), ("integrators", INTEGRATORS)],
    ids=["styles", "forces", "integrators"],
)
def test_the_catalog_has_everything_of_a_kind(page, kinds):
    text = text_of(DOCS / "catalog" / f"{page}.md")
    names = {name for heading in re.findall(r"^##+ (.*)$", text, re.MULTILINE) for name in heading.split(", ")}
    assert {kind.__name__ for kind in kinds} <= names
    for kind in kinds:
        assert re.search(rf"\b{kind.__name__}\b", "\n".join(blocks(text))), f"{kind.__name__} has no picture"


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(DOCS)))
def test_code_compiles_and_pictures_have_a_description(path):
    for match in BLOCK.finditer(text_of(path)):
        (code,) = blocks(match[0])
        compile(code, path.name, "exec")
        assert all(len(line) <= WIDE for line in code.splitlines())
        draws = re.search(
            r"pc\.film\(|savefig\(|\.plot\(\"|\.save\(\"\w+\.png|^portrait\(|^ *draw\(", code, re.MULTILINE
        )
        assert bool(draws and "def draw" not in code) == (":alt: " in match[0]), code


def test_scripts_for_download_hide_no_module_of_python():
    """A script is found before the module of this name, also by NumPy."""
    assert not sys.stdlib_module_names & {path.stem for path in PAGES if blocks(text_of(path))}


@pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(DOCS)))
def test_links_between_pages_lead_somewhere(path):
    for target in re.findall(r"\]\(([^)#\s]+)", re.sub(r"```.*?```", "", text_of(path), flags=re.DOTALL)):
        if "://" not in target and "…" not in target:
            assert (path.parent / target).exists(), target


@pytest.mark.parametrize("script", sorted(EXAMPLES.glob("*.py")), ids=lambda script: script.stem)
def test_a_notebook_has_the_code_of_its_script(script):
    pytest.importorskip("nbformat")
    source = script.read_text(encoding="utf-8")
    text, *code = notebook(source)["cells"]
    assert text["cell_type"] == "markdown"
    assert text["source"] in source
    assert "\n\n".join(cell["source"] for cell in code).split() == source.partition('"""\n')[2].split()
