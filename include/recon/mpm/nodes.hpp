// What a step computes on the grid: the nodes, the cells of quadratures over cells, and where a run
// cannot go on.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "recon/grid/reconstruct_on_grid.hpp"
#include "recon/mpm/particles.hpp"
#include "recon/mpm/problem.hpp"
#include "recon/transfer/cell_weights.hpp"
#include "recon/transfer/images.hpp"
#include "recon/transfer/mass_matrix.hpp"

namespace recon::mpm {

// Thrown where a run cannot go on: a particle left the grid, was turned inside out, or is not
// finite; a node has a mass that cannot be divided by.
class Failure : public std::runtime_error {
 public:
  // place: "particle" or "node", the kind of thing that `number` counts; a literal.
  Failure(std::int64_t step, const char* place, std::size_t number, const std::string& reason)
      : std::runtime_error("step " + std::to_string(step) + ", " + place + " " +
                           std::to_string(number) + ": " + reason),
        step_(step),
        place_(place),
        number_(number),
        reason_length_(reason.size()) {}
  std::int64_t step() const { return step_; }
  const char* place() const { return place_; }
  std::size_t number() const { return number_; }
  // What what() says after the place.
  std::string reason() const {
    const std::string all = what();
    return all.substr(all.size() - reason_length_);
  }

 private:
  std::int64_t step_;
  const char* place_;
  std::size_t number_, reason_length_;
};

// A node whose mass is negative. Functions of elements (q8, q9) are negative in parts, and a fitted
// density can be. Momentum and force are then negative as well, and velocity and acceleration are
// right in rigid motion; but when the sign changes, the mass passes through zero, and dividing by
// it makes both arbitrary (Andersen, Andersen 2007, appendix, corrected).
struct NegativeMass {
  std::int64_t step = 0;
  std::size_t node = 0;
  double mass = 0;
};

// What is seen of negative masses from step to step.
struct MassSigns {
  std::vector<signed char> of_nodes;  // in the step before
  // The first node of negative mass, and the first whose mass changed its sign between two steps.
  std::optional<NegativeMass> negative, change;
};

// The images of particles that give to the nodes as particles do: beyond planes with images and the
// ends of periods. Of the arrays of `particles` those are there that go to nodes.
template <int D>
struct ImageParticles {
  std::vector<Image<D>> of;  // those of one particle are consecutive, in the order of particles
  Particles<D> particles;
  std::vector<Vector<D>> body_force;  // per mass; empty: none

  // The images of one particle, from number `first` on.
  struct Range {
    std::size_t first, last;
  };
  Range of_particle(std::size_t p) const {
    const auto found = std::equal_range(of.begin(), of.end(), p, Before{});
    return {static_cast<std::size_t>(found.first - of.begin()),
            static_cast<std::size_t>(found.second - of.begin())};
  }

 private:
  struct Before {
    bool operator()(const Image<D>& image, std::size_t p) const { return image.of < p; }
    bool operator()(std::size_t p, const Image<D>& image) const { return p < image.of; }
  };
};

// The cells first .. last - 1 along each axis of a grid.
template <int D>
struct Window {
  std::array<int, D> first{}, last{};

  static Window of(const Grid<D>& whole) {
    Window all;
    for (std::size_t d = 0; d < D; ++d) all.last[d] = whole.cells(static_cast<int>(d));
    return all;
  }
  // These cells as a grid of its own.
  Grid<D> part_of(const Grid<D>& whole) const {
    Vector<D> lower, upper;
    for (int d = 0; d < D; ++d) {
      lower[d] = whole.node(first[static_cast<std::size_t>(d)], d);
      upper[d] = whole.node(last[static_cast<std::size_t>(d)], d);
    }
    return {lower, upper, whole.h()};
  }
  bool operator==(const Window&) const = default;

  // The number in the whole grid of a node of these cells, and the way back: none for a node beyond
  // them.
  std::size_t number_in(const Grid<D>& whole, const Grid<D>& part, std::size_t node) const {
    const auto index = part.nodes().index(node);
    std::array<int, D> at;
    for (std::size_t d = 0; d < D; ++d) at[d] = first[d] + static_cast<int>(index[d]);
    return whole.number(at);
  }
  std::optional<std::size_t> place_of(const Grid<D>& whole, const Grid<D>& part,
                                      std::size_t number) const {
    const auto index = whole.nodes().index(number);
    std::array<int, D> at;
    for (std::size_t d = 0; d < D; ++d) {
      at[d] = static_cast<int>(index[d]) - first[d];
      if (at[d] < 0 || at[d] > last[d] - first[d]) return {};
    }
    return part.number(at);
  }
};

// A component of the velocity of a node that the problem gives.
template <int D>
struct HeldComponent {
  std::uint32_t node = 0;
  int axis = 0;
  const HeldVelocity<D>* velocity = nullptr;
  std::size_t boundary = 0;  // the number of the boundary that holds it
  Vector<D> x;               // of the node
};

// The nodes of a grid: of that of the problem or, where a state has several parts (parts.hpp), of
// the part of it that particles see here, a grid of its own whose nodes are some of those.
template <int D>
struct Nodes {
  Grid<D> grid;
  Window<D> window;                    // which cells of the problem's grid it has
  std::vector<HeldComponent<D>> held;  // of these nodes

