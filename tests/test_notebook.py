"""In a notebook: previews, tables and a progress bar, as a kernel sends them."""

from __future__ import annotations

from typing import Any

import pytest

import physcore as pc
from physcore.film import notebook

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")

CELLS = (
    "import physcore as pc\n"
    "rope = pc.rope(10, 1.0, stiffness=100.0, mass=0.01, pinned='start', direction=(1.0, 0.0))\n"
    "recording = pc.simulate(pc.Scene(rope, pc.Gravity()), duration=1.0, progress=True)\n",
    "recording",
    "recording.plan",
    "recording.energy",
    "pc.film(recording, path, size=(160, 120))",
    "recording.show()",
    "print(repr(pc.tradeoff(recording.scene, 0.05, budget=0.5)._repr_html_()[:7]))",
    "panel = pc.live(lambda: recording.scene)\npanel.close()",
)


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory) -> list[list[Any]]:
    """What each cell shows."""
    path = tmp_path_factory.mktemp("notebook") / "film.gif"
    notebook = nbformat.v4.new_notebook()
    notebook.cells = [nbformat.v4.new_code_cell(f"path = {str(path)!r}"), *map(nbformat.v4.new_code_cell, CELLS)]
    nbclient.NotebookClient(notebook, timeout=3600, kernel_name="python3").execute()
    return [cell.outputs for cell in notebook.cells[1:]]


def test_a_progress_bar_is_drawn_in_one_line(outputs: list[list[Any]]) -> None:
    text = "".join(output.text for output in outputs[0] if output.output_type == "stream")
    assert text.startswith("\rsimulating")
    assert "100%" in text
    assert text.count("\n") == 1
    assert " left" in text


@pytest.mark.parametrize(("cell", "expected"), [(1, "<img"), (2, "<table>"), (3, "kinetic"), (4, "<img"), (5, "<img")])
def test_results_are_shown_as_html(outputs: list[list[Any]], cell: int, expected: str) -> None:
    (result,) = (output for output in outputs[cell] if output.output_type == "execute_result")
    assert expected in result.data["text/html"]
    assert len(result.data["text/html"]) < 2_800_000


@pytest.mark.parametrize("cell", [1, 4, 5])
def test_a_film_is_stored_once(outputs: list[list[Any]], cell: int) -> None:
    (result,) = (output for output in outputs[cell] if output.output_type == "execute_result")
    assert str(result.data).count("base64,") == 1
    assert len(result.data["text/plain"]) < 200


def test_a_film_that_is_shown_twice_is_drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []

    def draw(recording: pc.Recording, **options: object) -> bytes:
        drawn.append(recording)
        return b"GIF89a"

    monkeypatch.setattr(notebook, "gif_bytes", draw)
    one, other = (pc.simulate(pc.Scene(pc.Particles([[0.0, 0.0]])), 0.1) for _ in range(2))
    for recording in (one, one, other):
        assert recording.show()._repr_html_().count("base64,") == 1
    assert drawn == [one, other]


def test_a_trade_is_a_table(outputs: list[list[Any]]) -> None:
    assert "<table>" in "".join(output.get("text", "") for output in outputs[6])


def test_a_live_panel_is_a_widget(outputs: list[list[Any]]) -> None:
    pytest.importorskip("anywidget", reason="the extra physcore[live] is not installed")
    (shown,) = outputs[7]
    assert shown.output_type == "display_data"
    assert "application/vnd.jupyter.widget-view+json" in shown.data
