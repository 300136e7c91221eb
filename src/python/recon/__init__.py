"""Scattered particle data become fields: values, gradients and operators at grid nodes or any points.

    import recon

    sources = recon.Sources(points)                      # an array of shape (n, D), read where it lies
    fit = recon.reconstruct(sources, targets, degree=1, radius=2 * h)
    v = fit @ velocity                                   # a row per target
    grad_v = fit.gradient() @ velocity                   # [target, component, axis]
    force = fit.T @ nodal_force                          # a row per particle
    print(fit.report.summary())

Names are those of the C++ library. Lengths and data are in any consistent units. Wrong input raises
InvalidArgument (a ValueError) that names the argument, the value and the rule; numerical outcomes stand in
`fit.report`. `recon.mpm` runs the material point method, `recon.plot` draws (with matplotlib). Long calls release the interpreter's lock, and all objects can be used by several threads.
"""

from . import mpm, plot
from ._recon import (
    Cancelled,
    FileError,
    FitReports,
    FitTolerances,
    FrameReader,
    Functional,
    Gaussian,
    Growth,
    InvalidArgument,
    InverseDistance,
    Nearest,
    NearestWithin,
    NeighbourList,
    Operator,
    PairRadii,
    ParticleTable,
    PeriodicDomain,
    Radii,
    Radius,
    Reconstruction,
    Sources,
    StructuredGrid,
    TransposedReconstruction,
    __version__,
    cell_centres,
    covering_grid,
    default_threads,
)
from .enumerators import (
    Derivative,
    FitStatus,
    Limit,
    SearchMethod,
    Solver,
    Unsupported,
    Weight,
    WeightForm,
)
from .functions import (
    GridReconstruction,
    find_neighbours,
    kernel_operator,
    kernel_sum,
    list_frames,
    on_grid,
    read,
    read_frames,
    reconstruct,
    write,
)

__all__ = [
    "Cancelled",
    "Derivative",
    "FileError",
    "FitReports",
    "FitStatus",
    "FitTolerances",
    "FrameReader",
    "Functional",
    "Gaussian",
    "GridReconstruction",
    "Growth",
    "InvalidArgument",
    "InverseDistance",
    "Limit",
    "Nearest",
    "NearestWithin",
    "NeighbourList",
    "Operator",
    "PairRadii",
    "ParticleTable",
    "PeriodicDomain",
    "Radii",
    "Radius",
    "Reconstruction",
    "SearchMethod",
    "Solver",
    "Sources",
    "StructuredGrid",
    "TransposedReconstruction",
    "Unsupported",
    "Weight",
    "WeightForm",
    "__version__",
    "cell_centres",
    "covering_grid",
    "default_threads",
    "find_neighbours",
    "kernel_operator",
    "kernel_sum",
    "list_frames",
    "mpm",
    "plot",
    "on_grid",
    "read",
    "read_frames",
    "reconstruct",
    "write",
]

# Messages and pickles call things by the names that users know.
for _name in __all__:
    if isinstance(globals()[_name], type) and getattr(globals()[_name], "__module__", "").startswith("recon."):
        globals()[_name].__module__ = "recon"
del _name
