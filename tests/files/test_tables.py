"""Tables: columns by name, with units in headings; files of NumPy and pandas come back."""

from __future__ import annotations

import numpy as np
import pytest

import physcore as pc
from physcore.units import AU, day, solar_mass


def written(path, text):
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        (".csv", 'x [AU], vx [km/s], name\n1.0, 2.5, "a, b"\n-2e3, 0, c\n'),
        (".csv", "\ufeffx (AU);vx (km/s);name\n1.0;2.5;a, b\n\n-2e3;0;c\n"),
        (".tsv", "x [AU]\tvx [km/s]\tname\n1.0\t2.5\ta, b\n# a comment\n-2e3\t0\tc\n"),
    ],
)
def test_columns_have_names_and_units(suffix, text, tmp_path):
    table = pc.read(written(tmp_path / f"stars{suffix}", text))
    assert list(table) == ["x", "vx", "name"]
    assert table.units == {"x": "AU", "vx": "km/s"}
    assert table["x"].tolist() == [1.0, -2000.0]
    assert table["name"].tolist() == ["a, b", "c"]
    assert "2 rows of x [AU], vx [km/s], name" in repr(table)
    with pytest.raises(KeyError, match="has the columns"):
        table["y"]


def test_a_file_of_numpy_comes_back(tmp_path):
    values = np.random.default_rng(1).normal(size=(20, 3))
    np.savetxt(tmp_path / "grains.txt", values, header="x y mass")
    table = pc.read(tmp_path / "grains.txt")
    np.testing.assert_array_equal(np.column_stack([table[name] for name in ("x", "y", "mass")]), values)
    np.save(tmp_path / "grains.npy", values)
    np.testing.assert_array_equal(pc.read(tmp_path / "grains.npy"), values)
    np.savez(tmp_path / "grains.npz", a=values, b=np.arange(3))
    both = pc.read(tmp_path / "grains.npz")
    np.testing.assert_array_equal(both["a"], values)
    assert both["b"].tolist() == [0, 1, 2]


def test_a_file_of_pandas_comes_back(tmp_path):
    pandas = pytest.importorskip("pandas", reason="pandas is not installed")
    frame = pandas.DataFrame({"x": [0.1, np.nan], "kind": ["a", 'b "c"'], "y": [1.0 / 3.0, 2.0]})
    frame.to_csv(tmp_path / "frame.csv", index=False)
    table = pc.read(tmp_path / "frame.csv")
    pandas.testing.assert_frame_equal(pandas.DataFrame(dict(table)), frame, check_dtype=False)


def test_particles_are_made_of_columns_in_their_units(tmp_path):
    text = "x [AU],y [AU],vx [AU/d],vy [AU/d],mass [M☉],name\n1,2,0,0.01,1,sun\n3,4,0.5,0,1e-3,planet\n"
    table = pc.read(written(tmp_path / "stars.csv", text))
    stars = table.particles(radius=0.5, name="stars")
    assert stars.positions[1] == pytest.approx([3.0 * AU, 4.0 * AU])
    assert stars.velocities[0] == pytest.approx([0.0, 0.01 * AU / day])
    assert stars.mass == pytest.approx([solar_mass, 1e-3 * solar_mass])
    assert stars.radius.tolist() == [0.5, 0.5]
    astronomical = pc.units.system(length="AU", time="d", mass="M☉")
    assert table.particles(units=astronomical).velocities[0] == pytest.approx([0.0, 0.01])


def test_units_are_asked_for(tmp_path):
    table = pc.read(written(tmp_path / "grains.csv", "x,y,z,mass [g]\n1,2,3,4\n"))
    with pytest.raises(
        pc.SceneError, match=r'column \'x\' of .*grains.csv has no unit; .*"x \[m\]", or give unit="si"'
    ):
        table.particles()
    grains = table.particles(unit=pc.units.system(length="mm"))
    assert grains.positions[0] == pytest.approx([1e-3, 2e-3, 3e-3])
    assert grains.mass[0] == pytest.approx(4e-3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x [m],y [m]\n1,2\n3\n", "line 3 has 1 cells, and the heading 2"),
        ("x [m],y [m]\n1,2\n\n3,4 m\n", "line 4, column 'y': must be a number, got '4 m'"),
        ("1,2\n3,4\n", "line 1 must be a heading"),
        ("x,x\n3,4\n", "line 1 must have a different name for each column"),
        ("", "is empty"),
    ],
)
def test_a_damaged_table_names_the_line(text, message, tmp_path):
    with pytest.raises(pc.FileError, match=f"grains.csv: {message}"):
        pc.read(written(tmp_path / "grains.csv", text))


@pytest.mark.parametrize(
    ("heading", "message"),
    [
        ("x [kg],y [m]", r"grains.csv: x: must be a unit as m, got 'kg'"),
        ("x [elle],y [m]", r"grains.csv: x: the unit 'elle' is not known"),
        ("a [m],y [m]", "must have the columns x and y"),
        ("x [m],y [m],vx [m/s]", "as many velocities as coordinates"),
    ],
)
def test_wrong_columns_are_refused(heading, message, tmp_path):
    row = ",".join("1" for _ in heading.split(","))
    table = pc.read(written(tmp_path / "grains.csv", f"{heading}\n{row}\n"))
    with pytest.raises(pc.SceneError, match=message):
        table.particles()


def test_objects_are_never_unpickled(tmp_path):
    np.save(tmp_path / "objects.npy", np.array([{}], dtype=object), allow_pickle=True)
    with pytest.raises(pc.FileError, match=r"objects.npy: is no array of NumPy"):
        pc.read(tmp_path / "objects.npy")
    (tmp_path / "latin.csv").write_bytes("größe\n1\n".encode("latin-1"))
    with pytest.raises(pc.FileError, match=r"latin.csv: is no text in UTF-8"):
        pc.read(tmp_path / "latin.csv")
