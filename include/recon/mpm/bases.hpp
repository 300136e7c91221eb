// The functions N_i of the grid for particles that are points: S_ip = N_i(x_p), G_ip
// = grad N_i(x_p).
//
//   PointDomain   linear, the original material point method (Sulsky, Chen, Schreyer 1994)
//   NineNode      quadratic elements of 2 x 2 cells (3 nodes in 1-D, 27 in 3-D)
//   EightNode     serendipity elements of 2 x 2 cells, whose middle nodes are not used; 2-D only
//   BSpline<P>    cardinal splines of degree P = 2, 3 about the nodes (eq. 23)
//
// (Andersen, Andersen 2007, section 3.4.) All of them live on the same nodes, so that methods are
// compared at the same number of unknowns. The functions of elements are negative in parts, so the
// mass of a node may be negative.
//
// Splines reach one node beyond the faces of the grid, and there are three ways to end them:
//   corrected     the velocity of that node is 2 v_0 - v_1: its function goes to the two nodes next
//                 to it, twice and minus once. Functions stay positive, sum to one, reproduce
//                 linear fields and are interpolating at the face, where boundaries hold velocities
//                 (the functions of Steffen, Kirby, Berzins 2008)
//   extra_column  that node is held at rest: its function is lost (Andersen, Andersen 2007). Near
//                 the face the sum is below one
//   linear_cells  linear functions in the outermost cells, splines inside; not continuous between
//
// Each is a policy, a small struct: shape() writes S and G and returns the volume of the particle,
// nodes_along() returns the first and the last node that the particle touches on an axis, and
// move() updates through a step what the policy keeps with the particle. Bases that are products of
// functions of the axes also have axes(), which returns those.
#pragma once

#include <string_view>
#include <utility>

#include "recon/mpm/particles.hpp"
#include "recon/mpm/shape_functions.hpp"

