"""The material point method from Python."""

from __future__ import annotations

import csv
import os
import pathlib
import subprocess

import numpy as np
import pytest

import recon

PROBLEMS = pathlib.Path(__file__).resolve().parents[2] / "examples" / "mpm"
PROGRAM = os.environ.get("RECON_MPM_PROGRAM", "")


def test_a_problem_is_stepped() -> None:
    disks = recon.mpm.Simulation(PROBLEMS / "disks.toml")
    assert disks.dimension == 2 and disks.time == 0 and disks.steps == 0 and np.isfinite(disks.end)
    x, v, mass = (disks.particles[name] for name in ("x", "v", "mass"))
    assert x.shape == v.shape == (disks.size, 2) and mass.shape == (disks.size,)
    momentum = mass @ v
    dt = disks.step()
    assert disks.time == dt == pytest.approx(disks.choose_step(), rel=0.1) and disks.steps == 1
    assert disks.step(dt / 2) == dt / 2
    moved = disks.particles["x"]
    assert np.abs(moved - x).max() > 0  # the array from before shows what was before
    np.testing.assert_allclose(mass @ disks.particles["v"], momentum, atol=1e-9 * np.abs(mass @ np.abs(v)).max())
    F = disks.particles["F"]
    assert F.shape == (disks.size, 2, 2) and disks.particles["body"].dtype == np.int32
    velocity_gradient = disks.particles["L"]
    np.testing.assert_allclose(F, np.eye(2) + (F - np.eye(2)), atol=0)
    assert velocity_gradient.shape == F.shape
    assert set(disks.particles) >= {"x", "X", "v", "F", "stress", "mass"}
    nodes = disks.nodes
    assert nodes["mass"].shape == (disks.grid.size,) and nodes["velocity"].shape == (disks.grid.size, 2)
    assert nodes["mass"].sum() == pytest.approx(mass.sum())
    with pytest.raises(recon.InvalidArgument, match="'stres': is not known; did you mean 'stress'"):
        disks.particles["stres"]


def test_rows_of_matrices_are_components() -> None:
    spin = recon.mpm.Simulation(PROBLEMS / "spin.toml")
    spin.run_until(20 * spin.choose_step())
    gradient = spin.particles["L"].mean(axis=0)
    x, v = spin.particles["x"], spin.particles["v"]
    slope = np.linalg.lstsq(x - x.mean(axis=0), v - v.mean(axis=0), rcond=None)[0].T
    assert abs(slope[0, 1]) > 1e-6
    np.testing.assert_allclose(gradient[0, 1], slope[0, 1], rtol=0.2)
    np.testing.assert_allclose(gradient[1, 0], slope[1, 0], rtol=0.2)


def test_settings_replace_those_of_the_file() -> None:
    plain = recon.mpm.Simulation(PROBLEMS / "disks.toml")
    other = recon.mpm.Simulation(PROBLEMS / "disks.toml", {"time.end": 0.25}, method="impm")
    assert other.method == "impm" != plain.method and other.end == 0.25 != plain.end
    assert "cpls" in recon.mpm.methods()
    with pytest.raises(recon.FileError, match="cpls"):
        recon.mpm.Simulation(PROBLEMS / "disks.toml", method="cpsl")
    with pytest.raises(recon.FileError, match="no such file|nothing.toml"):
        recon.mpm.Simulation(PROBLEMS / "nothing.toml")


def test_runs_end_where_they_are_told() -> None:
    disks = recon.mpm.Simulation(PROBLEMS / "disks.toml")
    disks.run_until(5.5 * disks.choose_step())
    assert disks.steps == 6
    told: list[float] = []

    def stop(time: float) -> bool:
        told.append(time)
        return False

    with pytest.raises(recon.Cancelled):
        disks.run_until(disks.end, stop)
    assert len(told) == 1 and disks.time < disks.end
    disks.step()  # it goes on
    with pytest.raises(recon.InvalidArgument, match="time = 0: must be finite and not before"):
        disks.run_until(0)
    with pytest.raises(recon.InvalidArgument):
        disks.step(-1.0)


def test_the_account_is_that_of_the_program(tmp_path: pathlib.Path) -> None:
    if not PROGRAM:
        pytest.skip("RECON_MPM_PROGRAM does not name the program")
    end = 0.02
    subprocess.run(
        [PROGRAM, "run", PROBLEMS / "disks.toml", "--set", f"time.end={end}", "--set", "frames=0", "--out", tmp_path, "--quiet"],
        check=True,
        capture_output=True,
    )
    with open(tmp_path / "ledger.csv") as file:
        rows = list(csv.DictReader(file))
    disks = recon.mpm.Simulation(PROBLEMS / "disks.toml", {"time.end": end})
    disks.run_until(end)
    account = disks.account()
    assert set(account) == set(rows[-1])
    for name in ("time", "mass", "kinetic", "strain", "node_kinetic"):
        assert account[name] == float(rows[-1][name]), name


def test_a_simulation_as_a_field() -> None:
    disks = recon.mpm.Simulation(PROBLEMS / "disks.toml")
    disks.run_until(0.1 * disks.end)
    result = recon.on_grid(disks.particles["x"], {"v": disks.particles["v"]}, disks.grid)
    fields = np.nan_to_num(result["v"])
    assert fields.shape == (*disks.grid.shape, 2) and np.abs(fields).max() > 0
