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
import xml.etree.ElementTree

try:
    from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkTensorGlyph
    from vtkmodules.vtkFiltersFlowPaths import vtkStreamTracer
    from vtkmodules.vtkFiltersGeneral import vtkWarpVector
    from vtkmodules.vtkFiltersSources import vtkArrowSource, vtkPointSource
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLPImageDataReader, vtkXMLPolyDataReader
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
    expect(component_names(velocity), ["x", "y", "z"], name + ", components")
    expect(component_names(fields.GetArray("stress")), TENSOR_NAMES, name + ", components")
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
    pieces = read(vtkXMLPImageDataReader(), os.path.join(folder, "grid.pvti"))
    for what in ("GetDimensions", "GetOrigin", "GetSpacing"):
        expect(getattr(pieces, what)(), getattr(grid, what)(), "grid in pieces, " + what)
    check_fields(pieces, 24, "grid in pieces")

    plane = read(vtkXMLImageDataReader(), os.path.join(folder, "plane.vti"))
    expect(plane.GetDimensions(), (3, 2, 1), "plane, nodes")
    expect(plane.GetOrigin(), (1.0, 2.0, 0.0), "plane, origin")
    expect(plane.GetSpacing(), (0.5, 0.25, 1.0), "plane, spacing")
    check_plane(plane)
    check_stream_lines(plane)


def component_names(array):
    return [array.GetComponentName(c) for c in range(array.GetNumberOfComponents())]


TENSOR_NAMES = [row + column for row in "xyz" for column in "xyz"]


def check_plane(data):
    """Vectors and tensors of 2-D data are what VTK takes for vectors and tensors."""
    fields = data.GetPointData()
    turning = fields.GetArray("turning")
    expect(component_names(turning), ["x", "y", "z"], "plane, names of a vector")
    for name in ("slope", "stress"):
        expect(component_names(fields.GetArray(name)), TENSOR_NAMES, "plane, names of " + name)
    for n in range(6):
        x, y = 1 + 0.5 * (n % 3), 2 + 0.25 * (n // 3)
        expect(data.GetPoint(n), (x, y, 0.0), "plane, node")
        expect(turning.GetTuple(n), (2.125 - y, x - 1.5, 0.0), "plane, vector")
        slope = (1.0 * n, 2.0 * n, 0.0, 3.0 * n, 4.0 * n, 0.0, 0.0, 0.0, 0.0)
        expect(fields.GetArray("slope").GetTuple(n), slope, "plane, tensor")
        stress = (1.0 + n, 2.0 + n, 0.0, 2.0 + n, 3.0 + n, 0.0, 0.0, 0.0, 0.0)
        expect(fields.GetArray("stress").GetTuple(n), stress, "plane, symmetric tensor")
        expect(fields.GetArray("four").GetTuple(n), (5.0, 6.0, 7.0, 8.0), "plane, scalars")

    accepted = fields.SetActiveVectors("turning"), fields.SetActiveTensors("slope")
    expect(min(accepted) >= 0, True, "plane, active vectors and tensors")
    warp = vtkWarpVector()
    warp.SetInputData(data)
    warp.SetScaleFactor(10)
    warp.Update()
    for n in range(6):
        at, by = data.GetPoint(n), turning.GetTuple(n)
        warped = warp.GetOutput().GetPoint(n)
        for axis in range(3):
            expect(abs(warped[axis] - at[axis] - 10 * by[axis]) < 1e-5, True, "plane, warp")

    one = vtkArrowSource()
    one.Update()
    arrows = vtkGlyph3D()
    arrows.SetInputData(data)
    arrows.SetSourceConnection(one.GetOutputPort())
    arrows.SetVectorModeToUseVector()
    arrows.Update()
    count = 6 * one.GetOutput().GetNumberOfPoints()
    expect(arrows.GetOutput().GetNumberOfPoints(), count, "plane, arrows")
    tensors = vtkTensorGlyph()
    tensors.SetInputData(data)
    tensors.SetSourceConnection(one.GetOutputPort())
    tensors.Update()
    expect(tensors.GetOutput().GetNumberOfPoints(), count, "plane, tensor glyphs")


def check_stream_lines(plane):
    """A stream line of the rotation keeps its distance from the centre."""
    plane.GetPointData().SetActiveVectors("turning")
    seed = vtkPointSource()
    seed.SetNumberOfPoints(1)
    seed.SetRadius(0)
    seed.SetCenter(1.5, 2.2, 0)
    tracer = vtkStreamTracer()
    tracer.SetInputData(plane)
    tracer.SetSourceConnection(seed.GetOutputPort())
    tracer.SetMaximumPropagation(1)
    tracer.SetIntegratorTypeToRungeKutta4()
    tracer.SetIntegrationStepUnit(vtkStreamTracer.LENGTH_UNIT)
    tracer.SetInitialIntegrationStep(0.01)
    tracer.Update()
    line = tracer.GetOutput()
    expect(line.GetNumberOfPoints() > 5, True, "plane, stream line")
    for i in range(line.GetNumberOfPoints()):
        x, y, z = line.GetPoint(i)
        expect(abs(math.hypot(x - 1.5, y - 2.125) - 0.075) < 1e-3 and z == 0, True,
               "plane, stream line goes round")


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

    check_plane(read(vtkXMLPolyDataReader(), os.path.join(folder, "plane.vtp")))
    line = read(vtkXMLPolyDataReader(), os.path.join(folder, "line.vtp"))
    u = line.GetPointData().GetArray("u")
    expect([u.GetTuple(i) for i in range(3)],
           [(0.5, 0.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)], "line, vector")
    expect(line.GetPointData().GetArray("p").GetNumberOfComponents(), 1, "line, scalar")
    expect(line.GetPoint(2), (3.0, 0.0, 0.0), "line, point")

    none = read(vtkXMLPolyDataReader(), os.path.join(folder, "none.vtp"))
    expect(none.GetNumberOfPoints(), 0, "none")
    flat = read(vtkXMLPolyDataReader(), os.path.join(folder, "flat.vtp"))
    expect([flat.GetPoint(i) for i in range(2)], [(1.0, 3.0, 0.0), (2.0, 4.0, 0.0)], "flat")


def check_series(folder):
    """The files of the .pvd, found by its own names, with their times."""
    collection = xml.etree.ElementTree.parse(os.path.join(folder, "series.pvd")).getroot()[0]
    expect([float(each.get("timestep")) for each in collection], [0, 0.1 + 0.2], "series, times")
    for each in collection:
        line = read(vtkXMLPolyDataReader(), os.path.join(folder, each.get("file")))
        expect(line.GetNumberOfPoints(), 3, "series, points")


def main():
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], "--gtest_filter=VtkSamples.Write"], check=True,
                       stdout=subprocess.DEVNULL, env={**os.environ, "RECON_VTK_SAMPLES": folder})
        check_grid(folder)
        check_points(folder)
        check_series(folder)
    print("VTK reads what recon writes")


main()
