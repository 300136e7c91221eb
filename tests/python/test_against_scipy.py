"""What SciPy does of it, recon does as well: neighbours, and fields between scattered points."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator, griddata
from scipy.spatial import cKDTree

import recon
from clouds import Array, inner, jittered, linear


def smooth(x: Array) -> Array:
    return np.asarray(np.sin(3 * x[:, 0]) * np.cos(2 * x[:, 1]) + 0.3 * x[:, 0] * x[:, 1])


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("search", list(recon.SearchMethod))
def test_neighbours_are_those_of_a_tree(dimension: int, search: recon.SearchMethod) -> None:
    x = np.random.default_rng(8).uniform(size=(2000, dimension))
    t = inner(100, dimension)
    tree = cKDTree(x)
    radius = {1: 0.02, 2: 0.08, 3: 0.2}[dimension]
    found = recon.find_neighbours(recon.Sources(x), t, radius=radius, search=search)
    for i, expected in enumerate(tree.query_ball_point(t, radius)):
        assert sorted(found.indices[found.offsets[i] : found.offsets[i + 1]]) == sorted(expected)
    nearest = recon.find_neighbours(recon.Sources(x), t, nearest=12, search=search)
    distance, expected = tree.query(t, 12)
    np.testing.assert_array_equal(nearest.indices.reshape(100, 12), expected)
    np.testing.assert_allclose(nearest.support, 1.5 * distance[:, -1], rtol=1e-14)


def test_periodic_neighbours_are_those_of_a_periodic_tree() -> None:
    x = np.random.default_rng(9).uniform(size=(1500, 2))
    t = np.random.default_rng(10).uniform(size=(60, 2))
    sources = recon.Sources(x, domain=recon.PeriodicDomain((0, 0), (1, 1)))
    found = recon.find_neighbours(sources, t, radius=0.1)
    for i, expected in enumerate(cKDTree(x, boxsize=1).query_ball_point(t, 0.1)):
        assert sorted(found.indices[found.offsets[i] : found.offsets[i + 1]]) == sorted(expected)


def test_linear_fields_are_those_of_griddata() -> None:
    x, t = jittered(20, 2), inner(200, 2)
    u = linear(x)
    np.testing.assert_allclose(
        recon.reconstruct(x, t) @ u, griddata(x, u, t, method="linear"), rtol=1e-10
    )


def test_smooth_fields_are_no_worse_than_those_of_scipy() -> None:
    x, t = jittered(30, 2), inner(500, 2)
    u, exact = smooth(x), smooth(t)

    def error(values: Array) -> float:
        return float(np.sqrt(np.mean((values - exact) ** 2)))

    linear_scipy = error(griddata(x, u, t, method="linear"))
    cubic_scipy = error(griddata(x, u, t, method="cubic"))
    thin_plate = error(RBFInterpolator(x, u, neighbors=20)(t))
    degrees = [error(recon.reconstruct(x, t, degree=d) @ u) for d in range(5)]
    assert degrees[0] > degrees[1] > degrees[2] > degrees[3] > degrees[4]
    # A fit of degree 1 smooths what a triangulation interpolates: the same order, a larger constant.
    assert degrees[1] < 5 * linear_scipy
    assert degrees[2] < linear_scipy and degrees[3] < cubic_scipy and degrees[4] < thin_plate


def test_noise_is_averaged_where_interpolants_keep_it() -> None:
    x, t = jittered(40, 2), inner(300, 2)
    noisy = smooth(x) + 0.1 * np.random.default_rng(11).normal(size=len(x))
    ours = recon.reconstruct(x, t, degree=2, nearest=60) @ noisy - smooth(t)
    theirs = RBFInterpolator(x, noisy, neighbors=60)(t) - smooth(t)
    assert np.std(ours) < 0.5 * np.std(theirs)
