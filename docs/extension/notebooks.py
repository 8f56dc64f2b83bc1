"""Notebooks of the scripts in `examples`, run and offered for download on the page that lists them.

    python notebooks.py SCRIPT NOTEBOOK     write a script as a notebook, and run it
"""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys
from pathlib import Path

from docutils import nodes
from sphinx.addnodes import download_reference
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

logger = logging.getLogger(__name__)
EXAMPLES = Path(__file__).parents[2] / "examples"
LONGEST = 600
"""Time after which a notebook has failed [s]."""


def notebook(source: str) -> dict:
    """A script as a notebook: its docstring as text, and a cell of code for each part between empty lines."""
    from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

    tree = ast.parse(source)
    text = ast.get_docstring(tree) or ""
    code = "\n".join(source.splitlines()[tree.body[0].end_lineno if text else 0 :])
    cells = [part.strip("\n") for part in code.split("\n\n") if part.strip()]
    result = new_notebook(cells=[new_markdown_cell(text), *map(new_code_cell, cells)])
    for number, cell in enumerate(result.cells):  # Random by default.
        cell["id"] = f"cell-{number}"
    return result


def write(script: Path, path: Path) -> None:
    """Run the notebook of a script in the folder of `path`, and write it there with what it shows."""
    import nbformat
    from nbclient import NotebookClient

    found = notebook(script.read_text(encoding="utf-8"))
    NotebookClient(found, timeout=LONGEST, resources={"metadata": {"path": str(path.parent)}}).execute()
    nbformat.write(found, path)


class Examples(SphinxDirective):
    """A section for each script: its code, and links to download the script and its notebook."""

    def run(self) -> list[nodes.Node]:
        """Run what has changed."""
        folder = Path(self.config.runs_folder) / "notebooks"
        here = Path(self.env.doc2path(self.env.docname)).parent
        shown: list[nodes.Node] = []
        for script in sorted(EXAMPLES.glob("*.py")):
            self.env.note_dependency(str(script))
            source = script.read_text(encoding="utf-8")
            target = folder / hashlib.sha256(source.encode()).hexdigest()[:16] / f"{script.stem}.ipynb"
            target.parent.mkdir(parents=True, exist_ok=True)
            command = [sys.executable, __file__, str(script), str(target)]
            if not target.exists() and subprocess.run(command, check=False).returncode:
                logger.error("%s failed as a notebook", script.name, location=self.get_location())
                continue
            title = ast.get_docstring(ast.parse(source)) or script.stem
            section = nodes.section(ids=[script.stem], names=[script.stem])
            section += nodes.title(title, title.partition("\n")[0].rstrip("."))
            code = source.partition('"""\n\n')[2]
            section += nodes.literal_block(code, code, language="python")
            links = nodes.paragraph()
            for path in (script, target):
                relative = os.path.relpath(path, here)
                link = download_reference(reftarget=relative, refdoc=self.env.docname, refdomain="", refexplicit=False)
                link += nodes.literal(path.name, path.name)
                links += [link, nodes.Text(" ")]
            section += links
            shown.append(section)
        return shown


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("examples", Examples)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    write(Path(sys.argv[1]), Path(sys.argv[2]))
