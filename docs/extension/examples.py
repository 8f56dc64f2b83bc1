"""The directive `{examples}`: the scripts in `examples`, and their notebooks, which are run, for download."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import notebooks
from docutils import nodes
from pages import package
from runs import download
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

logger = logging.getLogger(__name__)


class Examples(SphinxDirective):
    """A section for each script: its code, what its notebook printed, and both for download."""

    def run(self) -> list[nodes.Node]:
        """Run what has changed."""
        return [self._section(script) for script in sorted(notebooks.EXAMPLES.glob("*.py"))]

    def _section(self, script: Path) -> nodes.section:
        """The section of a script. A notebook that fails is an error of the build."""
        self.env.note_dependency(str(script))
        source = script.read_text(encoding="utf-8")
        notebook = self._notebook(script, source)
        title = notebooks.title(source)
        section = nodes.section("", nodes.title(title, title), ids=[script.stem], names=[script.stem])
        code = source.partition('"""\n\n')[2]
        section += nodes.literal_block(code, code, language="python")
        if notebook.exists():
            text = notebooks.printed(notebook)
            section += [nodes.literal_block(text, text, language="text", classes=["printed"])] if text else []
            section += nodes.paragraph("", "", download(self, script), nodes.Text(" "), download(self, notebook))
        return section

    def _notebook(self, script: Path, source: str) -> Path:
        """The notebook of a script, which is run unless this has been done with the same package."""
        key = hashlib.sha256(f"{source}{package()}".encode()).hexdigest()[:16]
        path = Path(self.config.runs_folder) / f"notebook-{key}" / f"{script.stem}.ipynb"
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            command = [sys.executable, notebooks.__file__, str(script), str(path)]
            finished = subprocess.run(command, capture_output=True, text=True, check=False)
            if finished.returncode:
                logger.error("%s failed:\n%s", script.name, finished.stderr, location=self.get_location())
        return path


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("examples", Examples)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
