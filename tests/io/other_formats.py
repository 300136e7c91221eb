"""Formats of other programs, tested against writers and readers that are not recon's.

Usage: other_formats.py <recon program> vtk|hdf5|xyz|ase
vtk needs Debian's python3-vtk9, hdf5 python3-h5py, ase python3-ase; xyz needs nothing.
"""
import csv
import os
import struct
import subprocess
import sys
import tempfile

RECON = os.path.abspath(sys.argv[1])


def expect(actual, wanted, what):
    if actual != wanted:
        sys.exit(f"{what}: {actual!r}, not {wanted!r}")


def recon(*arguments):
    subprocess.run([RECON, *arguments], check=True, stdout=subprocess.DEVNULL)


def table(path, *options):
    """What recon reads, as columns by name."""
    text = subprocess.run([RECON, "convert", path, "--out", "-", "--format", "csv", *options],
                          check=True, stdout=subprocess.PIPE, text=True).stdout
    rows = list(csv.reader(text.splitlines()))
    columns = {name: [row[c] for row in rows[1:]] for c, name in enumerate(rows[0])}
    return {name: [float(x) for x in values] if name != "element" else values
            for name, values in columns.items()}


def refuse(path, part, *options):
    """recon must say what is wrong, with the exit code for wrong input."""
    done = subprocess.run([RECON, "info", path, *options], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True)
    expect((done.returncode, part in done.stderr), (2, True), f"{path}: {done.stderr!r} lacks {part!r}")


def value(i, c):
    """Some numbers that need all bits."""
    return (i + 1) / 3 + 0.1 * c


def single(number):
    return struct.unpack("f", struct.pack("f", number))[0]


COUNT = 2000  # more than a block of VTK's compressor holds

# Particles in a dump that recon converts for the others to read.
FRAME = """ITEM: TIME
{}
ITEM: TIMESTEP
{}
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp ff pp
-1 2.5
0 1
0 4
ITEM: ATOMS id element x y z vx vy vz mass
7 Fe {} 0.2 0.3 1.5 -2.5 1e-3 0.7
9 O {} 0.5 0.6 0 0 3.25 0.3
"""
DUMP = FRAME.format(0.5, 10, 0.1, 0.4) + FRAME.format(0.75, 20, 0.2, 0.5)


