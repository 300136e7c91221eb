// recon: scattered particle data become fields. The run-time interface, and all that most programs
// need.
//
//   views of your data   points_of, field_of        (points/make_view.hpp)
//   the reconstruction   reconstruct, Options       (operators/reconstruct.hpp, shape/options.hpp)
//   what became of it    FitReport, FitReports      (local_solve/report.hpp,
//   operators/fit_summary.hpp) grids of targets     StructuredGrid (points/structured_grid.hpp)
//   nodes of a grid      reconstruct_on_grid (grid/reconstruct_on_grid.hpp), without neighbour
//   lists
//
// Asked for separately: grid/grid_moments.hpp, points/boost_geometry.hpp, operators/sparse.hpp, the
// searches (neighbourhood/kd_tree.hpp, ...), and the templates for a weight, basis, search or
// scalar of your own (shape/shape_function.hpp).
#pragma once

#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/make_view.hpp"
#include "recon/points/structured_grid.hpp"
