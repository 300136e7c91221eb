"""Small clouds of particles that the tests share."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def jittered(side: int, dimension: int, seed: int = 1) -> Array:
    """side^D particles in the unit cube, one to a cell and moved at random."""
    random = np.random.default_rng(seed)
    cells = np.stack(np.meshgrid(*[np.arange(side)] * dimension, indexing="ij"), axis=-1)
    corners = cells.reshape(-1, dimension).astype(float)
    return np.asarray((corners + 0.5 + 0.35 * random.uniform(-1, 1, corners.shape)) / side)


def inner(count: int, dimension: int, seed: int = 2) -> Array:
    """Points well inside of the unit cube."""
    return np.random.default_rng(seed).uniform(0.2, 0.8, (count, dimension))


def linear(x: Array) -> Array:
    """1 + 2 x - 3 y + 4 z, as far as there are axes."""
    slopes = np.array([2.0, -3.0, 4.0])[: x.shape[1]]
    return np.asarray(1 + x @ slopes)


def quadratic(x: Array) -> Array:
    return np.asarray(linear(x) + np.sum(x * x, axis=1) - x[:, 0] * x[:, -1])