def vtk():
    from vtkmodules.vtkCommonCore import (vtkDoubleArray, vtkFloatArray, vtkIdTypeArray,
                                          vtkLongLongArray, vtkPoints, vtkUnsignedCharArray)
    from vtkmodules.vtkCommonDataModel import (vtkCellArray, vtkImageData, vtkPolyData,
                                               vtkUnstructuredGrid)
    from vtkmodules.vtkIOLegacy import vtkDataSetWriter, vtkPolyDataWriter
    from vtkmodules.vtkIOXML import (vtkXMLImageDataWriter, vtkXMLPolyDataReader,
                                     vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter)

    def array(kind, name, components, make):
        made = kind()
        made.SetName(name)
        made.SetNumberOfComponents(components)
        made.SetNumberOfTuples(COUNT)
        for i in range(COUNT):
            for c in range(components):
                made.SetComponent(i, c, make(i, c))
        return made

    points = vtkPoints()
    points.SetDataTypeToDouble()
    vertices = vtkCellArray()
    for i in range(COUNT):
        points.InsertNextPoint(*[value(i, 7 * c) for c in range(3)])
        vertices.InsertNextCell(1)
        vertices.InsertCellPoint(i)
    arrays = [array(vtkDoubleArray, "velocity", 3, value), array(vtkFloatArray, "p", 1, value),
              array(vtkIdTypeArray, "id", 1, lambda i, c: i + 1),
              array(vtkLongLongArray, "large", 1, lambda i, c: 2 ** 40 + i),
              array(vtkUnsignedCharArray, "kind", 1, lambda i, c: i % 251),
              array(vtkDoubleArray, "stress", 9, value)]
    data, grid, image = vtkPolyData(), vtkUnstructuredGrid(), vtkImageData()
    data.SetPoints(points)
    data.SetVerts(vertices)
    grid.SetPoints(points)
    grid.SetCells(1, vertices)
    image.SetDimensions(20, 10, 10)
    image.SetOrigin(1, 2, 3)
    image.SetSpacing(0.5, 0.25, 2)
    for each in arrays:
        for of in (data, grid, image):
            of.GetPointData().AddArray(each)

    def check(path, positions=True):
        read = table(path)
        for c, axis in enumerate("xyz"):
            if positions:
                expect(read[axis], [value(i, 7 * c) for i in range(COUNT)], path + ", " + axis)
            expect(read["v" + axis], [value(i, c) for i in range(COUNT)], path + ", v" + axis)
        expect(read["p"], [single(value(i, 0)) for i in range(COUNT)], path + ", p")
        expect(read["id"], [i + 1 for i in range(COUNT)], path + ", id")
        expect(read["large"], [2 ** 40 + i for i in range(COUNT)], path + ", large")
        expect(read["kind"], [i % 251 for i in range(COUNT)], path + ", kind")
        expect(read["stress_yz"], [value(i, 5) for i in range(COUNT)], path + ", stress")

    def write(writer, path, source):
        writer.SetInputData(source)
        writer.SetFileName(path)
        expect(writer.Write(), 1, path + ", written")

    for mode in ("Ascii", "Binary", "Appended"):
        for compressor in ("None", "ZLib"):
            for base64 in (False, True):
                for header, order in (("UInt32", "LittleEndian"), ("UInt64", "BigEndian")):
                    if mode == "Ascii" and (base64 or compressor != "None"):
                        continue
                    writer = vtkXMLPolyDataWriter()
                    getattr(writer, "SetDataModeTo" + mode)()
                    getattr(writer, "SetCompressorTypeTo" + compressor)()
                    writer.SetEncodeAppendedData(base64)
                    getattr(writer, "SetHeaderTypeTo" + header)()
                    getattr(writer, "SetByteOrderTo" + order)()
                    path = f"{mode}{compressor}{base64}{header}.vtp"
                    write(writer, path, data)
                    check(path)
    write(vtkXMLUnstructuredGridWriter(), "grid.vtu", grid)
    check("grid.vtu")
    write(vtkXMLImageDataWriter(), "image.vti", image)
    check("image.vti", positions=False)
    read = table("image.vti")
    expect((read["x"][21], read["y"][21], read["z"][1999]), (1.5, 2.25, 21), "image.vti, nodes")
    for version in (42, 51):
        for source, name in ((data, "polydata"), (grid, "grid"), (image, "image")):
            writer = vtkDataSetWriter()
            writer.SetFileTypeToBinary()
            writer.SetFileVersion(version)
            path = f"{name}{version}.vtk"
            write(writer, path, source)
            check(path, positions=name != "image")
    # As text VTK writes few figures: what is read is what stands there.
    writer = vtkPolyDataWriter()
    write(writer, "text.vtk", data)
    expect(len(table("text.vtk")["x"]), COUNT, "text.vtk")
    damaged = bytearray(open("AppendedZLibFalseUInt64.vtp", "rb").read())
    damaged[len(damaged) // 2] ^= 0x40
    open("damaged.vtp", "wb").write(damaged)
    refuse("damaged.vtp", "' is damaged: block ")
    open("cut.vtp", "wb").write(damaged[:len(damaged) // 2])
    refuse("cut.vtp", "the array '")

    recon("convert", "a.dump", "--frame", "0", "--out", "a.vtp")
    reader = vtkXMLPolyDataReader()
    reader.SetFileName("a.vtp")
    reader.Update()
    written = reader.GetOutput()
    expect([written.GetPoint(i) for i in range(2)], [(0.1, 0.2, 0.3), (0.4, 0.5, 0.6)], "a.vtp")
    fields = written.GetPointData()
    expect(fields.GetArray("velocity").GetTuple(0), (1.5, -2.5, 1e-3), "a.vtp, velocity")
    expect(fields.GetArray("id").GetDataTypeAsString(), "int", "a.vtp, id")
    expect(written.GetFieldData().GetArray("TimeValue").GetValue(0), 0.5, "a.vtp, time")


def hdf5():
    import h5py
    import numpy

    with h5py.File("h5md.h5", "w") as file:
        group = file.create_group("particles/atoms")
        steps = numpy.array([0, 10, 20])
        position = group.create_group("position")
        position["value"] = numpy.array([[[value(i, c) + f for c in range(3)] for i in range(4)]
                                         for f in range(3)])
        position["step"] = steps
        position["time"] = 0.1 * steps
        for name, what in (("velocity", position["value"][...] * 2), ("mass", numpy.ones((3, 4)))):
            element = group.create_group(name)
            element.create_dataset("value", data=what, compression="gzip")
            element["step"] = position["step"]  # a hard link, as H5MD has it
            element["time"] = position["time"]
        group["id"] = numpy.arange(4, dtype="u1")
        charge = group.create_group("charge")  # at every other frame only
        charge["value"] = numpy.array([[1.0] * 4, [2.0] * 4])
        charge["step"] = 20
        group["species"] = numpy.array([b"H"] * 4)
        box = group.create_group("box")
        box.attrs["dimension"] = 3
        box.attrs["boundary"] = ["periodic", "none", "periodic"]
        box["edges"] = [2.0, 3.0, 4.0]
    read = table("h5md.h5", "--frame", "1")
    expect(read["y"], [value(i, 1) + 1 for i in range(4)], "h5md.h5, y")
    expect(read["vz"], [2 * (value(i, 2) + 1) for i in range(4)], "h5md.h5, vz")
    expect(read["id"], [0, 1, 2, 3], "h5md.h5, id")
    expect("charge" in read, False, "h5md.h5, charge at step 10")
    expect(table("h5md.h5", "--step", "20")["charge"], [2] * 4, "h5md.h5, charge at step 20")
    said = subprocess.run([RECON, "info", "h5md.h5"], stdout=subprocess.PIPE, text=True).stdout
    for part in ("steps 0 to 20", "times 0 to 2", "periodic over 0 .. 4", "box 0 .. 3",
                 "species holds no numbers"):
        expect(part in said, True, f"info h5md.h5: {said} lacks {part}")

    with h5py.File("openpmd.h5", "w") as file:
        file.attrs["openPMD"] = "1.1.0"
        for iteration in (100, 20):
            file.create_group(f"data/{iteration}").attrs.update(
                {"time": iteration * 0.5, "dt": 0.5, "timeUnitSI": 1e-15})
            species = file.create_group(f"data/{iteration}/particles/electrons")
            for axis in "xyz":
                position = species.create_dataset("position/" + axis, data=[0.25, 0.5, 0.75])
                position.attrs["unitSI"] = 2.0
                offset = species.create_group("positionOffset/" + axis)
                offset.attrs.update({"value": 10.0, "shape": [3], "unitSI": 1.0})
                species["momentum/" + axis] = numpy.array([1.0, 2.0, iteration])
            species["weighting"] = numpy.array([1, 2, 3], dtype="f4")
            species.create_group("mass").attrs.update({"value": 9e-31, "shape": [3], "unitSI": 1.0})
    read = table("openpmd.h5")
    expect(read["x"], [10.5, 11, 11.5], "openpmd.h5, x")
    expect(read["momentum_z"], [1, 2, 100], "openpmd.h5, momentum")
    expect(read["mass"], [9e-31] * 3, "openpmd.h5, mass")
    expect(table("openpmd.h5", "--frame", "0")["momentum_x"], [1, 2, 20], "openpmd.h5, order")

    def spoil(name, source, change):
        open(name, "wb").write(open(source, "rb").read())
        with h5py.File(name, "r+") as file:
            change(file)

    def delete(name):
        return lambda file: file.__delitem__(name)

    def replace(name, data, **keys):
        def change(file):
            if name in file:
                del file[name]
            file.create_dataset(name, data=data, **keys)
        return change

    atoms = "particles/atoms/"
    open("cut.h5", "wb").write(open("h5md.h5", "rb").read()[:3000])
    refuse("cut.h5", "is damaged")
    spoil("s1.h5", "h5md.h5", delete(atoms + "position/step"))
    refuse("s1.h5", "/particles/atoms/position/step, a data set, is missing")
    spoil("s2.h5", "h5md.h5", replace(atoms + "position/step", numpy.arange(2)))
    refuse("s2.h5", "2 numbers for 3 frames")
    spoil("s3.h5", "h5md.h5", replace(atoms + "position/time", [0, numpy.nan, 1]))
    refuse("s3.h5", "/particles/atoms/position/time holds nan")
    spoil("s4.h5", "h5md.h5", delete(atoms + "box/edges"))
    refuse("s4.h5", "periodic and has no edges")
    spoil("s5.h5", "h5md.h5", replace(atoms + "box/edges", [1.0, 2.0]))
    refuse("s5.h5", "/particles/atoms/box/edges needs 3 lengths")
    spoil("s6.h5", "h5md.h5", lambda file: file.create_group("particles/more")
          .create_dataset("position", data=numpy.ones((2, 3))))
    refuse("s6.h5", "several groups of particles, and one must be named: atoms, more")
    refuse("s6.h5", "no group 'mole'; it has atoms, more", "--group", "mole")
    expect(table("s6.h5", "--group", "more")["x"], [1, 1], "a group by its name")
    spoil("s7.h5", "h5md.h5", lambda file: (delete(atoms + "mass/value")(file), file.create_dataset(
        atoms + "mass/value", shape=(3, 4 * 10 ** 9), dtype="f8", chunks=(1, 1000))))
    expect("mass" in table("s7.h5"), False, "a mass for other particles is left out")
    spoil("s8.h5", "h5md.h5", lambda file: (delete(atoms + "position/value")(file), file.create_dataset(
        atoms + "position/value", shape=(3, 10 ** 8, 3), dtype="f8", chunks=(1, 1000, 3))))
    refuse("s8.h5", "/particles/atoms/position/value promises more numbers than its bytes can hold")
    spoil("s9.h5", "h5md.h5", lambda file: (delete(atoms + "id")(file), file.__setitem__(
        atoms + "id", h5py.ExternalLink("openpmd.h5", "/data"))))
    refuse("s9.h5", "another file")
    spoil("s10.h5", "openpmd.h5", lambda file: file["data/100/particles/electrons/positionOffset/x"]
          .attrs.__setitem__("shape", [4]))
    refuse("s10.h5", "positionOffset/x has no value for each particle")
    spoil("s11.h5", "openpmd.h5", delete("data/100/particles/electrons/position"))
    refuse("s11.h5", "/data/100/particles/electrons/position, a group of x, y, z, is missing")
    with h5py.File("other.h5", "w") as file:
        file["numbers"] = [1.0]
    refuse("other.h5", "without the group /particles of H5MD or /data of openPMD; it has numbers")

    recon("convert", "a.dump", "--out", "a.h5")
    with h5py.File("a.h5") as file:
        group = file["particles/all"]
        expect(file["h5md"].attrs["version"].tolist(), [1, 1], "a.h5, version")
        expect(group["position/value"][1].tolist(), [[0.2, 0.2, 0.3], [0.5, 0.5, 0.6]], "a.h5")
        expect(group["velocity/value"][0].tolist(), [[1.5, -2.5, 1e-3], [0, 0, 3.25]], "a.h5, v")
        expect(group["position/step"][...].tolist(), [10, 20], "a.h5, step")
        expect(group["mass/time"][...].tolist(), [0.5, 0.75], "a.h5, time")
        expect(group["id/value"].dtype.kind, "i", "a.h5, id")
        expect(group["box/edges/value"][0].tolist(), [3.5, 1, 4], "a.h5, edges")
        expect([bytes(x) for x in group["box"].attrs["boundary"]],
               [b"periodic", b"none", b"periodic"], "a.h5, boundary")
        expect(int(group["box"].attrs["dimension"]), 3, "a.h5, dimension")


def xyz():
    recon("convert", "a.dump", "--out", "a.xyz")
    lines = open("a.xyz").read().splitlines()
    expect((len(lines), lines[0], lines[4]), (8, "2", "2"), "a.xyz, frames")
    for part in ('Lattice="3.5 0 0 0 1 0 0 0 4"', 'Origin="-1 0 0"', 'pbc="T F T"', "Step=20",
                 "Time=0.75", "Properties=species:S:1:pos:R:3:id:I:1:velocity:R:3:mass:R:1"):
        expect(part in lines[5], True, f"a.xyz: {lines[5]!r} lacks {part!r}")
    expect(lines[6].split(), "Fe 0.2 0.2 0.3 7 1.5 -2.5 0.001 0.7".split(), "a.xyz, a line")
    expect(table("a.xyz", "--frame", "0"), table("a.dump", "--frame", "0"), "a.xyz, read back")


def ase():
    import ase.io

    recon("convert", "a.dump", "--out", "a.xyz")
    frames = ase.io.read("a.xyz", ":")
    expect(len(frames), 2, "a.xyz, frames")
    expect(frames[1].get_positions().tolist(), [[0.2, 0.2, 0.3], [0.5, 0.5, 0.6]], "a.xyz")
    expect(frames[0].get_chemical_symbols(), ["Fe", "O"], "a.xyz, species")
    expect(frames[0].get_pbc().tolist(), [True, False, True], "a.xyz, pbc")
    expect(frames[0].get_cell().lengths().tolist(), [3.5, 1, 4], "a.xyz, cell")
    frames[0].arrays["charge"] = frames[0].get_positions()[:, 0] / 3
    frames[0].set_velocities([[1, 2, 3], [4, 5, 6.5]])
    ase.io.write("b.xyz", frames, format="extxyz")
    read = table("b.xyz", "--frame", "0")
    expect(read["element"], ["Fe", "O"], "b.xyz, element")
    # ASE writes eight figures.
    expect([round(x, 8) for x in read["charge"]], [round(0.1 / 3, 8), round(0.4 / 3, 8)], "b.xyz")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        open("a.dump", "w").write(DUMP)
        {"vtk": vtk, "hdf5": hdf5, "xyz": xyz, "ase": ase}[sys.argv[2]]()
    print("as expected")


main()
