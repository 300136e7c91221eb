"""Reads the files of VtkSamples.Write (write_test.cpp) with VTK, compares them with its formulas.

Usage: vtk_reader_check.py <test program of the room io>
Needs Debian's python3-vtk9; exits with 77 (skipped) where it is missing.
"""
import math
import os
import struct
import subprocess
import sys
import tempfile

try:
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPolyDataReader
except ImportError:
    print("VTK's Python module is missing: apt-get install python3-vtk9")
    sys.exit(77)

HOSTILE = "v \"a\" <b> & 'c', ; d"


def expect(actual, wanted, what):
    if actual != wanted:
        sys.exit(f"{what}: {actual!r}, not {wanted!r}")


def read(reader, path):
    reader.SetFileName(path)
    reader.Update()
    expect(reader.GetErrorCode(), 0, path + ", error code")
    return reader.GetOutput()


def single(value):
    return struct.unpack("f", struct.pack("f", value))[0]


def check_fields(data, count, name):
    fields = data.GetPointData()
    names = [fields.GetArrayName(i) for i in range(fields.GetNumberOfArrays())]
    expect(names, [HOSTILE, "velocity", "stress", "rank", "single"], name + ", names")
    types = [fields.GetArray(i).GetDataTypeAsString() for i in range(5)]
    expect(types, ["double", "double", "double", "int", "float"], name + ", types")
    velocity = fields.GetArray("velocity")
    expect([velocity.GetComponentName(c) for c in range(3)], ["x", "y", "z"], name + ", components")
    for i in range(count):
        value = fields.GetArray(HOSTILE).GetValue(i)
        if i == 5:
            expect(math.isnan(value), True, name + ", NaN")
        else:
            expect(value, 0.1 * i, name + ", scalar")
        expect(velocity.GetTuple(i), tuple(i + 0.01 * c for c in range(3)), name + ", vector")
        stress = tuple(-float(i) * c for c in range(9))
        expect(fields.GetArray("stress").GetTuple(i), stress, name + ", tensor")
        expect(fields.GetArray("rank").GetValue(i), i - 3, name + ", rank")
        expect(fields.GetArray("single").GetValue(i), single(0.1 * i), name + ", single")
    about = data.GetFieldData()
    expect(about.GetAbstractArray("step").GetValue(0), 9007199254740993, name + ", step")
    expect(about.GetAbstractArray("TimeValue").GetValue(0), 0.1, name + ", time")


def check_grid(folder):
    grid = read(vtkXMLImageDataReader(), os.path.join(folder, "grid.vti"))
    expect(grid.GetDimensions(), (4, 3, 2), "grid, nodes")
    expect(grid.GetOrigin(), (-1.5, 0.1, 1e6), "grid, origin")
    expect(grid.GetSpacing(), (0.25, 1 / 3, 2.0), "grid, spacing")
    check_fields(grid, 24, "grid")

    plane = read(vtkXMLImageDataReader(), os.path.join(folder, "plane.vti"))
    expect(plane.GetDimensions(), (3, 2, 1), "plane, nodes")
    expect(plane.GetOrigin(), (1.0, 2.0, 0.0), "plane, origin")
    expect(plane.GetSpacing(), (0.5, 0.25, 1.0), "plane, spacing")
    expect(plane.GetPointData().GetArray("v").GetTuple(4), (8.0, 9.0), "plane, v")


def check_points(folder):
    points = read(vtkXMLPolyDataReader(), os.path.join(folder, "points.vtp"))
    expect((points.GetNumberOfPoints(), points.GetNumberOfVerts()), (24, 24), "points, number")
    check_fields(points, 24, "points")
    for n in range(24):
        i, j, k = n % 4, n // 4 % 3, n // 12
        position = (-1.5 + i * 0.25, 0.1 + j * (1 / 3), 1e6 + k * 2)
        expect(points.GetPoint(n), position, "points, position")
        cell = points.GetCell(n)
        expect((cell.GetNumberOfPoints(), cell.GetPointId(0)), (1, n), "points, vertex")

    none = read(vtkXMLPolyDataReader(), os.path.join(folder, "none.vtp"))
    expect(none.GetNumberOfPoints(), 0, "none")
    flat = read(vtkXMLPolyDataReader(), os.path.join(folder, "flat.vtp"))
    expect([flat.GetPoint(i) for i in range(2)], [(1.0, 3.0, 0.0), (2.0, 4.0, 0.0)], "flat")


def main():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], "--gtest_filter=VtkSamples.Write"], check=True,
                       stdout=subprocess.DEVNULL, env={**os.environ, "RECON_VTK_SAMPLES": folder})
        check_grid(folder)
        check_points(folder)
    print("VTK reads what recon writes")


main()
