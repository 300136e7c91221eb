"""ParaView plugin "Recon Map": what `recon map` does, on any data set with points.

Tools > Manage Plugins > Load New, or in pvpython LoadPlugin("recon_map.py", ns=globals()). The module `recon` must be found
by ParaView's Python (python3-recon, or PYTHONPATH). The output is an image: the fields at the nodes of a grid, and with
them the report of the fit of each node: neighbours, rank, degree, status (0 full, 1 reduced, 2 nearest, 3 no support, 4 too far),
gradient_rank, amplification, limited. A direction in which all points have the same coordinate is no axis.

The grid is that of the data at the time at which ParaView asks for its size. Nothing is wrapped: periodic
borders of a simulation are not known to a VTK data set.
"""
import numpy as np
from paraview.util.vtkAlgorithm import VTKPythonAlgorithmBase, smdomain, smproperty, smproxy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkDataArraySelection
from vtkmodules.vtkCommonDataModel import vtkDataSet, vtkImageData
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as Pipeline

import recon

METHODS = ("imls", "mls", "shepard")
REPORT = ("neighbours", "rank", "degree", "status", "smallest_pivot", "amplification", "gradient_rank",
          "gradient_amplification")


@smproxy.filter(name="ReconMap", label="Recon Map")
@smproperty.input(name="Input", port_index=0)
@smdomain.datatype(dataTypes=["vtkDataSet"], composite_data_supported=False)
class ReconMap(VTKPythonAlgorithmBase):
    """Least-squares reconstruction of point data on a grid."""

    def __init__(self):
        super().__init__(nInputPorts=1, nOutputPorts=1, outputType="vtkImageData")
        self._spacing = self._radius = 0.0
        self._degree, self._method, self._gradient, self._mass = 1, 0, False, "mass"
        self._arrays = vtkDataArraySelection()
        self._arrays.AddObserver("ModifiedEvent", lambda *_: self.Modified())
        self._grid = None

    def FillInputPortInformation(self, port, info):
        info.Set(self.INPUT_REQUIRED_DATA_TYPE(), "vtkDataSet")
        return 1

    # --- properties ------------------------------------------------------------------------------
    def _set(self, name, value):
        if getattr(self, name) != value:
            setattr(self, name, value)
            self.Modified()

    @smproperty.doublevector(name="Spacing", default_values=0.0)
    def SetSpacing(self, value):
        """Of the grid, a length; 0: the mean spacing of the points in their box."""
        self._set("_spacing", value)

    @smproperty.doublevector(name="Radius", default_values=0.0)
    def SetRadius(self, value):
        """Of the supports, a length; 0: the nearest points, three for each term of the fit."""
        self._set("_radius", value)

    @smproperty.intvector(name="Degree", default_values=1)
    @smdomain.intrange(min=0, max=4)
    def SetDegree(self, value):
        self._set("_degree", value)

    @smproperty.xml("""<IntVectorProperty name="Method" command="SetMethod" number_of_elements="1" default_values="0">
        <EnumerationDomain name="enum"><Entry value="0" text="imls"/><Entry value="1" text="mls"/>
        <Entry value="2" text="shepard"/></EnumerationDomain></IntVectorProperty>""")
    def SetMethod(self, value):
        self._set("_method", value)

    @smproperty.xml("""<IntVectorProperty name="Gradient" command="SetGradient" number_of_elements="1" default_values="0">
        <BooleanDomain name="bool"/></IntVectorProperty>""")
    def SetGradient(self, value):
        """Also the exact gradient of each field, as <field>_gradient."""
        self._set("_gradient", bool(value))

    @smproperty.stringvector(name="MassArray", default_values="mass")
    def SetMassArray(self, value):
        """Where there is such an array, and a Radius, `density` is the sum of mass times kernel."""
        self._set("_mass", value)

    @smproperty.dataarrayselection(name="Arrays")
    def GetArrays(self):
        return self._arrays

    # --- the pipeline ----------------------------------------------------------------------------
    def _points(self, data):
        """The points along the axes along which they vary, and these axes."""
        if isinstance(data, vtkImageData) or not hasattr(data, "GetPoints") or data.GetPoints() is None:
            points = np.array([data.GetPoint(i) for i in range(data.GetNumberOfPoints())]).reshape(-1, 3)
        else:
            points = vtk_to_numpy(data.GetPoints().GetData()).astype(np.float64)
        if len(points) == 0:
            raise ValueError("Recon Map: the input has no points")
        axes = [d for d in range(3) if np.ptp(points[:, d]) > 0]
        return points, axes or [0]

    def _choose_grid(self, points, axes):
        spacing = self._spacing
        if spacing <= 0:
            extent = np.ptp(points[:, axes], axis=0)
            spacing = float((extent.prod() / len(points)) ** (1 / len(axes))) or 1.0
        return recon.covering_grid(np.ascontiguousarray(points[:, axes]), spacing)

    def RequestInformation(self, request, inputs, outputs):
        # An image must tell its size before its data: so the input is asked for its points now.
        producer = self.GetInputConnection(0, 0)
        producer.GetProducer().Update()
        data = producer.GetProducer().GetOutputDataObject(producer.GetIndex())
        fields = data.GetPointData()
        for i in range(fields.GetNumberOfArrays()):
            if fields.GetArray(i) is not None:
                self._arrays.AddArray(fields.GetArrayName(i))
        points, axes = self._points(data)
        self._grid = self._choose_grid(points, axes), axes, points[0]
        grid, axes, place = self._grid
        self._extent, self._origin, self._steps = [0] * 6, list(place), [grid.spacing[0]] * 3
        for d, axis in enumerate(axes):
            self._extent[2 * axis + 1] = grid.counts[d] - 1
            self._origin[axis], self._steps[axis] = grid.origin[d], grid.spacing[d]
        out = outputs.GetInformationObject(0)
        out.Set(Pipeline.WHOLE_EXTENT(), self._extent, 6)
        out.Set(vtkImageData.ORIGIN(), self._origin, 3)
        out.Set(vtkImageData.SPACING(), self._steps, 3)
        return 1

    def RequestData(self, request, inputs, outputs):
        data = vtkDataSet.GetData(inputs[0], 0)
        image = vtkImageData.GetData(outputs, 0)
        points, _ = self._points(data)
        grid, axes, _ = self._grid
        points = np.ascontiguousarray(points[:, axes])
        degree = 0 if METHODS[self._method] == "shepard" else self._degree
        terms = {1: (1, 2, 3, 4, 5), 2: (1, 3, 6, 10, 15), 3: (1, 4, 10, 20, 35)}[len(axes)]
        support = ({"radius": self._radius} if self._radius > 0 else
                   {"nearest": min(3 * terms[max(degree, 1)], len(points))})
        fit = recon.reconstruct(points, grid.nodes(), degree=degree, method=METHODS[self._method],
                                max_distance=2, tolerances=recon.FitTolerances(leverage=2.5), **support)
        image.SetExtent(self._extent)
        image.SetOrigin(self._origin)
        image.SetSpacing(self._steps)

        def add(name, values):
            array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
            array.SetName(name)
            image.GetPointData().AddArray(array)

        limited = np.zeros(grid.size, dtype=np.int32)
        fields = data.GetPointData()
        for i in range(fields.GetNumberOfArrays()):
            name = fields.GetArrayName(i)
            if fields.GetArray(i) is None or not self._arrays.ArrayIsEnabled(name):
                continue
            values = vtk_to_numpy(fields.GetArray(i)).astype(np.float64)
            kept, count = fit.apply(values, limit="relaxed", return_count=True)
            limited += count.astype(np.int32)
            add(name, kept)
            if self._gradient:
                slopes = np.zeros((grid.size, values.reshape(len(points), -1).shape[1], 3))
                slopes[:, :, axes] = (fit.gradient() @ values).reshape(grid.size, -1, len(axes))
                add(name + "_gradient", slopes.reshape(grid.size, -1))
            if name == self._mass and self._radius > 0 and values.ndim == 1:
                add("density", recon.kernel_sum(points, grid.nodes(), values, radius=self._radius))
        for name in REPORT:
            values = fit.report[name]
            add(name, values if values.dtype.kind == "f" else values.astype(np.int32))
        add("limited", limited)
        return 1
