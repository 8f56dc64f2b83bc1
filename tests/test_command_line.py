"""The command line: what it prints, what it writes, and how it fails."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path

import pytest
from PIL import Image

from physcore.__main__ import main
from physcore.film import provenance
from physcore.film.writers import WRITERS
from physcore.gallery import DEMOS, Cost, caption, costs, demo
from physcore.gallery.figure import Figure
from physcore.gallery.page import gallery
from physcore.progress import Progress

SHORT = "from physcore.gallery import demo; demo('rope').DURATION = 0.2"
"""What makes a process film the first moments of a demo."""


@pytest.fixture(autouse=True)
def short(monkeypatch, request):
    """Film the first moments of a demo, except where other processes film it too."""
    if "processes" not in request.node.name:
        monkeypatch.setattr(demo("rope"), "DURATION", 0.2)


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
    for word in ("kinetic", "dissipated", "work", "drift", "momentum", "Checked: ", "off by"):
        assert word in output.out
    assert "100 %" in output.err
    (video,) = (entry for entry in tmp_path.iterdir() if entry != path)
    assert re.search(rf"{path.name} \(\d\.\d MB\)", output.out)
    assert re.search(rf"{video.name} \(\d\.\d MB\)\. Use MP4 or WebP for the web", output.out)


@pytest.mark.parametrize("kind", WRITERS)
def test_a_demo_is_filmed_in_any_format(kind, capsys, tmp_path):
    path = tmp_path / f"rope{kind.suffixes[0]}"
    assert main(["demo", "rope", "-o", str(path)]) == 0
    (panel,) = provenance(path)
    assert panel["scene"] == demo("rope").scene().hash()
    assert str(path) in capsys.readouterr().out


class Page(HTMLParser):
    """What a page refers to, and whether every element that was opened is closed."""

    EMPTY = ("meta", "img")

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.references, self.images = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        found = dict(attributes)
        self.references += [found[name] for name in ("src", "href") if name in found]
        if tag == "img":
            self.images.append(found)
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_a_gallery_is_a_page_with_its_films_beside_it(capsys, tmp_path):
    assert main(["gallery", "rope", "orbits", "rope", "-o", str(tmp_path / "new" / "page")]) == 0
    folder = tmp_path / "new" / "page"
    text = (folder / "index.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.references == ["rope.gif", "orbits.gif"]
    for image in page.images:
        assert image["alt"] == caption(image["src"].removesuffix(".gif"))
        with Image.open(folder / image["src"]) as film:
            assert (int(image["width"]), int(image["height"])) == film.size
    assert "script" not in page.tags
    assert "link" not in page.tags
    assert str(tmp_path) not in text
    assert "://" not in text
    output = capsys.readouterr().out
    assert "1 of 2 demos; about " in output
    assert "2 of 2 demos; about 0 s left" in output
    for word in ("every figure holds", "Kepler&#x27;s third law", "RungeKutta4, dt = 0.00314 s, f64", "energy drift"):
        assert word in text
    assert "def scene() -&gt; pc.Scene:" in text
    assert str(folder / "index.html") in output
    assert "rope.gif" in output


def test_the_page_of_a_gallery_grows_with_each_film(tmp_path):
    for number, entry in enumerate(gallery(tmp_path, ["orbits", "rope"], progress=False), 1):
        page = Page((tmp_path / "index.html").read_text(encoding="utf-8"))
        assert page.references == ["orbits.gif", "rope.gif"][:number]
        costs = json.loads((tmp_path / "costs.json").read_text(encoding="utf-8"))
        assert costs[entry.name]["bytes"] == (tmp_path / entry.film).stat().st_size
        assert 0.0 < costs[entry.name]["seconds"] < 600.0


def test_demos_run_in_several_processes(capsys, tmp_path):
    assert main(["gallery", "rope", "orbits", "-o", str(tmp_path / "two"), "--jobs", "2"]) == 0
    assert "2 of 2 demos" in capsys.readouterr().out
    assert main(["gallery", "rope", "-o", str(tmp_path / "one")]) == 0
    assert (tmp_path / "two" / "rope.gif").read_bytes() == (tmp_path / "one" / "rope.gif").read_bytes()
    assert Page((tmp_path / "two" / "index.html").read_text(encoding="utf-8")).references == ["rope.gif", "orbits.gif"]
    assert main(["gallery", "rope", "-o", str(tmp_path / "none"), "--jobs", "0"]) == 1
    assert "jobs: must be ≥ 1, got 0" in capsys.readouterr().err


def test_a_quick_gallery_leaves_out_what_takes_long(capsys, monkeypatch, tmp_path):
    known = {"rope": Cost(1.0, 10**6), "bowl": Cost(100.0, 10**6)}
    monkeypatch.setattr("physcore.gallery.costs", lambda: known)
    assert main(["gallery", "bowl", "rope", "knot", "-o", str(tmp_path), "--quick"]) == 0
    assert capsys.readouterr().out.startswith("Left out: bowl, knot.")
    assert Page((tmp_path / "index.html").read_text(encoding="utf-8")).references == ["rope.gif"]


def test_costs_are_those_of_demos_and_are_listed(capsys):
    known = costs()
    assert set(known) <= set(DEMOS)
    assert main(["list"]) == 0
    lines = {line.split()[0]: line for line in capsys.readouterr().out.splitlines()}
    for name, cost in known.items():
        assert f"{cost.seconds:.0f} s" in lines[name]
        assert f"{cost.bytes / 1e6:.1f} MB" in lines[name]


def test_a_demo_of_so_many_particles_says_beforehand_how_long_it_takes(capsys, monkeypatch, tmp_path):
    """With more particles than the demo has by itself, it rehearses; here few are filmed for a moment."""
    two_dams = demo("two_dams")
    monkeypatch.setattr(two_dams, "DURATION", 0.05)
    monkeypatch.setattr(two_dams, "PARTICLES", 1000)
    assert main(["demo", "two_dams", "--particles", "2000", "-o", str(tmp_path / "dams.gif")]) == 0
    output = capsys.readouterr().out
    assert re.search(r"\n\d+ particles: \d+ steps of \S+ s, about .* at the pace of the first ones", output)
    assert int(re.search(r"\n(\d+) particles", output)[1]) == len(two_dams.scene(2000).bodies[0].positions) * 2


def test_a_number_of_particles_is_refused_where_a_demo_has_none_or_it_is_too_small(capsys):
    assert main(["demo", "rope", "--particles", "2000"]) == 2
    assert main(["demo", "two_dams", "--particles", "10"]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "physcore: rope has no --particles",
        "physcore: particles: must be ≥ 1000, got 10",
    ]


def test_the_source_of_a_demo_is_a_script_that_makes_its_film(capsys, tmp_path, monkeypatch):
    assert main(["demo", "rope", "--source"]) == 0
    script = capsys.readouterr().out
    monkeypatch.chdir(tmp_path)
    assert "\nDURATION = 2.0\n" in script
    exec(compile(script.replace("DURATION = 2.0", "DURATION = 0.2"), "x.py", "exec"), {"__name__": "__main__"})
    assert (tmp_path / "rope.gif").read_bytes().startswith(b"GIF89a")


def test_alone_it_prints_its_help(capsys):
    assert main([]) == 0
    assert "usage: physcore" in capsys.readouterr().out


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_is_said_in_a_line():
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "physcore", "list"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == "physcore: cannot write: No space left on device\n"


def test_a_misspelt_demo_is_guessed(capsys):
    assert main(["demo", "rop"]) == 2
    assert "did you mean 'rope'?" in capsys.readouterr().err


def test_a_figure_that_does_not_hold_is_marked_and_is_a_failure(capsys, monkeypatch, tmp_path):
    hostile = Figure('<script>"a" & b</script>', 2.0, 1.0, "by theory", 0.1)
    monkeypatch.setattr(demo("rope"), "figure", lambda recordings: hostile)
    assert main(["gallery", "rope", "-o", str(tmp_path)]) == 1
    assert "the figures of rope do not hold" in capsys.readouterr().err
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "script" not in Page(text).tags
    assert '<p class="failed">✗ does not hold: &lt;script&gt;&quot;a&quot; &amp; b&lt;/script&gt; 2.00' in text
    assert "1 of 1 figures do not hold" in text


def test_a_gallery_refuses_before_it_begins(capsys, tmp_path):
    assert main(["gallery", "rope", "no-such-demo", "-o", str(tmp_path / "page")]) == 2
    assert not (tmp_path / "page").exists()
    (tmp_path / "file").write_text("mine")
    assert main(["gallery", "rope", "-o", str(tmp_path / "file")]) == 1
    error = capsys.readouterr().err.splitlines()
    assert error[0].startswith("physcore: no demo 'no-such-demo'")
    assert "cannot be made a folder" in error[1]
    assert len(error) == 2


def test_a_gallery_that_is_killed_leaves_what_was_there_and_whole_films(tmp_path):
    (tmp_path / "index.html").write_text("the last one")
    program = f"{SHORT}; from physcore.__main__ import main; main()"
    command = [sys.executable, "-c", program, "gallery", "rope", "jelly", "bowl", "-o", str(tmp_path)]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while not (tmp_path / "rope.gif").exists():
            assert running.poll() is None
            time.sleep(0.01)
    finally:
        running.kill()
    assert running.wait() == -signal.SIGKILL
    text = (tmp_path / "index.html").read_text()
    assert text == "the last one" or Page(text).references[0] == "rope.gif"
    for path in tmp_path.glob("[!.]*.gif"):
        with Image.open(path) as film:
            film.seek(film.n_frames - 1)


def test_bad_input_is_one_line_and_an_exit_code(capsys, tmp_path):
    assert main(["demo", "no-such-demo"]) == 2
    assert main(["demo", "rope", "-o", str(tmp_path / "missing" / "rope.gif")]) == 2
    assert main(["demo", "rope", "-o", str(tmp_path / "rope.avi")]) == 2
    output = capsys.readouterr()
    assert output.out == ""  # nothing was simulated
    error = output.err.splitlines()
    assert error[0].startswith("physcore: no demo 'no-such-demo'; `physcore list` names them")
    assert "no such folder" in error[1]
    assert error[2].startswith("physcore: path: must end in .gif, .webp, .apng, .mp4, .html or .png")
    assert len(error) == 3
    with pytest.raises(SystemExit) as stopped:
        main(["dance"])
    assert stopped.value.code == 2


def test_a_film_whose_name_is_no_text_is_named_all_the_same(capsys, tmp_path):
    assert main(["demo", "rope", "-o", f"{tmp_path}/\udcff.png"]) == 0
    assert r"\xff.png" in capsys.readouterr().out


def test_a_trade_whose_files_cannot_be_written_is_refused_before_it_is_measured(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr("physcore.tradeoff", lambda *arguments, **options: pytest.fail("measured"))
    missing = str(tmp_path / "missing" / "trade")
    for option in (["--json", f"{missing}.json"], ["-o", f"{missing}.png"], ["--json", str(tmp_path)]):
        assert main(["tradeoff", "rope", *option]) == 2
    assert main(["tradeoff", "rope", "-o", str(tmp_path / "trade.avi")]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    *lines, last = output.err.splitlines()
    assert all("cannot be written" in line for line in lines)
    assert last.startswith("physcore: path: must end in ")


def test_a_gallery_whose_files_cannot_be_written_is_refused_before_it_begins(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(demo("rope"), "main", lambda *arguments: pytest.fail("simulated"))
    (tmp_path / "rope.gif").mkdir()
    assert main(["gallery", "rope", "-o", str(tmp_path)]) == 1
    assert "rope.gif: cannot be written: not a regular file" in capsys.readouterr().err
    assert [entry.name for entry in tmp_path.iterdir()] == ["rope.gif"]


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
    expected = ["working: 0 %", *(f"working: {percent} %, 0 s left" for percent in (25, 50, 75)), "working: 100 %"]
    assert capsys.readouterr().err.splitlines() == expected


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
