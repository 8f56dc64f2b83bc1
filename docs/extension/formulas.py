"""Formulas as MathML, which browsers draw themselves: no script, nothing fetched from elsewhere."""

from __future__ import annotations

import shutil
from importlib.resources import files
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator


def inline(translator: HTML5Translator, node: nodes.math) -> None:
    """Write a formula within a line."""
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def block(translator: HTML5Translator, node: nodes.math_block) -> None:
    """Write a formula in lines of its own."""
    translator.body.append(f'<div class="formula">{convert(node.astext(), display="block")}</div>\n')
    raise nodes.SkipNode


def copy_font(app: Sphinx, error: Exception | None) -> None:
    """Copy the face STIX Two Math (OFL), for browsers on machines that have no mathematical one."""
    if error is None:
        font = files("ziamath") / "fonts" / "STIXTwoMath-Regular.ttf"
        shutil.copy(str(font), Path(app.outdir) / "_static")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer."""
    app.connect("build-finished", copy_font)
    app.add_html_math_renderer("mathml", inline_renderers=(inline, None), block_renderers=(block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
