// The names that the samples in the comments of the public headers take for granted. The samples
// are compiled and never run: nothing here is defined.
#pragma once

#include <array>
#include <iostream>
#include <vector>

#include "recon/cuda/grid_moments.hpp"
#include "recon/cuda/reconstruct.hpp"
#include "recon/grid/grid_moments.hpp"
#include "recon/local_solve/local_cloud.hpp"
#include "recon/neighbourhood/kd_tree.hpp"
#include "recon/operators/kernel_sum.hpp"
#include "recon/recon.hpp"
#include "recon/transfer/cartesian_grid.hpp"
#include "recon/transfer/scatter.hpp"
#ifdef SAMPLES_OF_PETSC
#include <petscsys.h>

#include "recon/petsc/particles.hpp"
#include "recon/petsc/reconstruct_on_grid.hpp"
#endif
#ifdef SAMPLES_OF_MPM
#include "recon/mpm/problem.hpp"
#include "recon/runs/simulation.hpp"
#endif

namespace samples {

// The reader's own data.
struct Grain {
  std::array<double, 3> position, velocity;
};
extern const std::vector<Grain> grains;
extern const std::vector<std::array<double, 3>> nodes;
extern const std::vector<double> vx, vy, vz, temperature, momenta;

// Views of them, and what goes with them.
extern const recon::PointsView<double> points, targets, moved;
extern const recon::PeriodicDomain<double> box;
extern const recon::Sources sources;
extern const recon::Reconstruction fit;
extern const recon::FieldView<double> velocity, stress, density, nodal_force, mass;
extern const recon::StructuredGrid<double> grid, all_nodes;
extern const recon::Options options;
extern const recon::GridMoments others;
extern const std::vector<double> nodal_density;
#ifdef SAMPLES_OF_PETSC
extern int argc;
extern char** argv;
extern const recon::petsc::DistributedGrid distributed;
extern const recon::FieldView<double> target_force;
extern const std::vector<double> masses;
void read_my_part(int rank);
void move_all(std::span<double> x, std::span<const double> velocity);
#endif
extern const double h, dt;
// In the memory of a GPU.
extern const double *x_p, *x_t, *u_p, *f_t;
extern double *u_t, *f_p, *grad_u;
extern const std::size_t particle_count, target_count;
extern const recon::cuda::Stream stream;
extern const recon::SpaceMatrix<2> half_edges;  // columns

// One target.
extern const std::array<double, 2> x;
extern const double rho;
extern const recon::PointCloud<double> particles;
extern const std::vector<std::array<double, 2>> position;
extern const std::vector<double> u;
struct MyWeight {
  double operator()(double q) const { return 1 - q; }
  double derivative(double) const { return -1; }
};

extern const recon::LocalCloud<double, 3> cloud;
extern double* const phi;

template <class T>
void use(const T&);

#ifdef SAMPLES_OF_MPM
extern const recon::mpm::Problem<2> problem;
extern const double end;
#endif

}  // namespace samples
