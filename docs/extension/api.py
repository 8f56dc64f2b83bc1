"""The directive `{api}`: the pages of public names, from their docstrings.

A block lists names of `physcore`, one a line. With `:members:`, classes show their methods and properties.
"""

from __future__ import annotations

import inspect

from docstrings import restructured
from docutils import nodes
from docutils.parsers.rst import directives
from myst_parser.mdit_to_docutils.base import make_document
from myst_parser.mocking import MockRSTParser
from sphinx.addnodes import literal_strong, pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective

import physcore


class Api(SphinxDirective):
    """Documentation of public names."""

    has_content = True
    option_spec = {"members": directives.flag}  # noqa: RUF012

    def run(self) -> list[nodes.Node]:
        """Hand each name to autodoc."""
        lines: list[str] = []
        for name in self.content:
            kind = self._kind(name)
            lines += [f".. auto{kind}:: physcore.{name}"]
            if kind == "class" and "members" in self.options:
                lines += ["   :members:", "   :inherited-members: Exception, tuple"]
            elif kind == "module":
                lines += ["   :members:"]
            lines += [""]
        return parsed(self, lines)

    @staticmethod
    def _kind(name: str) -> str:
        """Which directive of autodoc documents a name."""
        value = getattr(physcore, name)
        if inspect.ismodule(value):
            return "module"
        if isinstance(value, type):
            return "exception" if issubclass(value, BaseException) else "class"
        return "function" if callable(value) else "data"


def parsed(directive: SphinxDirective, lines: list[str]) -> list[nodes.Node]:
    """Nodes of reStructuredText within a page of Markdown, as the directive `eval-rst` of MyST gives them."""
    document = make_document()
    document["source"] = directive.env.doc2path(directive.env.docname)
    document.settings = directive.state.document.settings
    document.reporter = directive.state.document.reporter
    MockRSTParser().parse("\n".join(lines), document)
    for names in document.findall(literal_strong):  # of several arguments; see `docstrings`
        text = names.astext().replace(",", ", ")
        names.clear()
        names += nodes.Text(text)
    return document.children


def written(app: Sphinx, what: str, name: str, value: object, options: object, lines: list[str]) -> None:
    """Rewrite the lines of a docstring in place, as reStructuredText."""
    lines[:] = restructured(lines)


def resolve(app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.Element) -> nodes.Node | None:
    """Lead a reference to where a name is defined to where it is documented, in `physcore`."""
    name = node.get("reftarget", "").rpartition(".")[2]
    if node.get("refdomain") != "py" or name not in physcore.__all__:
        return None
    domain = env.domains["py"]
    return domain.resolve_xref(env, node["refdoc"], app.builder, "obj", f"physcore.{name}", node, content)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("api", Api)
    app.connect("autodoc-process-docstring", written)
    app.connect("missing-reference", resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
