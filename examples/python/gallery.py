# %% [markdown]
# Pictures of what recon does, each from a few lines of Python. `gallery.py FOLDER` writes them to a folder as PNG;
# the cells (`# %%`) also run one by one in an editor that knows them. docs/gallery.md shows the pictures.

# %%
from __future__ import annotations

import pathlib
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import recon

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out/gallery")
folder.mkdir(parents=True, exist_ok=True)
root = pathlib.Path(__file__).resolve().parents[2]
random = np.random.default_rng(1)


def save(name: str) -> None:
    plt.savefig(folder / f"{name}.png", dpi=80)
    plt.close()


# %% [markdown]
# ## Particles to a field
# Grains flowing down a chute: their velocities on a vertical section, and how many neighbours each node has.

# %%
grains = recon.read(root / "examples" / "data" / "chute.dump.gz")
position = grains.positions()
section = recon.covering_grid(position[:, [0, 2]], 0.25)
nodes = section.nodes()
middle = np.insert(nodes, 1, np.median(position[:, 1]), axis=1)
sources = recon.Sources(position, domain=grains.domain())
fit = recon.reconstruct(sources, middle, degree=1, radius=2, max_distance=1)
velocity = fit.apply(grains["vx"], limit="relaxed")

_, axes = plt.subplots(2, figsize=(8, 6), layout="constrained")
recon.plot.field(section, velocity, axes=axes[0], label="velocity along the chute")
recon.plot.field(section, fit.report.neighbours, axes=axes[1], label="neighbours", cmap="cividis")
for ax in axes:
    ax.set_ylabel("z")
save("particles_to_field")
assert np.nanmax(velocity) <= grains["vx"].max()

# %% [markdown]
# ## Choosing a degree
# The error of a smooth field against the spacing of the particles: each degree gains an order.

# %%
spacings = 1 / np.array([10, 14, 20, 28, 40, 57, 80])
targets = random.uniform(0.2, 0.8, (400, 2))


