// The functions of single particles as the kernels of transfer/node_rows.hpp see them. Each is the
// scratch of a loop over particles:
//
//   ByAxes      products of functions of the axes, of points or boxes: never written out node by
//               node, also with the affine modes of points and with taylor
//   ByCorners   parallelepipeds and corners: linear functions at each corner
//   ByList      a list of nodes, for everything else: elements of 8 nodes, functions through cells,
//               polynomial modes, and modes of domains
//
// look() makes the functions of a particle and returns its volume as functions_of() does, look_along()
// its modes or, with taylor, the offsets of the nodes, and list() is what kernels take.
#pragma once

#include "mpm/modes.hpp"
#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D, class Shape>
class ByList {
 public:
  double look(const Particles<D>& particles, const Nodes<D>& nodes, const Shape& shape_of,
              std::size_t p) {
    return functions_of(particles, nodes, shape_of, p, at_);
  }
  void look_along(const Problem<D>& problem, const Nodes<D>& nodes, const Shape& shape_of,
                  const Vector<D>& x) {
    const VelocityMap map = problem.method.velocity;
    if (map == VelocityMap::taylor) {
      offset_.resize(at_.size());
      for (std::size_t k = 0; k < at_.size(); ++k)
        offset_[k] = nodes.grid.position(at_.node[k]) - x;
      list_of_modes_ = {offset_.data()->data(), 1, D, D};
    } else {
      fill_modes(nodes.grid, shape_of, x, at_, map, modes_);
      list_of_modes_ = list_of(modes_);
    }
  }
  detail::NodeList list() const { return detail::list_of(at_); }
  detail::ModeList modes() const { return list_of_modes_; }
  // Whether the functions can tell mode r from those before it.
  bool tells(std::size_t r) const {
    if constexpr (is_product<D, Shape>) return modes_.norm(static_cast<int>(r)) > 0;
    return true;
  }
  // The coefficients of the modes, of what has just been taken from these rows.
  void coefficients(const detail::RowKernels<D>& kernels, const double* rows, const detail::Taken&,
                    Vector<D>* c) {
    const std::size_t count = list_of_modes_.count;
    moments_.resize(4 * count);
    kernels.take_modes(list(), list_of_modes_, rows, moments_.data());
    for (std::size_t r = 0; r < count; ++r)
      for (int d = 0; d < D; ++d) c[r][d] = moments_[4 * r + static_cast<std::size_t>(d)];
    modes_.divide(c);
  }

 private:
  typename Shape::template Nodes<D> at_;
  ParticleModes<D, Shape> modes_;
  std::vector<Vector<D>> offset_;
  detail::ModeList list_of_modes_;
  std::vector<double> moments_;
};

template <int D, class Shape>
class ByAxes;
template <int D, class Functions, class DomainOf>
class ByAxes<D, ParticleShape<Functions, DomainOf>> {
 public:
  using Shape = ParticleShape<Functions, DomainOf>;
  static constexpr bool of_points = is_product<D, Shape>;

