"""Particles to a field with gradient and report, and a run of the material point method: the same in C++, C, Fortran
and Python, with the same output (field.output). The argument is a problem file."""

import sys

import numpy as np

import recon

i = np.arange(1, 2001)
x = np.stack([i * 0.7548776662466927 % 1, i * 0.5698402909980532 % 1], axis=1)
u = x[:, 0] * (x[:, 0] + x[:, 1])
t = np.arange(9)
targets = 0.25 * np.stack([1 + t % 3, 1 + t // 3], axis=1)

fit = recon.reconstruct(x, targets, degree=1, radius=0.1)
value = fit @ u
gradient = fit.gradient() @ u
error = np.abs(value - targets[:, 0] * targets.sum(axis=1)).max()
full = np.sum(fit.report.degree == 1)
print(f"{full} of {fit.report.targets} targets with degree 1, largest error {error:.6f}")
print(f"u(0.5, 0.5) = {value[4]:.6f}, gradient ({gradient[4, 0]:.6f}, {gradient[4, 1]:.6f})")

disks = recon.mpm.Simulation(sys.argv[1])
disks.run_until(0.5)
v, mass = disks.particles["v"], disks.particles["mass"]
energy = np.sum(0.5 * mass * np.sum(v**2, axis=1))
print(f"{disks.size} particles at t = {disks.time:.2f}, kinetic energy {energy:.6f}")
