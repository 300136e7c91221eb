// recon: scattered particle data become fields. This header is all that most programs need.
//
// ```cpp
//   const auto points = recon::points_of(grains, &Grain::position);  // a view, no copy
//   const recon::Reconstruction fit = recon::reconstruct(points, recon::points_of(nodes),
//                                                        {.neighbours = recon::Radius{2 * h}});
//   Eigen::MatrixXd v = fit.apply(recon::field_of(grains, &Grain::velocity));  // a row per node
// ```
//
//   views of your data   points_of, field_of      points/make_view.hpp
//   what to choose       Options                  shape/options.hpp
//   the reconstruction   reconstruct              operators/reconstruct.hpp
//   derivatives          Functional               operators/functional.hpp
//   particles kept       Sources                  neighbourhood/sources.hpp
//   supports             Radius, Ellipsoids, ...  neighbourhood/find_neighbours.hpp
//   what became of it    FitReport, FitReports    local_solve/report.hpp, operators/fit_summary.hpp
//   grids of targets     StructuredGrid           points/structured_grid.hpp
//   nodes of a grid      reconstruct_on_grid      grid/reconstruct_on_grid.hpp, mostly without
//                                                 neighbour lists
//
// Included separately: grid/grid_moments.hpp, points/boost_geometry.hpp, operators/sparse.hpp,
// operators/kernel_sum.hpp, the searches (neighbourhood/kd_tree.hpp, ...), the templates for a
// weight, basis, search or scalar of your own (shape/shape_function.hpp), and what particle-in-cell
// codes need (transfer/scatter.hpp, transfer/modes.hpp).
#pragma once

#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/points/make_view.hpp"
#include "recon/points/structured_grid.hpp"
