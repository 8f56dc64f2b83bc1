"""The command line: what it prints, what it writes, and how it fails."""

from __future__ import annotations

import subprocess
import sys

import pytest

from physcore.__main__ import main
from physcore.film import evidence
from physcore.film.writers import WRITERS
from physcore.gallery import DEMOS, caption, demo
from physcore.progress import Progress


def test_list_names_every_demo_with_its_caption(capsys):
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(DEMOS)
    assert all(caption(name) in line for name, line in zip(DEMOS, lines, strict=True))


@pytest.mark.parametrize("name", DEMOS)
def test_every_demo_says_what_it_shows_and_what_is_checked(name):
    text = demo(name).__doc__
    assert text is not None
    assert caption(name).endswith(".")
    assert "The physics checked:" in text


def test_a_demo_writes_its_gif_shows_progress_and_prints_the_audit(capsys, tmp_path):
    path = tmp_path / "rope.gif"
    assert main(["demo", "rope", "-o", str(path)]) == 0
    output = capsys.readouterr()
    assert path.read_bytes().startswith(b"GIF89a")
    assert str(path) in output.out
    for word in ("kinetic", "dissipated", "work", "drift", "momentum"):
        assert word in output.out
    assert "100 %" in output.err


@pytest.mark.parametrize("kind", WRITERS)
def test_a_demo_is_filmed_in_any_format(kind, capsys, tmp_path):
    path = tmp_path / f"rope{kind.suffixes[0]}"
    assert main(["demo", "rope", "-o", str(path)]) == 0
    (panel,) = evidence(path)
    assert panel["scene"] == demo("rope").scene().hash()
    assert str(path) in capsys.readouterr().out


def test_bad_input_is_one_line_and_an_exit_code(capsys, tmp_path):
    assert main(["demo", "no-such-demo"]) == 2
    assert main(["demo", "rope", "-o", str(tmp_path / "missing" / "rope.gif")]) == 2
    assert main(["demo", "rope", "-o", str(tmp_path / "rope.avi")]) == 2
    output = capsys.readouterr()
    assert output.out == ""  # nothing was simulated
    error = output.err.splitlines()
    assert error[0].startswith("physcore: no demo 'no-such-demo'; there are")
    assert "no such folder" in error[1]
    assert error[2].startswith("physcore: path: must end in .gif, .webp, .apng, .mp4 or .png")
    assert len(error) == 3
    with pytest.raises(SystemExit) as stopped:
        main(["dance"])
    assert stopped.value.code == 2


def test_ctrl_c_ends_a_demo_without_a_traceback(capsys, monkeypatch):
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("physcore.gallery.demo", interrupted)
    assert main(["demo", "rope"]) == 130
    assert capsys.readouterr().err == "physcore: interrupted\n"


def test_the_module_runs_as_a_command():
    done = subprocess.run([sys.executable, "-m", "physcore", "list"], capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert "cloth" in done.stdout


def test_progress_prints_a_line_for_each_quarter_where_there_is_no_terminal(capsys):
    with Progress(1000, "working", show=True) as bar:
        for done in range(1001):
            bar.update(done)
    assert capsys.readouterr().err.splitlines() == [f"working: {percent} %" for percent in (0, 25, 50, 75, 100)]


def test_progress_is_silent_where_nobody_asked(capsys):
    for show in (None, False):
        with Progress(2, "working", show) as bar:
            bar.update(2)
    assert capsys.readouterr().err == ""


def test_progress_draws_over_itself_on_a_terminal(capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with Progress(2, "working", show=True) as bar:
        bar.update(1)
        bar.update(2)
    text = capsys.readouterr().err
    assert text.count("\r") == 2
    assert "50%" in text
    assert text.endswith("\n")
