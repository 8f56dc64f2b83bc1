"""Configuration of the site, which `make docs` builds into out/docs/site."""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "extension"))

project = "physcore"
author = "The physcore developers"
copyright = "the physcore developers, MIT or Apache-2.0"  # noqa: A001
release = version = metadata.version("physcore")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "api",
    "formulas",
    "notebooks",
    "runs",
]
root_doc = "index"
exclude_patterns = ["extension"]
html_title = "physcore"
html_math_renderer = "mathml"
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
pygments_style = "friendly"
pygments_dark_style = "github-dark"

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

nitpicky = True
# Annotations name NumPy's types and aliases of this package, which have no page.
nitpick_ignore_regex = [("py:class", r".*"), ("py:data", r"typing\..*")]
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_custom_sections = [("Sources", "notes_style"), ("Source", "notes_style")]

runs_folder = str(HERE.parent / "out" / "docs" / "runs")
