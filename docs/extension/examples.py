"""The directive `{examples}`: the scripts in `examples`, and their notebooks, which are run, for download."""

from __future__ import annotations

import ast
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import notebooks
from docutils import nodes
from sphinx.addnodes import download_reference
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

logger = logging.getLogger(__name__)


class Examples(SphinxDirective):
    """A section for each script: its code, and links to download the script and its notebook."""

    def run(self) -> list[nodes.Node]:
        """Run what has changed."""
        folder = Path(self.config.runs_folder) / "notebooks"
        here = Path(self.env.doc2path(self.env.docname)).parent
        shown: list[nodes.Node] = []
        for script in sorted(notebooks.EXAMPLES.glob("*.py")):
            self.env.note_dependency(str(script))
            source = script.read_text(encoding="utf-8")
            target = folder / hashlib.sha256(source.encode()).hexdigest()[:16] / f"{script.stem}.ipynb"
            target.parent.mkdir(parents=True, exist_ok=True)
            command = [sys.executable, notebooks.__file__, str(script), str(target)]
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