namespace recon::mpm {

enum class SplineBorder { corrected, extra_column, linear_cells };

namespace detail {

// A point on the edge of its cell, or beyond it by rounding, is treated as lying inside the cell by
// this part of its edge. So every node that gets a force from the gradient at the point also gets
// some of its mass, and with it its velocity.
inline constexpr double hair = 1e-14;

// The linear functions of a cell; xi runs from 0 to 1 over it.
inline AxisShape linear(double xi, double h, int cell) {
  AxisShape axis;
  axis.first = cell;
  axis.count = 2;
  axis.S[0] = 1 - xi;
  axis.S[1] = xi;
  axis.G[0] = -1 / h;
  axis.G[1] = 1 / h;
  return axis;
}
inline AxisShape linear_at(double x, double lower, double h, int cell) {
  return linear(std::clamp((x - lower) / h - cell, hair, 1 - hair), h, cell);
}
// The linear functions of a cell, continued beyond it.
inline AxisShape linear_on(double x, double lower, double h, int cell) {
  return linear((x - lower) / h - cell, h, cell);
}

// The quadratic functions of the element that spans cells 2 e and 2 e + 1; xi runs from
// -1 to 1 over it.
inline AxisShape quadratic_element_at(double x, double lower, double h, int cell) {
  AxisShape axis;
  axis.first = cell / 2 * 2;
  axis.count = 3;
  const double xi = std::clamp((x - lower) / h - axis.first - 1, -1 + hair, 1 - hair);
  axis.S[0] = xi * (xi - 1) / 2;
  axis.S[1] = (1 - xi) * (1 + xi);
  axis.S[2] = xi * (xi + 1) / 2;
  axis.G[0] = (xi - 0.5) / h;
  axis.G[1] = -2 * xi / h;
  axis.G[2] = (xi + 0.5) / h;
  return axis;
}

// Ends splines at the faces: the function of the node before the first one goes to the first two
// nodes, and that of the node beyond the last one to the last two.
inline void end_splines(AxisShape& axis, int cells, SplineBorder border) {
  const double twice = border == SplineBorder::corrected ? 2 : 0, once = twice / 2;
  const auto give = [&](int from, int next, int after) {
    for (auto* value : {&axis.S, &axis.G}) {
      (*value)[next] += twice * (*value)[from];
      (*value)[after] -= once * (*value)[from];
    }
  };
  if (axis.first < 0) {
    give(0, 1, 2);
    for (auto* value : {&axis.S, &axis.G})
      std::copy(value->begin() + 1, value->begin() + axis.count, value->begin());
    ++axis.first;
    --axis.count;
  }
  if (axis.first + axis.count - 1 > cells) {
    const int last = axis.count - 1;
    give(last, last - 1, last - 2);
    --axis.count;
  }
}

template <int degree>
AxisShape spline_at(double x, double lower, double h, int cells, SplineBorder border) {
  static_assert(degree == 2 || degree == 3);
  AxisShape axis;
  const double s = std::clamp((x - lower) / h, hair, cells * (1 - hair));
  const int cell = std::min(static_cast<int>(s), cells - 1);
  if (border == SplineBorder::linear_cells && (cell == 0 || cell == cells - 1))
    return linear_at(x, lower, h, cell);
  axis.count = degree + 1;
  if constexpr (degree == 2) {
    const int nearest = static_cast<int>(s + 0.5);
    const double z = s - nearest;
    axis.first = nearest - 1;
    axis.S[0] = (0.5 - z) * (0.5 - z) / 2;
    axis.S[1] = 0.75 - z * z;
    axis.S[2] = (0.5 + z) * (0.5 + z) / 2;
    axis.G[0] = (z - 0.5) / h;
    axis.G[1] = -2 * z / h;
    axis.G[2] = (z + 0.5) / h;
  } else {
    const double xi = s - cell, rest = 1 - xi;
    axis.first = cell - 1;
    axis.S[0] = rest * rest * rest / 6;
    axis.S[1] = 2.0 / 3 - xi * xi * (2 - xi) / 2;
    axis.S[2] = 2.0 / 3 - rest * rest * (2 - rest) / 2;
    axis.S[3] = xi * xi * xi / 6;
    axis.G[0] = -rest * rest / (2 * h);
    axis.G[1] = xi * (1.5 * xi - 2) / h;
    axis.G[2] = -rest * (1.5 * rest - 2) / h;
    axis.G[3] = xi * xi / (2 * h);
  }
  end_splines(axis, cells, border);
  return axis;
}

struct LinearAxis {
  template <int D>
  AxisShape axis(const Grid<D>& grid, double x, int d) const {
    return linear_at(x, grid.lower()[d], grid.h(), grid.cell(x, d));
  }
};

struct QuadraticAxis {
  template <int D>
  AxisShape axis(const Grid<D>& grid, double x, int d) const {
    return quadratic_element_at(x, grid.lower()[d], grid.h(), grid.cell(x, d));
  }
};

template <int degree>
struct SplineAxis {
  SplineBorder border = SplineBorder::corrected;
  template <int D>
  AxisShape axis(const Grid<D>& grid, double x, int d) const {
    return spline_at<degree>(x, grid.lower()[d], grid.h(), grid.cells(d), border);
  }
};

// A policy that keeps nothing with the particle.
struct Memoryless {
  template <int D, class Velocity>
  static void move(const Grid<D>&, Particles<D>&, std::size_t, const Velocity&, double) {}
};

template <class Axis>
struct ProductBasis : Axis, Memoryless {
  template <int D>
  std::array<AxisShape, D> axes(const Grid<D>& grid, const Vector<D>& x) const {
    std::array<AxisShape, D> all;
    for (int d = 0; d < D; ++d) all[d] = this->axis(grid, x[d], d);
    return all;
  }
  template <int D>
  double shape(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
               ShapeFunctions<D>& out) const {
    tensor_product<D>(grid, axes(grid, particles.x[p]), out);
    return particles.volume(p);
  }
  template <int D>
  std::pair<int, int> nodes_along(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
                                  int d) const {
    const AxisShape axis = this->axis(grid, particles.x[p][d], d);
    return {axis.first, axis.first + axis.count - 1};
  }
};

}  // namespace detail

using PointDomain = detail::ProductBasis<detail::LinearAxis>;
using NineNode = detail::ProductBasis<detail::QuadraticAxis>;
template <int degree>
using BSpline = detail::ProductBasis<detail::SplineAxis<degree>>;

// Quadratic splines with other gradients: G is the slope of the least-squares plane through the
// nodes, weighted by S, G_ip = S_ip D_p^-1 (x_i - x_p) with D_p = sum_i S_ip (x_i - x_p)(x_i -
// x_p)^T, which is h^2 / 4 on quadratic splines (Hu et al. 2018, MLS-MPM). sum_i G_ip = 0, and
// gradients of linear fields are exact. Next to a face only two nodes are left on an axis, and both
// kinds of gradient are the same.
struct MomentGradients : BSpline<2> {
  template <int D>
  double shape(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
               ShapeFunctions<D>& out) const {
    const auto functions = axes(grid, particles.x[p]);
    detail::tensor_product<D>(grid, functions, out);
    for (int d = 0; d < D; ++d) {
      const detail::AxisShape& axis = functions[d];
      if (axis.count == 2) continue;
      double second = 0;
      for (int k = 0; k < axis.count; ++k) {
        const double offset = grid.node(axis.first + k, d) - particles.x[p][d];
        second += axis.S[k] * offset * offset;
      }
      for (std::size_t n = 0; n < out.size(); ++n)
        out.G[n][d] = out.S[n] * (grid.position(out.node[n])[d] - particles.x[p][d]) / second;
    }
    return particles.volume(p);
  }
};

// N = (1 + xi xi_i)(1 + eta eta_i)(xi xi_i + eta eta_i - 1) / 4 at corners,
// (1 - xi^2)(1 + eta eta_i) / 2 at the middle of sides.
struct EightNode : detail::Memoryless {
  template <int D>
  double shape(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
               ShapeFunctions<D>& out) const {
    if constexpr (D == 2) {
      std::array<int, 2> first;
      Vector<2> xi;
      for (int d = 0; d < 2; ++d) {
        const double x = particles.x[p][d];
        first[d] = grid.cell(x, d) / 2 * 2;
        xi[d] = std::clamp((x - grid.lower()[d]) / grid.h() - first[d] - 1, -1 + detail::hair,
                           1 - detail::hair);
      }
      out.resize(8);
      for (int n = 0, place = 0; place < 9; ++place) {
        const int i = place % 3 - 1, j = place / 3 - 1;
        if (i == 0 && j == 0) continue;
        const double a = 1 + i * xi[0], b = 1 + j * xi[1];
        out.node[n] = grid.number({first[0] + i + 1, first[1] + j + 1});
        if (i != 0 && j != 0) {
          out.S[n] = a * b * (a + b - 3) / 4;
          out.G[n] = Vector<2>(i * b * (2 * a + b - 3), j * a * (a + 2 * b - 3)) / (4 * grid.h());
        } else if (i == 0) {
          out.S[n] = (1 - xi[0] * xi[0]) * b / 2;
          out.G[n] = Vector<2>(-2 * xi[0] * b, j * (1 - xi[0] * xi[0])) / (2 * grid.h());
        } else {
          out.S[n] = (1 - xi[1] * xi[1]) * a / 2;
          out.G[n] = Vector<2>(i * (1 - xi[1] * xi[1]), -2 * xi[1] * a) / (2 * grid.h());
        }
        ++n;
      }
      return particles.volume(p);
    } else {
      recon::detail::throw_invalid("dimension of the 8-node elements", D, "must be 2");
    }
  }
  template <int D>
  std::pair<int, int> nodes_along(const Grid<D>& grid, const Particles<D>& particles, std::size_t p,
                                  int d) const {
    const int first = grid.cell(particles.x[p][d], d) / 2 * 2;
    return {first, first + 2};
  }
};

}  // namespace recon::mpm
