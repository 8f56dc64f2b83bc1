"""What the documents show runs, and what they name exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from physcore.studies.diagnosis import SYMPTOMS

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def scripts(name: str) -> list[tuple[str, str]]:
    """Scripts of a document, and what they print."""
    text = (ROOT / "docs" / name).read_text(encoding="utf-8")
    return re.findall(r"```python\n(.*?)```\n\n```text\n(.*?)```", text, flags=re.DOTALL)


TROUBLES = scripts("troubles.md")


def test_the_script_of_the_readme_runs(tmp_path, monkeypatch):
    (script,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    """Its first moments; tests/test_wheel.py runs it whole."""
    monkeypatch.chdir(tmp_path)
    assert "duration=3.0" in script
    exec(compile(script.replace("duration=3.0", "duration=0.2"), "README.md", "exec"), {})
    assert (tmp_path / "cloth.gif").read_bytes().startswith(b"GIF89a")


@pytest.mark.filterwarnings("ignore::physcore.StabilityWarning")
@pytest.mark.filterwarnings("ignore:.* overlaps .* at the start by:physcore.SceneWarning")
@pytest.mark.parametrize(
    ("script", "printed"),
    [
        *TROUBLES,
        *(each for name in ("accuracy", "replace", "rigid", "sweeps", "live") for each in scripts(f"{name}.md")),
    ],
)
def test_scripts_print_what_stands_beneath_them(script, printed, capsys, tmp_path, monkeypatch, clock_of_work):
    monkeypatch.chdir(tmp_path)
    exec(compile(script, "docs", "exec"), {})
    took = re.compile(r"about \d+ (s|minutes|hours)")  # That of a run depends on the machine.
    assert took.sub("about", capsys.readouterr().out) == took.sub("about", printed)


def test_the_table_of_troubles_has_all_symptoms():
    text = (ROOT / "docs" / "troubles.md").read_text(encoding="utf-8")
    printed = {line.partition(":")[0] for _, block in TROUBLES for line in block.splitlines() if line[0] != " "}
    assert len(TROUBLES) == len(SYMPTOMS) + 1  # Two ways to penetrate.
    for symptom in printed - {"nothing wrong was found"}:
        assert symptom in text.partition("## ")[0]
    for heading in re.findall(r"\]\(#([a-z-]+)\)", text):
        assert f"\n## {heading.replace('-', ' ').capitalize()}\n" in text


@pytest.mark.parametrize("name", ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"])
def test_links_into_the_project_lead_somewhere(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)", text):
        if "://" not in target:
            assert (ROOT / target).exists(), f"{name} links to {target}"


@pytest.mark.parametrize("name", ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"])
def test_every_make_target_that_is_named_exists(name):
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"\bmake ([a-z-]+)", (ROOT / name).read_text(encoding="utf-8")):
        assert f"\n{target}:" in makefile, f"{name} names `make {target}`"
