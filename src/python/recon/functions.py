"""The functions of the module: their arguments by name, with the texts that explain them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _recon
from .enumerators import Derivative, Limit, SearchMethod, Solver, Unsupported, Weight, WeightForm

Points = Union[npt.ArrayLike, "tuple[npt.ArrayLike, ...]", _recon.Sources, _recon.ParticleTable]
Targets = Union[npt.ArrayLike, "tuple[npt.ArrayLike, ...]", _recon.StructuredGrid]
Rule = Union[
    _recon.Radius,
    _recon.Radii,
    _recon.Nearest,
    _recon.NearestWithin,
    _recon.PairRadii,
    _recon.Ellipsoids,
    _recon.PairEllipsoids,
    _recon.NeighbourList,
]
AnyWeight = Union[str, Weight, _recon.Gaussian, _recon.InverseDistance, "_recon.OwnWeight"]
Path = Union[str, "os.PathLike[str]"]


def reconstruct(
    points: Points,
    targets: Targets,
    *,
    degree: int | None = None,
    method: str | None = None,
    radius: float | None = None,
    nearest: int | None = None,
    neighbours: Rule | None = None,
    weight: AnyWeight | None = None,
    form: str | WeightForm | None = None,
    solver: str | Solver | None = None,
    particle_weights: npt.ArrayLike | None = None,
    stretch: npt.ArrayLike | None = None,
    domain: _recon.PeriodicDomain | None = None,
    search: str | SearchMethod | None = None,
    visible: Callable[[int, int], bool] | None = None,
    max_distance: float | None = None,
    grow: int | _recon.Growth | None = None,
    unsupported: str | Unsupported | None = None,
    fill_value: float | None = None,
    tolerances: _recon.FitTolerances | None = None,
    threads: int | None = None,
    instruction_set: str | None = None,
    progress: Callable[[float], bool | None] | None = None,
    **others: Any,
) -> _recon.Reconstruction:
    """Scattered particle data become a field at all targets.

    At each target x the particles in its support, of radius rho, are fitted with a polynomial p of the
    asked degree,

        minimise  sum_p w(|x_p - x| / rho) (p(x_p) - u_p)^2 ,

    and p(x) is a linear combination sum_p phi_p(x) u_p of the data, whatever these are.

    Parameters
    ----------
    points : array_like, shape (n, D) or (n,), a tuple of D arrays, Sources or ParticleTable
        Where the particles are, lengths; D is 1, 2 or 3.
    targets : array_like, shape (m, D) or (m,), a tuple of D arrays, or StructuredGrid
        Where the field is asked for.
    degree : int
        Polynomials up to this degree, 0 to 4, are reproduced. Default 1.
    method : {"imls", "mls", "shepard"}
        Short forms: the solver gram_schmidt, moment_matrix; degree 0.
    radius : float
        The support radius, a length: the same as ``neighbours=Radius(radius)``.
    nearest : int
        The number of nearest particles; with `radius` those of them that lie within it.
    neighbours : Radius, Radii, Nearest, NearestWithin, PairRadii, Ellipsoids, PairEllipsoids or NeighbourList
        By default the nearest 2 * terms + 1; for a grid the natural support of the B-spline.
    weight : str, Weight, Gaussian, InverseDistance or an object with __call__(q) and derivative(q)
        w(q), default "cubic_b_spline".
    form : {"radial", "tensor_product"}
        Default radial, for a grid tensor_product.
    solver : {"gram_schmidt", "moment_matrix", "qr", "svd"}
    particle_weights : array_like, shape (n,)
        Positive numbers that multiply w(q): the masses of the particles, for example.
    stretch : array_like, shape (D,)
        Along axis d supports are rho * stretch[d].
    domain : PeriodicDomain
    search : {"automatic", "cell_grid", "kd_tree", "r_tree", "brute_force"}
    visible : callable
        ``visible(target, particle)`` is False where a particle is hidden. Called for each pair: slow.
    max_distance : float
        Targets farther from every particle than this many local spacings get `fill_value`.
    grow : int or Growth
        Supports grow up to so many times where the degree is not reached.
    unsupported : {"fill", "nearest"}
    fill_value : float
        The value of targets without a particle, default NaN.
    tolerances : FitTolerances
    threads : int
        0: all there are. The results do not depend on it.
    instruction_set : {"automatic", "generic", "avx2", "avx512"}
    progress : callable
        ``progress(fraction)`` is called at most ten times per second. False cancels the call.

    Returns
    -------
    Reconstruction
        An operator: ``fit @ u``, ``fit.T @ f``, ``fit.gradient()``, ``fit.report``. It has the precision of the
        points; of points and targets of different precision it has float64.

    Raises
    ------
    InvalidArgument
        For options out of range, unknown names, and coordinates that are not finite, naming argument, value
        and rule. domain, stretch and particle_weights belong to Sources, where these are given.
    Cancelled
        Where `progress` has returned False.

    Examples
    --------
    >>> fit = reconstruct(points, nodes, degree=1, method="imls", radius=2 * h)
    >>> v = fit @ velocity
    """
    options = {
        "degree": degree,
        "method": method,
        "radius": radius,
        "nearest": nearest,
        "neighbours": neighbours,
        "weight": weight,
        "form": form,
        "solver": solver,
        "particle_weights": particle_weights,
        "stretch": stretch,
        "domain": domain,
        "search": search,
        "visible": visible,
        "max_distance": max_distance,
        "grow": grow,
        "unsupported": unsupported,
        "fill_value": fill_value,
        "tolerances": tolerances,
        "threads": threads,
        "instruction_set": instruction_set,
        "progress": progress,
    }
    return _recon.reconstruct(points, targets, {**options, **others})


class GridReconstruction:
    """Values at the nodes of a grid: made by `on_grid`.

    Attributes
    ----------
    grid : StructuredGrid
    values : array, or dict of arrays
        Shape (nx, ny, nz, ...) as far as there are axes, with the shape of a field's values behind; a dict
        where the fields were given as one. Also ``result["name"]``.
    gradients : array, dict of arrays or None
        The same with one more axis at the end, of length D, 1/length.
    report : FitReports
        In the flat order of the nodes: ``grid.reshape(report.degree)`` has the shape of the grid.
    limited : array or None
        Of how many components the limit changed the value, in the shape of the grid.
    """

    def __init__(
        self,
        grid: _recon.StructuredGrid,
        values: Any,
        gradients: Any,
        report: _recon.FitReports,
        limited: Any,
    ) -> None:
        self.grid = grid
        self.values = values
        self.gradients = gradients
        self.report = report
        self.limited = limited

    def __repr__(self) -> str:
        names = f" of {', '.join(self.values)}" if isinstance(self.values, dict) else ""
        return f"<recon.GridReconstruction{names} at {self.grid!r}>"

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        if not isinstance(self.values, dict):
            raise KeyError(f"{name!r}: the fields of this result have no names")
        if name not in self.values:
            raise KeyError(f"{name!r}; there are {', '.join(self.values)}")
        found: npt.NDArray[Any] = self.values[name]
        return found

    def to_dict(self) -> dict[str, Any]:
        """Coordinates and fields in the form that ``xarray.Dataset.from_dict`` takes."""
        axes = ["x", "y", "z"][: self.grid.dimension]
        data: dict[str, Any] = {}

        def add(name: str, array: npt.NDArray[Any], more: list[str], prefix: str = "") -> None:
            extra = [f"{name}_{i}" for i in range(array.ndim - len(axes) - len(more))]
            data[prefix + name] = {"dims": (*axes, *extra, *more), "data": array}

        for name, array in _named(self.values).items():
            add(name, array, [])
        if self.gradients is not None:
            for name, array in _named(self.gradients).items():
                add(name, array, ["axis"], "gradient_of_")
        for name in ("degree", "status", "neighbours"):
            add(name, self.grid.reshape(self.report[name]), [])
        coordinates = {
            name: {"dims": (name,), "data": axis} for name, axis in zip(axes, self.grid.axes)
        }
        return {"coords": coordinates, "dims": dict(zip(axes, self.grid.shape)), "data_vars": data}


def _named(fields: Any) -> dict[str, npt.NDArray[Any]]:
    return fields if isinstance(fields, dict) else {"value": fields}


def on_grid(
    points: Points,
    fields: npt.ArrayLike | Mapping[str, npt.ArrayLike],
    grid: _recon.StructuredGrid | float,
    *,
    gradients: str | Derivative | None = None,
    limit: str | Limit = "none",
    **options: Any,
) -> GridReconstruction:
    """Particle data at the nodes of a regular grid, mostly without lists of neighbours.

    Parameters
    ----------
    points : array_like, shape (n, D), a tuple of D arrays, Sources or ParticleTable
    fields : array_like, shape (n,) or (n, ...), or a dict of such arrays
    grid : StructuredGrid or float
        A number is the spacing of a grid that covers the points, a length.
    gradients : {"diffuse", "exact"}, optional
        Of the local polynomial, or of the reconstructed field.
    limit : {"none", "range", "relaxed"}
        Keeps values in or near the range of the data that they are made of.
    **options
        Those of `reconstruct`. By default tensor products of cubic B-splines of the natural support.

    Returns
    -------
    GridReconstruction

    Raises
    ------
    InvalidArgument
        As `reconstruct`, and for a value that is not finite, naming the particle and the component.
    """
    if not isinstance(grid, _recon.StructuredGrid):
        if isinstance(points, _recon.Sources):
            raise _recon.InvalidArgument(
                f"grid = {grid}: must be a StructuredGrid for Sources: covering_grid(points, spacing)"
            )
        grid = _recon.covering_grid(points, grid, options.get("domain"))
    many = isinstance(fields, Mapping)
    if isinstance(fields, Mapping) and not fields:
        raise _recon.InvalidArgument("fields = {}: must be at least one")
    arrays = list(fields.values()) if isinstance(fields, Mapping) else [fields]
    values, slopes, shapes, report, limited = _recon.on_grid(
        points, arrays, grid, options, gradients, limit
    )
    parts: list[npt.NDArray[Any]] = []
    slope_parts: list[npt.NDArray[Any]] = []
    first = 0
    nodes = tuple(grid.shape)
    for shape in shapes:
        count = int(np.prod(shape, dtype=int))
        parts.append(_components(values, first, count, nodes + shape))
        if slopes is not None:
            D = grid.dimension
            slope_parts.append(_components(slopes, first * D, count * D, nodes + shape + (D,)))
        first += count
    flags = None if limited is None else grid.reshape(limited)
    if many:
        names = list(fields)  # type: ignore[arg-type]
        by_name = dict(zip(names, slope_parts)) if slopes is not None else None
        return GridReconstruction(grid, dict(zip(names, parts)), by_name, report, flags)
    return GridReconstruction(grid, parts[0], slope_parts[0] if slope_parts else None, report, flags)


def _components(
    array: npt.NDArray[Any], first: int, count: int, shape: tuple[int, ...]
) -> npt.NDArray[Any]:
    """Some columns of an array of shape (nx, ny, nz, columns), a view in this shape.

    The last of the axes of a value runs fastest among the columns.
    """
    nodes = array.ndim - 1
    part = array[..., first : first + count]
    step = part.strides[-1]
    strides: list[int] = []
    for length in reversed(shape[nodes:]):
        strides.insert(0, step)
        step *= length
    return np.lib.stride_tricks.as_strided(part, shape, part.strides[:nodes] + tuple(strides))


def _sources(points: Any) -> _recon.Sources:
    return points if isinstance(points, _recon.Sources) else _recon.Sources(points)


def find_neighbours(
    sources: Points,
    targets: Targets,
    neighbours: Rule | None = None,
    *,
    radius: float | None = None,
    nearest: int | None = None,
    shape: str = "ball",
    search: str | SearchMethod = "automatic",
    threads: int = 0,
    progress: Callable[[float], bool | None] | None = None,
) -> _recon.NeighbourList:
    """The neighbours of all targets, in the rows of the caller's points.

    Parameters
    ----------
    sources : Sources or array_like, shape (n, D)
    targets : array_like, shape (m, D)
    neighbours : Radius, Radii, Nearest, NearestWithin, PairRadii, Ellipsoids or PairEllipsoids
    radius, nearest : optional
        Short forms of these.
    shape : {"ball", "cube"}

    Returns
    -------
    NeighbourList
        Its arrays offsets, indices and support; in periodic domains shifts.
    """
    return _recon.find_neighbours(
        _sources(sources), targets, neighbours, radius, nearest, shape, search, threads, progress
    )


def kernel_operator(
    sources: Points,
    targets: Targets,
    *,
    weight: AnyWeight = "cubic_b_spline",
    form: str | WeightForm = "radial",
    neighbours: Rule | None = None,
    radius: float | None = None,
    nearest: int | None = None,
    search: str | SearchMethod = "automatic",
    threads: int = 0,
) -> _recon.Operator:
    """Sums over kernels with unit integral, as an operator: ``op @ mass`` is the density.

        s(x) = sum_p a_p W(x - x_p) ,   W = w(q) / (c rho^D) ,   c = integral of w over the unit support

    Parameters
    ----------
    sources : Sources or array_like, shape (n, D)
    targets : array_like, shape (m, D), or StructuredGrid
    weight, form
        As in `reconstruct`.
    neighbours, radius, nearest
        The support; by default that of the 20 nearest.

    Returns
    -------
    Operator
        Of shape (m, n), 1 / length^D.
    """
    return _recon.kernel_operator(
        _sources(sources), targets, weight, form, neighbours, radius, nearest, search, threads
    )


def kernel_sum(
    sources: Points,
    targets: Targets,
    amounts: npt.ArrayLike,
    *,
    weight: AnyWeight = "cubic_b_spline",
    form: str | WeightForm = "radial",
    neighbours: Rule | None = None,
    radius: float | None = None,
    nearest: int | None = None,
    threads: int = 0,
) -> npt.NDArray[Any]:
    """How much of something lies at each target, per volume: see `kernel_operator`.

    Parameters
    ----------
    amounts : array_like, shape (n,) or (n, ...)
        Masses for the density, ones for the number density, volumes for the solid fraction.

    Returns
    -------
    array, shape (m,) or (m, ...)
        Unit of the amounts / length^D.
    """
    operator = kernel_operator(
        sources,
        targets,
        weight=weight,
        form=form,
        neighbours=neighbours,
        radius=radius,
        nearest=nearest,
        threads=threads,
    )
    return operator @ amounts


def read(
    path: Path,
    frame: int = -1,
    *,
    step: int | None = None,
    time: float | None = None,
    columns: Sequence[str] | None = None,
    skip_rows: int = 0,
    missing: Iterable[str] | None = None,
    group: str = "",
) -> _recon.ParticleTable:
    """The particles of one frame of a file, of any format that recon reads.

    Parameters
    ----------
    path : path
        A LAMMPS text dump, delimited text with a line of names, XYZ, VTK (legacy or XML) or HDF5
        (H5MD, openPMD); gzipped or not.
    frame : int
        Counted from 0, or from the end; -1 is the last.
    step : int, optional
    time : float, optional
        The frame of this step or time instead.
    columns : sequence of str, optional
        Names of all columns, which replace those of the file.
    skip_rows : int
        The number of lines to skip at the beginning.
    missing : iterable of str, optional
        What marks a cell without a value.
    group : str
        In HDF5 the group of particles or their species, where there are several.

    Returns
    -------
    ParticleTable
        A mapping of names to arrays; it can stand for points.

    Raises
    ------
    FileError
        Naming file, line and rule.
    """
    return _recon.read_particles(
        path,
        frame,
        step,
        time,
        None if columns is None else list(columns),
        skip_rows,
        None if missing is None else list(missing),
        group,
    )


def read_frames(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    skip_rows: int = 0,
    missing: Iterable[str] | None = None,
    group: str = "",
) -> Iterator[_recon.ParticleTable]:
    """All frames of a file, one after the other, with the memory of one."""
    return _recon.FrameReader(
        path,
        columns=None if columns is None else list(columns),
        skip_rows=skip_rows,
        missing=None if missing is None else list(missing),
        group=group,
    )


def list_frames(
    path: Path, *, columns: Sequence[str] | None = None, skip_rows: int = 0, group: str = ""
) -> list[dict[str, Any]]:
    """What frames a file has: a dict for each, of step, time, particles, columns, line, units."""
    return _recon.list_frames(path, None if columns is None else list(columns), skip_rows, group)


def write(
    path: Path,
    where: Targets | _recon.ParticleTable,
    fields: Mapping[str, npt.ArrayLike],
    *,
    step: int | None = None,
    time: float | None = None,
) -> None:
    """Fields into a file: .vti or .csv at the nodes of a grid, .vtp or .csv at points.

    Parameters
    ----------
    path : path
    where : StructuredGrid, or array_like of shape (n, D)
    fields : mapping of names to arrays
        Shape (n, ...); at the nodes of a grid also (nx, ny, nz, ...). As many components as dimensions are a
        vector, their square a tensor. Integers are written as int32, float32 as float32.
    step, time : optional
        What the fields belong to.

    Raises
    ------
    FileError
        Where the file cannot be written; it is written whole or not at all.
    InvalidArgument
        For fields that are not one value per point.
    """
    flat: dict[str, Any] = {}
    for name, field in fields.items():
        array = field if isinstance(field, tuple) else np.asanyarray(field)
        if isinstance(where, _recon.StructuredGrid) and isinstance(array, np.ndarray):
            D = where.dimension
            if D > 1 and array.ndim >= D and array.shape[:D] == tuple(where.shape):
                axes = tuple(range(D - 1, -1, -1)) + tuple(range(D, array.ndim))
                array = array.transpose(axes).reshape((where.size, *array.shape[D:]))
        flat[name] = array
    _recon.write(path, where, flat, step, time)
