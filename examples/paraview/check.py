"""Loads the plugin in ParaView, compares it with `recon map`, and draws pictures.

Usage: pvpython check.py FOLDER
FOLDER has recon_map.py, chute.vtp (particles), chute.vti (what `recon map chute.vtp --spacing 1 --radius 2
--fields vx,vy,vz,mass,density,radius` made of them) and dam.vtp; the pictures go there, too.
"""
import os
import sys

import numpy as np
from paraview import simple
from paraview.servermanager import Fetch
from vtkmodules.util.numpy_support import vtk_to_numpy

folder = sys.argv[1]
os.chdir(folder)


def expect(holds, what):
    if not holds:
        sys.exit("check.py: " + what)


def choose(filter, *names):
    filter.UpdatePipelineInformation()  # what arrays there are
    filter.Arrays = list(names)


simple.LoadPlugin(os.path.join(folder, "recon_map.py"), ns=globals())
particles = simple.XMLPolyDataReader(FileName=["chute.vtp"])
mapped = ReconMap(Input=particles, Spacing=1.0, Radius=2.0)  # noqa: F821 (the plugin makes it)
choose(mapped, "velocity", "mass", "radius")
mapped.UpdatePipeline()
image = Fetch(mapped)
wanted = Fetch(simple.XMLImageDataReader(FileName=["chute.vti"]))
expect(image.GetDimensions() == wanted.GetDimensions(), f"{image.GetDimensions()} nodes, not {wanted.GetDimensions()}")
expect(np.allclose(image.GetOrigin(), wanted.GetOrigin(), atol=0), "the origin of the grid")


def array(data, name):
    found = data.GetPointData().GetArray(name)
    expect(found is not None, f"there is no array {name}")
    return vtk_to_numpy(found)


compared = 0
for name in [wanted.GetPointData().GetArrayName(i) for i in range(wanted.GetPointData().GetNumberOfArrays())]:
    ours = array(image, "velocity")[:, "xyz".index(name[1])] if name in ("vx", "vy", "vz") else array(image, name)
    expect(np.array_equal(ours, array(wanted, name), equal_nan=True), f"{name} is not what recon map has")
    compared += 1
expect(compared >= 9, "too few arrays were compared")
expect(array(image, "status").dtype.kind == "i", "status must be whole numbers")

# A plane of points, and a selection of arrays.
dam = simple.XMLPolyDataReader(FileName=["dam.vtp"])
plane = ReconMap(Input=dam, Degree=2, Gradient=1)  # noqa: F821
choose(plane, "velocity")
plane.UpdatePipeline()
image = Fetch(plane)
expect(image.GetDimensions()[2] == 1 and image.GetDimensions()[0] > 50, f"the plane has {image.GetDimensions()} nodes")
expect(image.GetPointData().GetArray("pressure") is None, "an array that was not chosen")
expect(image.GetPointData().GetArray("velocity_gradient").GetNumberOfComponents() == 9, "the gradient of a vector")

# Glyphs, warps and tensors of what recon writes and maps.
simple.SetActiveSource(mapped)
arrows = simple.Glyph(Input=mapped, GlyphType="Arrow", OrientationArray=["POINTS", "velocity"],
                      ScaleArray=["POINTS", "velocity"], ScaleFactor=0.25, GlyphMode="All Points")
arrows.UpdatePipeline()
expect(arrows.GetDataInformation().GetNumberOfPoints() > 1000, "no arrows")
# Nodes far from all particles have no value: the report says which.
water = simple.Threshold(Input=plane, Scalars=["POINTS", "status"], LowerThreshold=0, UpperThreshold=1)
warp = simple.WarpByVector(Input=water, Vectors=["POINTS", "velocity"], ScaleFactor=0.2)
warp.UpdatePipeline()
expect(500 < warp.GetDataInformation().GetNumberOfPoints() < image.GetNumberOfPoints(), f"{warp.GetDataInformation().GetNumberOfPoints()} points are warped")
flow = simple.Glyph(Input=water, GlyphType="2D Glyph", OrientationArray=["POINTS", "velocity"],
                    ScaleArray=["POINTS", "velocity"], ScaleFactor=0.06, GlyphMode="All Points")
tensors = simple.TensorGlyph(Input=water, Tensors=["POINTS", "velocity_gradient"], GlyphType="Sphere", ScaleFactor=0.02)
tensors.UpdatePipeline()
expect(tensors.GetDataInformation().GetNumberOfPoints() > 1000, "no tensors")


def picture(name, camera, *shown):
    view = simple.CreateView("RenderView")
    view.ViewSize = [1000, 600]
    view.Background = [1, 1, 1]
    view.UseColorPaletteForBackground = 0
    view.OrientationAxesVisibility = 0
    for source, colour, style in shown:
        display = simple.Show(source, view)
        display.SetRepresentationType(style)
        if colour is None:
            display.DiffuseColor = [0.2, 0.4, 0.7]
            continue
        simple.ColorBy(display, ("POINTS", colour))
        display.RescaleTransferFunctionToDataRange(False)
        display.SetScalarBarVisibility(view, True)
        bar = simple.GetScalarBar(simple.GetColorTransferFunction(colour), view)
        bar.TitleColor = bar.LabelColor = [0, 0, 0]
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = camera
    view.CameraParallelProjection = 1
    simple.ResetCamera(view)
    view.CameraParallelScale *= 0.65
    simple.SaveScreenshot(name, view)
    simple.Delete(view)


picture("chute.png", ([25, -45, 18], [0, 0, 3], [0, 0, 1]), (arrows, "velocity", "Surface"))
picture("dam.png", ([2, 0.8, 10], [2, 0.8, 0], [0, 1, 0]), (water, "velocity", "Surface"), (flow, "velocity", "Wireframe"))
picture("tensors.png", ([2, 0.8, 10], [2, 0.8, 0], [0, 1, 0]), (tensors, None, "Surface"))
print(f"{compared} arrays are those of recon map; glyphs, warps and tensors are drawn")
