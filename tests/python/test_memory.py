"""No copies of large arrays: the peak of a process's memory, and what the arrays share."""

from __future__ import annotations

import subprocess
import sys

import numpy as np

import recon
from clouds import inner, jittered

PRELUDE = """
import resource, sys
import numpy as np
import recon

def peak():  # bytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024

def resident():
    with open('/proc/self/statm') as file:
        return int(file.read().split()[1]) * resource.getpagesize()

small = np.random.default_rng(1).uniform(size=(1000, 3))
recon.reconstruct(small, small).gradient() @ small  # what is loaded and made once
"""


def growth(code: str) -> float:
    """How much the last expressions of a program grow its peak, in bytes: it prints it."""
    done = subprocess.run(
        [sys.executable, "-c", PRELUDE + code], capture_output=True, text=True, check=True
    )
    return float(done.stdout)


def test_fields_and_results_are_not_copied() -> None:
    # A field of 384 MB, and a result of 192 MB that is there before.
    used = growth(
        """
n, k = 1_000_000, 48
x = np.arange(n, dtype=float)
fit = recon.reconstruct(x, np.arange(0.5, n - 1, 2), degree=0, neighbours=recon.Nearest(2))
u = np.ones((n, k))
out = np.empty((len(range(0, n - 1, 2)), k)); out.fill(0)
before = resident()
fit.apply(u, out=out)
print(peak() - before)
"""
    )
    assert used < 50e6, used / 1e6


def test_points_of_any_strides_are_read_where_they_lie() -> None:
    used = growth(
        """
n = 4_000_000
records = np.zeros(n, dtype=np.dtype([('m', 'f8'), ('x', 'f8', 3), ('v', 'f8', 3), ('c', 'f8')]))
records['x'] = 1.0 * np.arange(n)[:, None]
wide = np.zeros((n, 8)); wide[:] = 1; wide[:, 0] = np.arange(n)
before = resident()
for points in (records['x'], wide[:, :6:2], wide[::-1, :3]):
    recon._recon.covering_grid(points, 1e5)   # reads all points
print(peak() - before)
"""
    )
    assert used < 20e6, used / 1e6  # one copy would be 96 MB


def test_sources_take_the_memory_that_they_say() -> None:
    used = growth(
        """
n = 2_000_000
x = np.random.default_rng(2).uniform(size=(n, 3))
wide = np.asfortranarray(x)
before = resident()
sources = recon.Sources(wide)
print((resident() - before) / n)
"""
    )
    assert used < 70, used  # 42 bytes per particle are kept, 90 at the most


def test_results_are_made_once() -> None:
    used = growth(
        """
n = 200_000
x = np.random.default_rng(2).uniform(size=(n, 3))
grid = recon.StructuredGrid((0, 0, 0), 0.01, (101, 101, 101))
before = resident()
result = recon.on_grid(x, {'a': x, 'b': x[:, 0]}, grid, radius=0.03, gradients='diffuse')
numbers = sum(v.size for v in result.values.values()) + sum(v.size for v in result.gradients.values())
print((peak() - before - 8 * numbers - 48 * grid.size) / 1e6)
"""
    )
    # Values, gradients and reports, and little else; a copy of the gradients alone would be 99 MB.
    assert used < 60, used


def test_views_of_results() -> None:
    x = jittered(12, 2)
    grid = recon.StructuredGrid((0, 0), 0.1, (11, 11))
    result = recon.on_grid(x, {"u": x, "v": x[:, 0]}, grid, gradients="diffuse")
    assert not result["u"].flags.owndata and np.shares_memory(result["u"], result["u"][..., 0])
    fit = recon.reconstruct(x, grid)
    values = fit @ x
    assert np.shares_memory(values, grid.reshape(values)) and values.flags.c_contiguous
    table_like = inner(5, 2)
    matrix = recon.reconstruct(x, table_like).to_scipy()
    assert not matrix.data.flags.owndata  # it is the array that was made for it