def smooth(x: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.asarray(np.sin(5 * x[:, 0]) * np.cos(4 * x[:, 1]))


errors = np.empty((5, len(spacings)))
for column, h in enumerate(spacings):
    side = round(1 / h)
    cell = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    x = (cell + 0.5 + random.uniform(-0.3, 0.3, cell.shape)) * h
    for degree in range(5):
        values = recon.reconstruct(x, targets, degree=degree) @ smooth(x)
        errors[degree, column] = np.sqrt(np.mean((values - smooth(targets)) ** 2))

ax = plt.subplots(figsize=(6, 4.5), layout="constrained")[1]
for degree in range(5):
    order = np.polyfit(np.log(spacings), np.log(errors[degree]), 1)[0]
    ax.loglog(spacings, errors[degree], "o-", label=f"degree {degree}: order {order:.1f}")
    assert order > [0.8, 1.5, 2.5, 3.2, 4.2][degree]
ax.set_xlabel("spacing of the particles")
ax.set_ylabel("root mean square error")
ax.legend()
save("choosing_a_degree")

# %% [markdown]
# ## Uncertainty
# Noisy data along a line. The rows of the operator say what noise of the data becomes in the result: its standard
# deviation is sqrt(sum_p phi_p^2) times that of the data. Where particles are few, and beyond them, it grows; where
# there is none within the support, there is no value.

# %%
x1 = np.concatenate([random.uniform(0, 1, 40), random.uniform(1.6, 2, 15)])
noise = 0.15
data = np.sin(4 * x1) + random.normal(0, noise, x1.size)
line = np.linspace(-0.1, 2.1, 400)
at = recon.reconstruct(x1, line, degree=1, radius=0.25)
value = at @ data
phi = at.to_scipy()
deviation = noise * np.sqrt(np.asarray(phi.multiply(phi).sum(axis=1)).ravel())
deviation[at.report.with_status("no_support")] = np.nan

ax = plt.subplots(figsize=(7, 4), layout="constrained")[1]
ax.plot(x1, data, ".", color="k", label="data")
ax.plot(line, np.sin(4 * line), "--", color="0.5", label="what they are of")
recon.plot.profile(line, value, uncertainty=2 * deviation, axes=ax, label="degree 1, with two standard deviations")
ax.set_ylim(-2, 2)
save("uncertainty")
assert deviation[np.abs(line - 0.5) < 0.2].max() < noise < np.nanmax(deviation)

# %% [markdown]
# ## A dam of grains
# A column of plastic material collapses under its weight (material point method). Its particles become a field of
# density on a grid by sums over kernels, and of speed by reconstruction; a node too far from all of them has no value.

# %%
DAM = """
title = "a dam"
[grid]
lower = [0.0, 0.0]
upper = [3.0, 1.25]
cells = 8
[material]
kind = "von_mises"
young = 1e6
poisson = 0.3
density = 2000
yield = 1500
hardening = 0
[[body]]
shape = "box"
lower = [0.0, 0.0]
upper = [1.0, 1.0]
particles = 3
[loads]
gravity = [0, -9.81]
[[boundary]]
axis = "x"
at = 0
kind = "roller"
[[boundary]]
axis = "y"
at = 0
kind = "roller"
[method]
name = "mpm"
[time]
end = 0.4
"""
with tempfile.TemporaryDirectory() as scratch:
    problem = pathlib.Path(scratch) / "dam.toml"
    problem.write_text(DAM)
    dam = recon.mpm.Simulation(problem)
grid = recon.StructuredGrid((0, 0), 0.025, (121, 51))
_, axes = plt.subplots(3, 2, figsize=(10, 6), layout="constrained")
for row, time in enumerate((0.0, 0.2, 0.4)):
    dam.run_until(time)
    where = recon.Sources(dam.particles["x"])
    density = recon.kernel_sum(where, grid, dam.particles["mass"], radius=0.1)
    v = dam.particles["v"]
    speed = recon.reconstruct(where, grid, radius=0.12, max_distance=1).apply(
        np.hypot(v[:, 0], v[:, 1]), limit="range"
    )
    shown = np.where(density > 200, density, np.nan)
    recon.plot.field(grid, shown, axes=axes[row, 0], label=f"density, t = {time}", vmin=0, vmax=2500)
    recon.plot.field(grid, speed, axes=axes[row, 1], label="speed", vmin=0, vmax=3, cmap="magma")
save("dam")
assert dam.particles["x"][:, 0].max() > 1.1

# %% [markdown]
# ## Disks of the material point method
# Two elastic disks collide. Kinetic energy goes to strain and back; the account is that of ledger.csv.

# %%
disks = recon.mpm.Simulation(root / "examples" / "mpm" / "disks.toml")
times, kinetic, strain = [], [], []
figure, ax = plt.subplot_mosaic("ABC;DDD", figsize=(9, 6.5), layout="constrained")
for panel, stops in zip("ABC", (np.arange(1, 11), np.arange(11, 35), np.arange(35, 61))):
    for stop in stops:
        disks.run_until(0.05 * stop)
        account = disks.account()
        times.append(account["time"])
        kinetic.append(account["kinetic"])
        strain.append(account["strain"])
    stress = disks.particles["stress"]
    pressure = -np.trace(stress, axis1=1, axis2=2) / 2
    x_now = disks.particles["x"]
    dots = ax[panel].scatter(*x_now.T, c=pressure, s=4, cmap="coolwarm", vmin=-60, vmax=60)
    ax[panel].set_aspect("equal")
    ax[panel].set_xlim(0, 1)
    ax[panel].set_ylim(0, 1)
    ax[panel].set_title(f"t = {disks.time:.1f}")
figure.colorbar(dots, ax=ax["C"], label="- (stress xx + yy) / 2")
recon.plot.profile(times, kinetic, axes=ax["D"], label="kinetic energy")
recon.plot.profile(times, strain, axes=ax["D"], label="strain energy")
recon.plot.profile(times, np.add(kinetic, strain), axes=ax["D"], label="sum")
ax["D"].set_xlabel("time")
save("disks")
assert np.add(kinetic, strain).max() < 1.02 * kinetic[0]