  std::vector<double> mass;
  MassEntries mass_entries;                 // of the quadrature, for a consistent mass
  Eigen::SparseMatrix<double> mass_matrix;  // consistent mass, else empty
  std::vector<Vector<D>> momentum;          // sum_p S m_p v_p, or as the map defines it
  std::vector<Vector<D>> force;             // internal and external
  std::vector<Vector<D>> mapped;            // v_i as it was mapped, before boundary conditions
  std::vector<Vector<D>> velocity;          // v_i
  std::vector<Vector<D>> acceleration;      // f_i / m_i, zero where the velocity is held
  std::vector<Vector<D>> damping;           // the part of damping in it; empty without damping
  // Only for point particles in linear functions with lumped mass, else empty: the part of internal
  // forces in `force` and of loads on surfaces that G brings, and
  // K_i = sum_p V_p (lambda + 2 mu) |G_ip|^2, force / length.
  std::vector<Vector<D>> internal;
  std::vector<double> stiffness;
  ImageParticles<D> images;
  // The part of each node's mass that is neither of images nor of copies of other parts' particles
  // (State::others); empty without these. Sums over nodes weigh with it, so that what two nodes, or
  // the nodes of two parts, have in common counts once.
  std::vector<double> share;
  // In a state of several parts (parts.hpp): the largest mass of a node of all of them.
  std::optional<double> heaviest_of_parts;
  CellWeights<D>
      weights;     // with which particles stand for cells; of adjoint_cells only, else empty
  FitReports fit;  // reports of a fitted velocity, at the nodes fit_nodes
  std::vector<std::uint32_t> fit_nodes;
  std::size_t unfitted = 0;  // nodes with mass whose velocity had to be mass-weighted
  std::size_t negative = 0;  // nodes of negative mass

  // The number in the grid of the problem of a node.
  std::size_t number_in(const Grid<D>& whole, std::size_t node) const {
    return window.number_in(whole, grid, node);
  }

  // Sums are zero, those of light nodes only where they are asked for.
  void clear(bool light_nodes) {
    const std::size_t count = grid.size();
    mass.assign(count, 0);
    mass_entries.clear();
    momentum.assign(count, Vector<D>::Zero());
    force.assign(count, Vector<D>::Zero());
    internal.assign(light_nodes ? count : 0, Vector<D>::Zero());
    stiffness.assign(light_nodes ? count : 0, 0);
    unfitted = 0;
  }
  double share_of(std::size_t i) const { return share.empty() ? 1 : share[i]; }
  // M x of a vector at each node, M diagonal with lumped mass.
  std::vector<Vector<D>> times_mass(const std::vector<Vector<D>>& x) const {
    std::vector<Vector<D>> out(x.size(), Vector<D>::Zero());
    if (mass_matrix.size() == 0) {
      for (std::size_t i = 0; i < x.size(); ++i) out[i] = mass[i] * x[i];
      return out;
    }
    for (Eigen::Index column = 0; column < mass_matrix.outerSize(); ++column)
      for (Eigen::SparseMatrix<double>::InnerIterator at(mass_matrix, column); at; ++at)
        out[static_cast<std::size_t>(at.row())] += at.value() * x[static_cast<std::size_t>(column)];
    return out;
  }
  // Whether what the node has is known: in a state of several parts only those have all of their
  // mass that the part's own particles see.
  bool is_known(std::size_t i) const { return !heaviest_of_parts || share_of(i) != 0; }
  double heaviest() const {
    if (heaviest_of_parts) return *heaviest_of_parts;
    double most = 0;
    for (const double each : mass) most = std::max(most, std::abs(each));
    return most;
  }
  // Of the nodes that a part's own particles see.
  double heaviest_known() const {
    double most = 0;
    for (std::size_t i = 0; i < mass.size(); ++i)
      if (share_of(i) != 0) most = std::max(most, std::abs(mass[i]));
    return most;
  }
};

// The fits of the quadrature, for `cells` at the cell centres and for `nodal_cells` at the
// nodes. The columns of `values` are density, the stress (row after row of its upper triangle),
// and body force.
template <int D>
struct Cells {
  Eigen::MatrixXd values;
  std::vector<double> fill;  // part of each cell that holds material
  FitReports fit;
};

}  // namespace recon::mpm
