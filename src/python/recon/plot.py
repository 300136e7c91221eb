"""Pictures of results with matplotlib: fields on grids, profiles, and what became of the targets.

Each function draws into the axes that it is given, or into new ones, and returns them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from . import _recon
from .enumerators import FitStatus
from .functions import GridReconstruction

__all__ = ["field", "profile", "report"]


def _axes(axes: Any) -> Any:
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt

    return plt.subplots(layout="constrained")[1]


def field(
    grid: _recon.StructuredGrid | GridReconstruction,
    values: npt.ArrayLike | str | None = None,
    *,
    points: npt.ArrayLike | None = None,
    axes: Any = None,
    label: str = "",
    **options: Any,
) -> Any:
    """A field at the nodes of a grid in 2-D: each node colours a cell around it; NaN is grey.

    Parameters
    ----------
    grid : StructuredGrid or GridReconstruction
    values : array, shape (nx, ny) or (nx * ny,), or the name of a field of the result
    points : array_like, shape (n, 2), optional
        Drawn as dots.
    axes : matplotlib axes, optional
    label : str
        Of the colours.
    **options
        Those of ``axes.pcolormesh``.

    Returns
    -------
    matplotlib axes
    """
    if isinstance(grid, GridReconstruction):
        values = grid.values if values is None else grid[values] if isinstance(values, str) else values
        grid = grid.grid
    if grid.dimension != 2:
        raise _recon.InvalidArgument(
            f"dimension of the grid = {grid.dimension}: must be 2; take a slice of the values first"
        )
    shown = np.asarray(values, dtype=float)
    if shown.shape == (grid.size,):
        shown = grid.reshape(shown)
    if shown.shape != tuple(grid.shape):
        raise _recon.InvalidArgument(
            f"values = an array of shape {shown.shape}: must be one number for each node, {grid.shape}"
        )
    axes = _axes(axes)
    axes.set_facecolor("0.8")
    mesh = axes.pcolormesh(*grid.axes, np.ma.masked_invalid(shown).T, shading="nearest", **options)  # type: ignore[no-untyped-call]
    if points is not None:
        at = np.asarray(points)
        axes.plot(at[:, 0], at[:, 1], ".", color="k", markersize=1.5, alpha=0.5)
    axes.set_aspect("equal")
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    axes.figure.colorbar(mesh, ax=axes, label=label)
    return axes


def profile(
    coordinates: npt.ArrayLike,
    values: npt.ArrayLike,
    *,
    uncertainty: npt.ArrayLike | None = None,
    axes: Any = None,
    label: str = "",
    **options: Any,
) -> Any:
    """A curve of values along a line, with a band of their uncertainty around it.

    Parameters
    ----------
    coordinates, values : array_like, shape (m,)
    uncertainty : array_like, shape (m,), optional
        Half the width of the band.
    axes : matplotlib axes, optional
    label : str
        In the legend.
    **options
        Those of ``axes.plot``.

    Returns
    -------
    matplotlib axes
    """
    x, y = np.asarray(coordinates, dtype=float), np.asarray(values, dtype=float)
    axes = _axes(axes)
    (line,) = axes.plot(x, y, label=label or None, **options)
    if uncertainty is not None:
        half = np.asarray(uncertainty, dtype=float)
        axes.fill_between(x, y - half, y + half, color=line.get_color(), alpha=0.25, linewidth=0)
    if label:
        axes.legend()
    return axes


def report(
    result: _recon.Reconstruction | GridReconstruction,
    name: str = "degree",
    *,
    targets: npt.ArrayLike | None = None,
    axes: Any = None,
) -> Any:
    """What became of each target: on a grid in 2-D as a field, else as dots at the targets or as a histogram.

    Parameters
    ----------
    result : Reconstruction or GridReconstruction
    name : str
        A member of the report: "degree", "status", "neighbours", "amplification", ...
    targets : array_like, shape (m, 2), optional
        Where the targets are, for a reconstruction that was not made for a grid.

    Returns
    -------
    matplotlib axes
    """
    numbers = result.report[name]
    grid = result.grid
    if grid is not None and grid.dimension == 2:
        axes = field(grid, grid.reshape(numbers), axes=axes, label=name)
    elif targets is not None:
        at = np.asarray(targets)
        axes = _axes(axes)
        dots = axes.scatter(at[:, 0], at[:, 1], c=numbers, s=6)
        axes.set_aspect("equal")
        axes.figure.colorbar(dots, ax=axes, label=name)
    else:
        axes = _axes(axes)
        whole = numbers.dtype.kind in "iu"
        bins: Any = np.arange(int(numbers.min()), int(numbers.max()) + 2) - 0.5 if whole else 40
        axes.hist(numbers, bins=bins)
        axes.set_xlabel(name)
        axes.set_ylabel("targets")
        if name == "status":
            axes.set_xticks([int(s) for s in FitStatus], [s.name for s in FitStatus])
    return axes
