"""The directive `{api}`: the pages of public names, from their docstrings.

A block lists names of `physcore`, one a line. With `:members:`, classes show their methods and properties. Docstrings
of this package have examples as indented blocks, and names in single backticks; both are rewritten as reStructuredText.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap

from docutils import nodes
from docutils.parsers.rst import directives
from myst_parser.mdit_to_docutils.base import make_document
from myst_parser.mocking import MockRSTParser
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective

import physcore

SECTION = re.compile(r"[A-Z][\w ]*:$")
FIELDS = {"Args": "param", "Returns": "returns", "Yields": "returns", "Raises": "raises"}
"""Sections of docstrings that are lists, and the fields of reStructuredText for their entries."""


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
    return document.children


def written(app: Sphinx, what: str, name: str, value: object, options: object, lines: list[str]) -> None:
    """Rewrite the lines of a docstring in place, as reStructuredText."""
    lines[:] = restructured(lines)


def restructured(lines: list[str]) -> list[str]:
    """A docstring of this package as reStructuredText: blocks of code, fields of arguments, links to public names."""
    result: list[str] = []
    rest = [*lines, ""]
    while rest:
        line = rest.pop(0)
        if SECTION.match(line):
            result += _section(line.rstrip(":"), textwrap.dedent("\n".join(_indented(rest))))
        elif line.startswith("    "):
            code = textwrap.dedent("\n".join([line, *_indented(rest)])).strip("\n")
            result += [f".. code-block:: {_language(code)}", "", textwrap.indent(code, "   "), ""]
        else:
            result.append(_prose(line))
    return "\n".join(result).splitlines()


def _indented(rest: list[str]) -> list[str]:
    """Take the lines of an indented block from the beginning of a list."""
    end = next((k for k, line in enumerate(rest) if line.strip() and not line.startswith(" ")), len(rest))
    taken, rest[:end] = rest[:end], []
    return taken


def _section(title: str, text: str) -> list[str]:
    """A section of a docstring: its entries as fields, or its text under a title."""
    field = FIELDS.get(title)
    if field is None:
        return [f"**{title}**", "", *restructured(text.splitlines()), ""]
    entries: list[str] = []
    for line in text.splitlines():
        if line.startswith(" ") or not line:
            entries[-1:] = [f"{' '.join(entries[-1:])} {line.strip()}".rstrip()]
        else:
            entries.append(line)
    fields = []
    for entry in entries:
        name, colon, words = entry.partition(": ")
        name = name.replace(", ", ",")  # Before a space, Sphinx would read a type.
        plain = field.endswith("returns") or not colon
        fields.append(f":{field}: {_prose(entry)}" if plain else f":{field} {name}: {_prose(words)}")
    return ["", *fields, ""]


def _language(code: str) -> str:
    """Which language a block is in: Python, or a formula."""
    try:
        ast.parse(code)
    except SyntaxError:
        return "text"
    return "python"


def _prose(line: str) -> str:
    """A line of text: code and links marked, and signs that reStructuredText has a meaning for escaped."""
    parts = re.split(r"(`[^`]+`)", line)
    return "".join(_marked(part) if part.startswith("`") else re.sub(r"([|*_`\\])", r"\\\1", part) for part in parts)


def _marked(code: str) -> str:
    """A link to a public name, or code. Without `pc.`, a name in small letters may be one of the example."""
    text = code.strip("`")
    name = text.removeprefix("pc.").removeprefix("physcore.")
    public = name in physcore.__all__ and (name != text or not name.islower())
    return f":py:obj:`{text} <physcore.{name}>`" if public else f"``{text}``"


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