  double look(const Particles<D>& particles, const Nodes<D>& nodes, const Shape& shape_of,
              std::size_t p) {
    if constexpr (of_points)
      for (int d = 0; d < D; ++d)
        axes_[d] = shape_of.functions.axis(nodes.grid, particles.x[p][d], d);
    else
      shape_of.functions.template write_axes<D>(nodes.grid, DomainOf::of(particles, p), axes_);
    list_ = detail::product_of<D>(nodes.grid, axes_);
    return particles.volume(p);
  }
  void look_along(const Problem<D>& problem, const Nodes<D>& nodes, const Shape&,
                  const Vector<D>& x) {
    const Grid<D>& grid = nodes.grid;
    if (problem.method.velocity == VelocityMap::taylor) {
      for (int d = 0; d < D; ++d)
        for (int k = 0; k < axes_[d].count; ++k)
          along_[d][k] = axes_[d].S[k] * (grid.node(axes_[d].first + k, d) - x[d]);
      norm_.setOnes();
    } else if constexpr (of_points) {
      std::array<double, D> sum;
      for (int d = 0; d < D; ++d) {
        const auto look_along_axis = [&](const auto& axis) {
          const auto modes = detail::modes_of_axis(grid, axis, x[d], d, false);
          for (int k = 0; k < axis.count; ++k) along_[d][k] = axis.S[k] * modes.value[1][k];
          norm_[d] = modes.norm[1];
          sum[d] = modes.norm[0];
        };
        if constexpr (std::tuple_size_v < decltype(axes_[d].S) >> 2) {
          if (axes_[d].count == 3) {  // most often: loops are made of this number
            detail::AxisFunctions<Exactly<3>> three;
            three.first = axes_[d].first;
            std::copy_n(axes_[d].S.begin(), 3, three.S.begin());
            look_along_axis(three);
            continue;
          }
        }
        look_along_axis(axes_[d]);
      }
      for (int d = 0; d < D; ++d)
        for (int e = 0; e < D; ++e) norm_[d] *= e == d ? 1 : sum[e];
    }
    for (int d = 0; d < D; ++d) list_.M[d] = along_[d].data();
  }
  const detail::ProductList& list() const { return list_; }
  static detail::ModeList modes() { return {nullptr, 0, 0, D}; }
  bool tells(std::size_t r) const { return norm_[static_cast<int>(r)] > 0; }
  void coefficients(const detail::RowKernels<D>&, const double*, const detail::Taken& taken,
                    Vector<D>* c) const {
    for (int r = 0; r < D; ++r)
      for (int d = 0; d < D; ++d) c[r][d] = norm_[r] > 0 ? taken.moment[r][d] / norm_[r] : 0;
  }

 private:
  template <class F>
  struct AxesOf {
    using Type = std::array<detail::AxisFunctions<typename F::AxisCount>, D>;
  };
  template <std::same_as<GimpFunctions> F>
  struct AxesOf<F> {
    using Type = GimpFunctions::Axes<D>;
  };
  using Axes = typename AxesOf<Functions>::Type;
  Axes axes_;
  std::array<decltype(axes_[0].S), D> along_;  // S times the mode or the offset along the axis
  Vector<D> norm_;                             // of the modes
  detail::ProductList list_;
};

template <int D, class Shape>
class ByCorners {
 public:
  double look(const Particles<D>& particles, const Nodes<D>& nodes, const Shape&, std::size_t p) {
    if constexpr (std::is_same_v<Shape, Cpdi2>) {
      const CornerDomain<D> domain(particles.corners[p]);
      kernels_.find(nodes.grid, domain, list_);
      return domain.volume;
    } else {
      kernels_.find(nodes.grid, particles.parallelepiped(p), list_);
      return particles.volume(p);
    }
  }
  static void look_along(const Problem<D>&, const Nodes<D>&, const Shape&, const Vector<D>&) {}
  const detail::CornerList& list() const { return list_; }
  static detail::ModeList modes() { return {}; }
  static bool tells(std::size_t) { return true; }
  static void coefficients(const detail::RowKernels<D>&, const double*, const detail::Taken&,
                           Vector<D>*) {}

 private:
  const detail::RowKernels<D> kernels_ = detail::RowKernels<D>::best();
  detail::CornerList list_;
};

// Names a type of scratch.
template <class T>
struct Kind {
  using Type = T;
};

// Calls work(shape_of, Kind<one of these>{}) with the cheapest that serves the method.
template <int D, class Work>
decltype(auto) with_seen(const Method& method, const Work& work) {
  return with_shape(method, [&](auto shape_of) {
    using Shape = decltype(shape_of);
    constexpr bool with_corners = std::is_same_v<Shape, Cpdi1> || std::is_same_v<Shape, Cpdi2>;
    constexpr bool box = std::is_same_v<Shape, UniformGimp> || std::is_same_v<Shape, StretchedGimp>;
    const VelocityMap map = method.velocity;
    if constexpr (with_corners) {
      if (map != VelocityMap::taylor && map != VelocityMap::affine)
        return work(shape_of, Kind<ByCorners<D, Shape>>{});
    } else if constexpr (box) {
      if (map != VelocityMap::affine) return work(shape_of, Kind<ByAxes<D, Shape>>{});
    } else if constexpr (is_product<D, Shape>) {
      if constexpr (!requires { Shape{}.functions.cell_degree; })
        if (map != VelocityMap::polynomial) return work(shape_of, Kind<ByAxes<D, Shape>>{});
    }
    return work(shape_of, Kind<ByList<D, Shape>>{});
  });
}

}  // namespace recon::mpm
