#!/usr/bin/python3
"""Other programs on the workload "cloud" of recon-bench: time per target and error.

    bench/peers.py [--quick] OUTPUT.csv

vtkPointInterpolator (VTK) with a Shepard and a Gaussian kernel over the k closest points, and
RBFInterpolator (SciPy) with k neighbours. Packages that are missing are skipped with a note. The points
are the very ones of recon-bench: the same generator with the same seeds.

Not compared: PCL's moving least squares projects points onto a surface and CGAL interpolates over a
Delaunay triangulation, so neither answers the question that recon is asked.
"""
import csv
import sys
import time

COLUMNS = ["program", "method", "sources", "targets", "k", "us per target", "rms error", "note"]
SOURCES, TARGETS = 200000, 100000
RBF_TARGETS, QUICK_RBF_TARGETS = 20000, 2000   # of the first targets: it takes long
SOURCE_SEED, TARGET_SEED = 1, 2
REPETITIONS = 3


def progress(text):
    print("  peers: " + text, file=sys.stderr, flush=True)


def random_points(np, count, dimension, seed):
    """Uniform in the unit cube: splitmix64, as recon/points/generate.hpp has it."""
    n = np.arange(1, count * dimension + 1, dtype=np.uint64)
    z = np.uint64(seed) + n * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return ((z >> np.uint64(11)).astype(np.float64) * 2.0 ** -53).reshape(count, dimension)


def best_time(run):
    """Least seconds of several runs, and the last result."""
    best, result = None, None
    for _ in range(REPETITIONS):
        begin = time.perf_counter()
        result = run()
        seconds = time.perf_counter() - begin
        best = seconds if best is None else min(best, seconds)
    return best, result


def vtk_rows(np, sources, u, targets, exact):
    try:
        from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkPoints, vtkSMPTools
        from vtkmodules.vtkCommonDataModel import vtkPolyData
        from vtkmodules.vtkFiltersPoints import (vtkGaussianKernel, vtkPointInterpolator,
                                                 vtkShepardKernel)
    except ImportError as error:
        return [["VTK", "", "", "", "", "-", "-", f"skipped: {error} (Debian: python3-vtk9)"]]

    def poly_data(points):
        data, vtk_points = vtkPolyData(), vtkPoints()
        vtk_points.SetDataTypeToDouble()
        vtk_points.SetData(numpy_to_vtk(points, deep=True))
        data.SetPoints(vtk_points)
        return data

    source, target = poly_data(sources), poly_data(targets)
    field = numpy_to_vtk(u, deep=True)
    field.SetName("u")
    source.GetPointData().AddArray(field)
    backend = vtkSMPTools.GetBackend()
    threads = 1 if backend == "Sequential" else vtkSMPTools.GetEstimatedNumberOfThreads()
    spacing = len(sources) ** (-1 / 3)

    def interpolate(kernel, k):
        kernel.SetKernelFootprintToNClosest()
        kernel.SetNumberOfPoints(k)
        filter_ = vtkPointInterpolator()
        filter_.SetInputData(target)
        filter_.SetSourceData(source)
        filter_.SetKernel(kernel)
        filter_.Update()
        return vtk_to_numpy(filter_.GetOutput().GetPointData().GetArray("u"))

    def gaussian():
        kernel = vtkGaussianKernel()
        kernel.SetRadius(1.5 * spacing)
        kernel.SetSharpness(2)
        return kernel

    rows = []
    for name, make in (("Shepard, power 2", vtkShepardKernel), ("Gaussian", gaussian)):
        for k in (8, 20):
            progress(f"VTK {name}, k = {k}")
            seconds, values = best_time(lambda: interpolate(make(), k))
            rms = np.sqrt(np.mean((values - exact) ** 2))
            rows.append(["VTK", name, len(sources), len(targets), k,
                         f"{seconds / len(targets) * 1e6:.4g}", f"{rms:.3g}",
                         f"a weighted mean: compare with degree 0; search included; "
                         f"{threads} threads ({backend})"])
    return rows


def scipy_rows(np, sources, u, targets, exact):
    try:
        from scipy.interpolate import RBFInterpolator
    except ImportError as error:
        return [["SciPy", "", "", "", "", "-", "-", f"skipped: {error} (Debian: python3-scipy)"]]
    rows = []
    for k, degree, kernel in ((8, 1, "thin_plate_spline"), (20, 1, "thin_plate_spline"),
                              (20, 2, "quintic")):
        progress(f"SciPy {kernel}, degree {degree}, k = {k}")

        begin = time.perf_counter()
        interpolator = RBFInterpolator(sources, u, neighbors=k, kernel=kernel, degree=degree)
        built = time.perf_counter()
        values = interpolator(targets)
        evaluated = time.perf_counter()
        # The search is built once: its cost is spread over all targets, not over these few.
        seconds = (built - begin) / TARGETS + (evaluated - built) / len(targets)
        rms = np.sqrt(np.mean((values - exact) ** 2))
        rows.append(["SciPy", f"RBFInterpolator, {kernel}, degree {degree}", len(sources), len(targets), k,
                     f"{seconds * 1e6:.4g}", f"{rms:.3g}",
                     "interpolates the k nearest (no fit: noise passes through) and solves k + terms "
                     "unknowns per target; reproduces the same polynomials; search included; one thread"])
    return rows


def main():
    arguments = [a for a in sys.argv[1:] if a != "--quick"]
    quick = "--quick" in sys.argv[1:]
    if len(arguments) != 1 or arguments[0].startswith("-"):
        sys.exit("usage: bench/peers.py [--quick] OUTPUT.csv")
    try:
        import numpy as np
    except ImportError as error:
        rows = [["all", "", "", "", "", "-", "-", f"skipped: {error} (Debian: python3-numpy)"]]
    else:
        def field(x):
            return np.prod(np.sin(2 * np.pi * x), axis=1)

        sources = random_points(np, SOURCES, 3, SOURCE_SEED)
        targets = 0.1 + 0.8 * random_points(np, TARGETS, 3, TARGET_SEED)
        exact = field(targets)
        few = QUICK_RBF_TARGETS if quick else RBF_TARGETS
        rows = vtk_rows(np, sources, field(sources), targets, exact)
        rows += scipy_rows(np, sources, field(sources), targets[:few], exact[:few])
    with open(arguments[0], "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


if __name__ == "__main__":
    main()
