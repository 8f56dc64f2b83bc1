"""Configuration of the site, which `make docs` builds into out/docs/site."""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extension"))

project = "physcore"
author = "The physcore developers"
copyright = "the physcore developers, MIT or Apache-2.0"
release = version = metadata.version("physcore")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "api",
    "examples",
    "formulas",
    "runs",
]
root_doc = "index"
exclude_patterns = ["extension"]
html_title = "physcore"
html_math_renderer = "mathml"
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#1f6f8b",
        "color-brand-content": "#1f6f8b",
        "code-font-size": "0.74rem",  # A hundred characters in a line.
    },
    "dark_css_variables": {"color-brand-primary": "#7cc4dc", "color-brand-content": "#7cc4dc"},
}
html_show_sphinx = False
html_copy_source = False
pygments_style = "friendly"
pygments_dark_style = "github-dark"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

nitpicky = True
# Annotations name NumPy's types and aliases of this package, which have no page.
nitpick_ignore_regex = [("py:class", r".*"), ("py:data", r"typing\..*")]
autodoc_member_order = "bysource"
autodoc_typehints = "none"

runs_folder = str(HERE.parent / "out" / "docs" / "runs")


def setup(app: Sphinx) -> None:
    """Tell browsers the language of the pages in Chinese, by which they choose the shapes of characters."""

    def language(app: Sphinx, page: str, template: str, context: dict[str, object], tree: object) -> None:
        if page.startswith("zh/"):
            context["language"] = "zh-Hans"

    app.connect("html-page-context", language)
