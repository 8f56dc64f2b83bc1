"""Docstrings of this package as reStructuredText.

Examples and formulas are indented blocks, and names stand in single backticks.
"""

from __future__ import annotations

import ast
import re
import textwrap

import physcore

SECTION = re.compile(r"[A-Z][\w ]*:$")
FIELDS = {"Args": "param", "Returns": "returns", "Yields": "returns", "Raises": "raises"}
"""Sections of docstrings that are lists, and the fields of reStructuredText for their entries."""


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
