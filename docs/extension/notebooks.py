"""Notebooks of the scripts in `examples`: `python notebooks.py SCRIPT NOTEBOOK` writes one and runs it."""

from __future__ import annotations

import ast
import json
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "examples"
LONGEST = 600
"""Time after which a notebook has failed [s]."""


def title(source: str) -> str:
    """The first line of a script's docstring."""
    return (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0].rstrip(".")


def printed(path: Path) -> str:
    """Text that the cells of a notebook printed, without progress bars, which go to standard error."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", ()) if output.get("name") == "stdout"]
    return "".join("".join(output["text"]) for output in outputs).rstrip("\n")


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


if __name__ == "__main__":
    write(Path(sys.argv[1]), Path(sys.argv[2]))
