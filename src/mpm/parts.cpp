#include "recon/mpm/parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mpm/policies.hpp"

namespace recon::mpm {

template <int D>
double reach_of_copies(const Problem<D>& problem, double widest) {
  const Method& method = problem.method;
  const double h = problem.grid.h();
  constexpr double of_fits = 2, neighbour_cell = 1, in_a_step = 1;
  const double functions = method.basis == Basis::linear ? 1 : 2;  // from a point to its nodes
  const double domain = method.domain == Domain::point ? 0 : widest / h;
  const double seen = functions + domain;  // from a particle to its nodes
  double reach = 2 * seen;
  if (is_fit(method.velocity))  // of points, or of corners of domains
    reach = std::max(reach, seen + of_fits + widest / h);
  if (method.quadrature !=
      Quadrature::particles)  // by cells whose points see a node, and by theirs
    reach = std::max(reach, seen + functions + std::max(of_fits, neighbour_cell));
  return (reach + in_a_step) * h;
}

template <int D>
Window<D> seen_by(const Problem<D>& problem, const State<D>& s, const ImageParticles<D>& images) {
  constexpr int beyond = 4;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  const Grid<D>& grid = problem.grid;
  Vector<D> lower = Vector<D>::Constant(infinite), upper = -lower;
  for (const auto* places : {&s.particles.x, &images.particles.x})
    for (const Vector<D>& x : *places) {
      lower = lower.cwiseMin(x);
      upper = upper.cwiseMax(x);
    }
  const double widest = half_width(problem, s.particles);
  Window<D> window;
  for (int axis = 0; axis < D; ++axis) {
    const auto d = static_cast<std::size_t>(axis);
    const auto plane = [&](double at) {
      return std::clamp((at - grid.lower()[axis]) / grid.h(), 0.0, double(grid.cells(axis)));
    };
    // Pairs of cells, of which elements are made; none where there are no particles.
    const bool any = lower[axis] <= upper[axis];
    const int first = any ? static_cast<int>(plane(lower[axis] - widest)) - beyond : 0;
    const int last = any ? static_cast<int>(std::ceil(plane(upper[axis] + widest))) + beyond : 2;
    window.first[d] = std::max(first, 0) / 2 * 2;
    window.last[d] = std::min((last + 1) / 2 * 2, grid.cells(axis));
  }
  return window;
}

template <int D>
double half_width(const Problem<D>& problem, const Particles<D>& particles) {
  const Method& method = problem.method;
  if (method.domain == Domain::point && method.velocity != VelocityMap::cpls) return 0;
  double widest = 0;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    // Corners of fits are those of the parallelepiped, whatever the domain.
    widest = std::max(widest, half_widths(particles.parallelepiped(p).half_edges).maxCoeff());
    if (method.domain == Domain::ugimp)
      widest = std::max(widest, half_widths(particles.half_edges[p]).maxCoeff());
    if (particles.corners.empty()) continue;
    for (const Vector<D>& corner : particles.corners[p])
      widest = std::max(widest, (corner - particles.x[p]).cwiseAbs().maxCoeff());
  }
  return widest;
}

template <int D>
void require_parts(const Problem<D>& problem) {
  recon::detail::require(problem.method.mass == MassMatrix::lumped, "mass of the method",
                         name_of(problem.method.mass),
                         "must be lumped in a state of several parts, which have no common solver");
}

namespace {

// Calls each(per_particle, one, other) for the arrays of the same name.
template <int D, class One, class Other, class Each>
void for_both(const Kept& kept, One& one, Other& other, const Each& each) {
  one.arrays(kept, [&](const ParticleArray& array, auto& values) {
    other.arrays(kept, [&](const ParticleArray& with, auto& others) {
      if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::decay_t<decltype(others)>>)
        if (std::string_view(array.name) == with.name) each(array.per_particle, values, others);
    });
  });
}

}  // namespace

template <int D>
Particles<D> chosen(const Particles<D>& particles, const Kept& kept,
                    std::span<const std::size_t> numbers) {
  Particles<D> some;
  for_both<D>(kept, some, particles, [&](std::size_t each, auto& to, const auto& from) {
    if (from.empty()) return;
    to.reserve(numbers.size() * each);
    for (const std::size_t p : numbers)
      to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(p * each),
                from.begin() + static_cast<std::ptrdiff_t>((p + 1) * each));
  });
  return some;
}

template <int D>
void append(const Particles<D>& others, const Kept& kept, Particles<D>& to) {
  for_both<D>(kept, to, others, [](std::size_t, auto& all, const auto& more) {
    all.insert(all.end(), more.begin(), more.end());
  });
}

template <int D>
Particles<D> sized(const Kept& kept, std::size_t count) {
  Particles<D> whole;
  whole.arrays(kept, [&](const ParticleArray& array, auto& values) {
    values.resize(count * array.per_particle);
  });
  return whole;
}

template <int D>
void put(const Particles<D>& some, const Kept& kept, std::span<const std::uint32_t> numbers,
         Particles<D>& whole) {
  for_both<D>(kept, whole, some, [&](std::size_t each, auto& to, const auto& from) {
    using Offset = std::ptrdiff_t;
    if (from.empty()) return;
    for (std::size_t i = 0; i < numbers.size(); ++i)
      std::copy_n(from.begin() + static_cast<Offset>(i * each), each,
                  to.begin() + static_cast<Offset>(numbers[i] * each));
  });
}

template <int D>
void keep_first(std::size_t count, const Kept& kept, Particles<D>& particles) {
  particles.arrays(kept, [&](const ParticleArray& array, auto& values) {
    if (!values.empty()) values.resize(count * array.per_particle);
  });
}

#define RECON_INSTANTIATE(D)                                                                    \
  template double reach_of_copies(const Problem<D>&, double);                                   \
  template double half_width(const Problem<D>&, const Particles<D>&);                           \
  template Window<D> seen_by(const Problem<D>&, const State<D>&, const ImageParticles<D>&);     \
  template void require_parts(const Problem<D>&);                                               \
  template Particles<D> chosen(const Particles<D>&, const Kept&, std::span<const std::size_t>); \
  template void append(const Particles<D>&, const Kept&, Particles<D>&);                        \
  template Particles<D> sized(const Kept&, std::size_t);                                        \
  template void put(const Particles<D>&, const Kept&, std::span<const std::uint32_t>,           \
                    Particles<D>&);                                                             \
  template void keep_first(std::size_t, const Kept&, Particles<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
