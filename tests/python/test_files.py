"""Files in and out; what is written is read by VTK itself."""

from __future__ import annotations

import gzip
import pathlib

import numpy as np
import pytest

import recon
from clouds import inner, jittered, linear

CHUTE = pathlib.Path(__file__).resolve().parents[2] / "examples" / "data" / "chute.dump.gz"


def test_a_dump_of_lammps() -> None:
    frames = recon.list_frames(CHUTE)
    table = recon.read(CHUTE)
    assert table.step == frames[-1]["step"] and table.size == frames[-1]["particles"]
    x = table.positions()
    assert x.shape == (table.size, table.dimension) and x.flags.c_contiguous
    np.testing.assert_array_equal(x[:, 2], table[table.coordinates()[2]])
    view = table["vx"]
    assert not view.flags.owndata and not view.flags.writeable
    velocity = table.field(["vx", "vy", "vz"])
    target = x.mean(axis=0)[None, :]
    domain = table.domain()
    by_table = recon.reconstruct(table, target, radius=2, domain=domain) @ velocity
    by_array = recon.reconstruct(x, target, radius=2, domain=domain) @ velocity
    np.testing.assert_array_equal(by_table, by_array)
    assert set(dict(table)) == set(table.keys()) and "vx" in table and "nothing" not in table
    with pytest.raises(recon.InvalidArgument, match="column = vxx: .* did you mean 'vx'"):
        table["vxx"]
    half = table.where(table["vx"] > np.median(table["vx"]))
    assert half.size == np.sum(table["vx"] > np.median(table["vx"]))


def test_all_frames_one_after_the_other() -> None:
    frames = recon.list_frames(CHUTE)
    steps = [table.step for table in recon.read_frames(CHUTE)]
    assert steps == [frame["step"] for frame in frames]
    assert recon.read(CHUTE, 0).step == steps[0]
    with pytest.raises(recon.FileError, match="chute.dump.gz"):
        recon.read(CHUTE, 1000)


def test_delimited_text_and_its_trouble(tmp_path: pathlib.Path) -> None:
    good = tmp_path / "good.csv.gz"
    good.write_bytes(gzip.compress(b"x,y,u,kind\n0,0,1,a\n1,0,NA,b\n0,1,3,c\n"))
    table = recon.read(good, missing=["NA"])
    assert table.text_columns == ["kind"] and table.dimension == 2
    assert table.without_missing(["u"]).size == 2
    with pytest.raises(recon.InvalidArgument, match="line 3"):
        table["u"]
    bad = tmp_path / "bad.csv"
    bad.write_text("x,y\n0,0\n1\n")
    with pytest.raises(recon.FileError, match="bad.csv:3:") as caught:
        recon.read(bad)
    assert caught.value.line == 3 and caught.value.path == str(bad) and isinstance(caught.value, OSError)
    with pytest.raises(recon.FileError, match="no such file"):
        recon.read(tmp_path / "none.csv")


def test_what_is_written_is_read_back(tmp_path: pathlib.Path) -> None:
    x = jittered(6, 3)
    fields = {"u": linear(x), "v": x.astype("f4"), "id": np.arange(len(x))}
    recon.write(tmp_path / "points.csv", x, fields)
    table = recon.read(tmp_path / "points.csv")
    np.testing.assert_array_equal(table.positions(), x)
    np.testing.assert_array_equal(table["u"], linear(x))
    with pytest.raises(recon.FileError):
        recon.write(tmp_path / "points.xyz", x, fields)
    with pytest.raises(recon.InvalidArgument, match="'u'|u"):
        recon.write(tmp_path / "points.csv", x, {"u": np.zeros(3)})
    assert not (tmp_path / "points.xyz").exists()


def test_vtk_reads_points_and_grids(tmp_path: pathlib.Path) -> None:
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    x = jittered(6, 3)
    recon.write(tmp_path / "points.vtp", x, {"u": linear(x), "v": x, "id": np.arange(len(x))}, time=0.5)
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(tmp_path / "points.vtp"))
    reader.Update()
    data = reader.GetOutput()
    np.testing.assert_array_equal(vtk_to_numpy(data.GetPoints().GetData()), x)
    np.testing.assert_array_equal(vtk_to_numpy(data.GetPointData().GetArray("u")), linear(x))
    assert vtk_to_numpy(data.GetPointData().GetArray("id")).dtype == np.int32

    grid = recon.StructuredGrid((0.2, 0.2, 0.2), (0.1, 0.2, 0.3), (5, 4, 3))
    shaped = recon.on_grid(x, {"u": linear(x), "v": x}, grid, radius=0.4)
    recon.write(tmp_path / "grid.vti", grid, {"u": shaped["u"], "v": shaped["v"]})
    image = vtk.vtkXMLImageDataReader()
    image.SetFileName(str(tmp_path / "grid.vti"))
    image.Update()
    out = image.GetOutput()
    assert out.GetDimensions() == (5, 4, 3)
    u = vtk_to_numpy(out.GetPointData().GetArray("u"))
    np.testing.assert_array_equal(grid.reshape(u), shaped["u"])
    np.testing.assert_array_equal(grid.reshape(vtk_to_numpy(out.GetPointData().GetArray("v"))), shaped["v"])
    assert out.GetPoint(7) == pytest.approx(tuple(grid.nodes()[7]))


def test_every_column_of_a_table_goes_to_pandas() -> None:
    pandas = pytest.importorskip("pandas")
    table = recon.read(CHUTE)
    frame = pandas.DataFrame(dict(table))
    assert len(frame) == table.size and list(frame.columns) == table.keys()
    assert recon.Sources(frame[["x", "y", "z"]]).size == table.size
    assert inner(1, 3).shape == (1, 3)
