"""Wrong calls get the messages of the C++ library, word by word."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import recon

PROGRAM = os.environ.get("RECON_MESSAGES", "")


def test_messages_are_those_of_the_library() -> None:
    if not PROGRAM:
        pytest.skip("RECON_MESSAGES does not name the program that prints them")
    lines = subprocess.run([PROGRAM], capture_output=True, text=True, check=True).stdout.splitlines()
    expected = dict(line.split("\t", 1) for line in lines)

    points = np.array([(i % 10 * 0.1, i // 10 * 0.1) for i in range(100)])
    broken = points.copy()
    broken[7, 1] = np.nan
    u, short, wrong = np.ones(100), np.ones(3), np.ones(100)
    wrong[40] = np.inf
    fit = recon.reconstruct(points, points)
    line = np.arange(4.0)
    calls: dict[str, Callable[[], Any]] = {
        "degree": lambda: recon.reconstruct(points, points, degree=5),
        "radius": lambda: recon.reconstruct(points, points, radius=-1),
        "no neighbour": lambda: recon.reconstruct(points, points, nearest=0),
        "factor": lambda: recon.reconstruct(points, points, neighbours=recon.Nearest(5, 1.0)),
        "coordinate": lambda: recon.Sources(broken),
        "target": lambda: recon.reconstruct(points, broken),
        "dimension": lambda: recon.reconstruct(points, line),
        "size": lambda: fit @ short,
        "value": lambda: fit @ wrong,
        "transposed value": lambda: fit.T @ wrong,
        "stretch": lambda: recon.Sources(points, stretch=(1, -1)),
        "weights": lambda: recon.Sources(points, particle_weights=short),
        "grow": lambda: recon.reconstruct(points, points, grow=-1),
        "leverage": lambda: recon.reconstruct(
            points, points, tolerances=recon.FitTolerances(leverage=0.5)
        ),
        "grid spacing": lambda: recon.StructuredGrid((0, 0), (0, 1), (2, 2)),
        "domain": lambda: recon.PeriodicDomain((0, 0), (1, 0)),
        "curl": lambda: recon.reconstruct(line, line).curl(),
        "partial": lambda: recon.Functional.partial(5),
        "components": lambda: fit.divergence() @ u,
        "kernel radius": lambda: recon.kernel_sum(
            recon.Sources(points), points, u, weight="gaussian", radius=-2
        ),
        "scale": lambda: np.inf * fit,
        "file": lambda: recon.read("nowhere.dump"),
    }
    assert calls.keys() == expected.keys()
    for name, call in calls.items():
        kind = recon.FileError if name == "file" else recon.InvalidArgument
        with pytest.raises(kind) as caught:
            call()
        assert str(caught.value) == expected[name], name
