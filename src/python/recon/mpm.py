"""The material point method: a problem file, run step by step, with particles and nodes as arrays.

    simulation = recon.mpm.Simulation("examples/mpm/disks.toml", method="cpls")
    simulation.run_until(0.5)
    x, v = simulation.particles["x"], simulation.particles["v"]
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any, Union

import numpy.typing as npt

from . import _recon
from ._recon import Failure

__all__ = ["Failure", "Simulation", "methods"]

Path = Union[str, "os.PathLike[str]"]


def methods() -> list[str]:
    """The names of all methods; docs/methods.md says which one when."""
    return _recon.mpm_methods()


class Particles(Mapping[str, "npt.NDArray[Any]"]):
    """What particles carry, as arrays of the present state: each is made when it is asked for.

    x and X (positions now and at the start, lengths), v (velocities, half a step earlier) of shape (n, D); F, L,
    stress, half_edges of shape (n, D, D), in 1-D (n, 1); mass, volume0, energy, body of shape (n,); and what the
    method keeps beside these.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._simulation.particle_array(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._simulation.particle_arrays())

    def __len__(self) -> int:
        return len(self._simulation.particle_arrays())


class Nodes(Mapping[str, "npt.NDArray[Any]"]):
    """mass (n,), velocity and force (n, D) at the nodes, in their flat order: see `Simulation.grid`."""

    _names = ("mass", "velocity", "force")

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        return self._simulation.node_array(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


class Simulation(_recon.Simulation):
    """A problem of the material point method, step by step.

    Parameters
    ----------
    problem : path
        A TOML file; docs/mpm.md lists its keys.
    settings : mapping, optional
        Values that replace those of the file: ``{"grid.cells": 40, "method.name": "cpls"}``.
    **more
        The same where a name alone says which key is meant: ``cells=40``, and ``method="cpls"`` for its name.

    Attributes
    ----------
    time, steps, end, dimension, size, title, method, grid
    particles, nodes : mappings of names to arrays

    Raises
    ------
    FileError
        For everything that is wrong with the file or the settings: file, line, key and the valid choices.

    Examples
    --------
    >>> simulation = Simulation("examples/mpm/disks.toml", cells=40)
    >>> while simulation.time < simulation.end:
    ...     dt = simulation.step()
    """

    def __init__(
        self, problem: Path, settings: Mapping[str, Any] | None = None, **more: Any
    ) -> None:
        if "method" in more:
            more["method.name"] = more.pop("method")
        texts = [f"{key}={_toml(value)}" for key, value in {**(settings or {}), **more}.items()]
        super().__init__(problem, texts)

    @property
    def particles(self) -> Particles:
        return Particles(self)

    @property
    def nodes(self) -> Nodes:
        return Nodes(self)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_toml(each) for each in value) + "]"
    if isinstance(value, str):
        return value
    return repr(getattr(value, "item", lambda: value)())
