// What one wants to know of a run at every step, as a table.
//
// A probe has a name, columns, and a function that measures them on the state that map() computed
// last. Kinds:
//   particle  fields of the particle whose reference position is nearest to a place in a body
//   point     fields at a place that stays, by a linear least-squares fit (reconstruct(), degree 1)
//             to the particles nearer than `radius`; nothing where there are none
//   section   what the part of the bodies above the plane x_axis = at exerts on the part below it:
//                 force   sum_p V_p sigma_p n w_p / h ,   w_p = max(0, 1 - |x_p - at| / h)
//                 moment  sum_p V_p (x_p - c) x sigma_p n w_p / h   about the section's centre c
//                 area    sum_p V_p w_p / h
//                 stress  sum_p V_p w_p sigma_p / sum_p V_p w_p , its mean
//             (n along the axis, h the cell size): the virtual power of a step across the plane
//             that is h wide on both sides, as the tent functions of the grid see it. The mean of
//             sections that are less than h apart would count particles twice; sections at all
//             planes of nodes together count each of them once.
//   reaction  the force with which a boundary holds its nodes (external.hpp), its sum
// Of a state of several parts (view.hpp) all parts measure what the whole has, to rounding.
// Fields are those of frames (frames.hpp). Vectors have the components of the problem's dimension,
// tensors nine, row by row. In 1-D a section has no moment, in 2-D one component of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "recon/runs/view.hpp"

namespace recon::mpm {

template <int D>
struct Probe {
  std::string name;
  std::vector<std::string> columns;
  // As many numbers as there are columns; NaN for what is not there. Needs a map() before.
  std::function<std::vector<double>(const View<D>&)> measure;
};

// Each throws InvalidArgument for a field that does not exist, or that is no mean (id and body, of
// a point); a place in no body; a radius that is not positive; a plane outside of the grid; a
// boundary that the problem does not have (its number, from 0).
template <int D>
Probe<D> particle_probe(const Problem<D>& problem, const Vector<D>& at,
                        const std::vector<std::string>& fields);
template <int D>
Probe<D> point_probe(const Problem<D>& problem, const Vector<D>& at, double radius,
                     const std::vector<std::string>& fields);
template <int D>
Probe<D> section_probe(const Problem<D>& problem, int axis, double at);
template <int D>
Probe<D> reaction_probe(const Problem<D>& problem, std::size_t boundary);

// The line of column names (step, time, NAME.COLUMN, ...) and a line of numbers. What is not finite
// is an empty cell.
template <int D>
std::string probes_header(const std::vector<Probe<D>>& probes);
template <int D>
std::string probes_row(const std::vector<Probe<D>>& probes, const View<D>& view);

}  // namespace recon::mpm
