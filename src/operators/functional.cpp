#include "recon/operators/functional.hpp"

#include <cmath>

#include "recon/core/error.hpp"

namespace recon {
namespace {

using detail::require;
using Powers = Functional::Powers;
using Offset = Functional::Offset;

// No product of four such lengths underflows, nor of their halves.
constexpr double least_length = 1e-75;

void require_length(const Offset& offset, const char* name) {
  for (const double length : offset) {
    require(std::isfinite(length), name, length, "must be finite");
    require(length == 0 || std::abs(length) >= least_length, name, length,
            "must be 0, or 1e-75 and more, so that its powers do not underflow: choose another "
            "unit of length");
  }
}

void require_axes(const Offset& offset, int dimension, const char* name) {
  for (int d = dimension; d < max_dimension; ++d)
    require(offset[d] == 0, name, offset[d], "must be 0 along axes that the points do not have");
}

double power(double x, int n) {
  double product = 1;
  for (int i = 0; i < n; ++i) product *= x;
  return product;
}

double monomial(const Offset& x, const Powers& powers) {
  double product = 1;
  for (int d = 0; d < max_dimension; ++d) product *= power(x[d], powers[d]);
  return product;
}

// A derivative of a monomial at x.
double differentiated(const Powers& derivative, const Powers& powers, const Offset& x) {
  double factor = 1;
  Powers left{};
  for (int d = 0; d < max_dimension; ++d) {
    left[d] = powers[d] - derivative[d];
    if (left[d] < 0) return 0;
    for (int n = left[d] + 1; n <= powers[d]; ++n) factor *= n;
  }
  return factor * monomial(x, left);
}

}  // namespace

OwnFunctional OwnFunctional::of(Action action) {
  require(action.numbers >= 1, "numbers of the functional", action.numbers, "must be at least 1");
  require(static_cast<bool>(action.act), "action of the functional", "empty", "must be a function");
  return OwnFunctional([action = std::move(action)](int) { return action; });
}

Functional Functional::partial(int nx, int ny, int nz) {
  for (const int order : {nx, ny, nz})
    require(order >= 0, "order of a partial derivative", order, "must not be negative");
  require(nx + ny + nz <= 4, "order of the partial derivative", nx + ny + nz, "must be at most 4");
  return Functional(Kind::partial, {nx, ny, nz});
}

int Functional::order() const {
  switch (kind_) {
    case Kind::value:
      return 0;
    case Kind::gradient:
      return 1;
    case Kind::partial:
      return orders_[0] + orders_[1] + orders_[2];
    default:
      return 2;
  }
}

std::vector<std::vector<Powers>> Functional::derivatives(int dimension) const {
  const auto along = [](int a, int b = -1) {
    Powers powers{};
    ++powers[a];
    if (b >= 0) ++powers[b];
    return powers;
  };
  std::vector<std::vector<Powers>> all;
  if (kind_ == Kind::value) all.push_back({Powers{}});
  if (kind_ == Kind::laplacian) all.push_back({});
  if (kind_ == Kind::partial) {
    for (int d = dimension; d < max_dimension; ++d)
      require(orders_[d] == 0, "axis of the partial derivative", d,
              "must be an axis of the points");
    all.push_back({orders_});
  }
  for (int a = 0; a < dimension; ++a) {
    if (kind_ == Kind::gradient) all.push_back({along(a)});
    if (kind_ == Kind::laplacian) all.back().push_back(along(a, a));
    for (int b = a; b < dimension && kind_ == Kind::hessian; ++b) all.push_back({along(a, b)});
  }
  return all;
}

OwnFunctional Functional::at(std::vector<Offset> offsets) const {
  require(!offsets.empty(), "offsets", offsets.size(), "must be at least one");
  for (const Offset& offset : offsets) require_length(offset, "offset");
  return OwnFunctional([functional = *this, offsets = std::move(offsets)](int dimension) {
    for (const Offset& offset : offsets) require_axes(offset, dimension, "offset");
    const auto sums = functional.derivatives(dimension);
    return OwnFunctional::Action{
        static_cast<int>(offsets.size() * sums.size()),
        [sums, offsets](std::size_t, const Powers& powers, std::span<double> out) {
          std::size_t i = 0;
          for (const Offset& offset : offsets)
            for (const std::vector<Powers>& sum : sums) {
              out[i] = 0;
              for (const Powers& derivative : sum)
                out[i] += differentiated(derivative, powers, offset);
              ++i;
            }
        }};
  });
}

OwnFunctional Functional::cell_average(const Offset& edges) {
  require_length(edges, "edge of the cell");
  for (const double edge : edges)
    require(edge >= 0, "edge of the cell", edge, "must not be negative");
  return OwnFunctional([edges](int dimension) {
    require_axes(edges, dimension, "edge of the cell");
    return OwnFunctional::Action{
        1, [edges](std::size_t, const Powers& powers, std::span<double> out) {
          out[0] = 1;
          for (int d = 0; d < max_dimension; ++d)
            out[0] *= powers[d] % 2 == 1 ? 0 : power(edges[d] / 2, powers[d]) / (powers[d] + 1);
        }};
  });
}

OwnFunctional Functional::line_integral(const Offset& from, const Offset& to) {
  for (const Offset& end : {from, to}) require_length(end, "end of the line");
  return OwnFunctional([from, to](int dimension) {
    for (const Offset& end : {from, to}) require_axes(end, dimension, "end of the line");
    return OwnFunctional::Action{
        1, [from, to](std::size_t, const Powers& powers, std::span<double> out) {
          // Three Gauss points, for polynomials up to degree 5.
          constexpr std::array<double, 3> weights{5.0 / 18, 8.0 / 18, 5.0 / 18};
          const double length = std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
          out[0] = 0;
          for (int i = 0; i < 3; ++i) {
            const double s = 0.5 + (i - 1) * std::sqrt(0.15);
            Offset x;
            for (int d = 0; d < max_dimension; ++d) x[d] = (1 - s) * from[d] + s * to[d];
            out[0] += weights[i] * length * monomial(x, powers);
          }
        }};
  });
}

}  // namespace recon
