#include "recon/neighbourhood/support_tensor.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/instantiate.hpp"
#include "core/symmetric_eigen.hpp"
#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"
#include "recon/neighbourhood/pair_supports.hpp"

namespace recon {
namespace detail {
namespace {

constexpr std::size_t tensors_per_block = 1024, targets_per_block = 256;

// The largest ratio of half axes: the square of it, times the precision, is the error of a weight.
template <class Scalar>
constexpr double most_elongated = sizeof(Scalar) == sizeof(float) ? 1e3 : 1e5;

template <int D>
Eigen::Matrix<double, D, D> matrix_of(const SymmetricTensor<D>& tensor) {
  Eigen::Matrix<double, D, D> matrix;
  for (int i = 0; i < D; ++i)
    for (int j = 0; j < D; ++j) matrix(i, j) = tensor(i, j);
  return matrix;
}

// By a formula, whose error is 1e-8 of the largest where two of them are close.
template <int D>
HalfAxes about_half_axes(const SymmetricTensor<D>& tensor) {
  if constexpr (D == 1) return {tensor(0, 0), tensor(0, 0)};
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, D, D>> solver;
  solver.computeDirect(matrix_of(tensor), Eigen::EigenvaluesOnly);
  return {solver.eigenvalues()[0], solver.eigenvalues()[D - 1]};
}

// Throws InvalidArgument unless this is a support tensor.
template <class Scalar, int D>
void require_tensor(const SymmetricTensor<D>& tensor, const std::string& whose, std::size_t index) {
  const auto name = [&](const std::string& what) {
    return what + " of " + whose + std::to_string(index);
  };
  for (int i = 0; i < D; ++i)
    for (int j = i; j < D; ++j)
      if (const double number = tensor(i, j); !std::isfinite(static_cast<Scalar>(number)))
        throw_invalid(name(std::string("support tensor ") + "xyz"[i] + "xyz"[j]), number,
                      "must be finite");
  const auto has_square = [](double length) {
    const auto rounded = static_cast<Scalar>(length);
    return rounded > 0 && std::isfinite(rounded * rounded) &&
           rounded * rounded >= std::numeric_limits<Scalar>::min();
  };
  const auto holds = [&](const HalfAxes& axes, double most) {
    return has_square(axes.smallest) && has_square(axes.largest) &&
           axes.largest <= most * axes.smallest;
  };
  if (holds(about_half_axes(tensor), most_elongated<Scalar> / 10)) return;
  const HalfAxes axes = half_axes(tensor);
  if (holds(axes, most_elongated<Scalar>)) return;
  if (!(axes.smallest > 0))
    throw_invalid(name("smallest eigenvalue of the support tensor"), axes.smallest,
                  "must be positive: the eigenvalues are the half axes");
  if (!has_square(axes.smallest) || !has_square(axes.largest))
    throw_invalid(name("half axis"), has_square(axes.smallest) ? axes.largest : axes.smallest,
                  "must have a square that neither underflows nor overflows");
  throw_invalid(name("ratio of the half axes"), axes.largest / axes.smallest,
                "must be at most " + to_text(most_elongated<Scalar>) + " in " +
                    (sizeof(Scalar) == sizeof(float) ? "float" : "double"));
}

// Throws InvalidArgument unless number i, if it is a full matrix, is symmetric up to rounding.
template <int D>
void require_symmetric(const FieldView<double>& tensors, std::size_t i, const std::string& whose) {
  if (tensors.components() == SymmetricTensor<D>::size) return;
  double largest = 0;
  for (int c = 0; c < D * D; ++c) largest = std::max(largest, std::abs(tensors(i, c)));
  for (int a = 0; a < D; ++a)
    for (int b = a + 1; b < D; ++b) {
      const double difference = tensors(i, a * D + b) - tensors(i, b * D + a);
      if (std::abs(difference) <= 1e-6 * largest || !std::isfinite(difference)) continue;
      const std::string ab{"xyz"[a], "xyz"[b]}, ba{"xyz"[b], "xyz"[a]};
      throw_invalid("difference of " + ab + " and " + ba + " in the support tensor of " + whose +
                        std::to_string(i),
                    std::abs(difference),
                    "must be 0, to 1e-6 of the largest entry: support tensors are symmetric");
    }
}

// Sets tensor number t of a list.
template <class Scalar, int D>
void put(const SymmetricTensor<D>& tensor, Array<Scalar>& packed, std::size_t t) {
  for (std::size_t n = 0; n < tensor.numbers.size(); ++n)
    packed[t * tensor.numbers.size() + n] = static_cast<Scalar>(tensor.numbers[n]);
}

// The largest half axis of each.
template <int D>
std::vector<double> largest_half_axes(const FieldView<double>& tensors, int threads) {
  std::vector<double> largest(tensors.size());
  recon::parallel_blocks(largest.size(), tensors_per_block, threads,
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t i = begin; i < end; ++i)
                             largest[i] = half_axes(tensor_at<D>(tensors, i)).largest;
                         });
  return largest;
}

template <int D, class Scalar>
void add_tensors(const Ellipsoids& rule, int threads, NeighbourList<Scalar>& list) {
  list.tensor.resize(list.targets() * SymmetricTensor<D>::size);
  recon::parallel_blocks(list.targets(), targets_per_block, threads,
                         [&](std::size_t begin, std::size_t end) {
                           for (std::size_t t = begin; t < end; ++t) {
                             const auto tensor = tensor_at<D>(rule.tensors, t);
                             put(tensor, list.tensor, t);
                             list.support[t] = static_cast<Scalar>(half_axes(tensor).largest);
                           }
                         });
}

template <int D, class Scalar>
void add_tensors(const PairEllipsoids& rule, int threads, NeighbourList<Scalar>& list) {
  const std::size_t count = list.targets();
  list.support.resize(count);
  list.tensor.resize(count * SymmetricTensor<D>::size);
  list.pair_tensor.resize(list.indices.size() * SymmetricTensor<D>::size);
  const std::vector<double> of_particles = largest_half_axes<D>(rule.particles, threads);
  const std::vector<double> of_targets = largest_half_axes<D>(rule.targets, threads);
  const double largest_of_all =
      of_particles.empty() ? 1 : *std::max_element(of_particles.begin(), of_particles.end());
  recon::parallel_blocks(
      count, targets_per_block, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
          double largest = 0;
          SymmetricTensor<D> sum;
          for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
            const std::size_t p = list.indices[e];
            const SymmetricTensor<D> tensor = pair_tensor<D>(rule, t, p);
            put(tensor, list.pair_tensor, static_cast<std::size_t>(e));
            largest = std::max(largest, of_targets.empty() ? of_particles[p]
                                                           : (of_particles[p] + of_targets[t]) / 2);
            sum = sum + tensor;
          }
          if (largest > 0) {
            sum = sum * (largest / half_axes(sum).largest);
          } else if (!of_targets.empty()) {
            sum = tensor_at<D>(rule.targets, t);
            largest = of_targets[t];
          } else {
            sum = SymmetricTensor<D>::ball(largest_of_all);
            largest = largest_of_all;
          }
          put(sum, list.tensor, t);
          list.support[t] = static_cast<Scalar>(largest);
        }
      });
}

}  // namespace

template <int D>
HalfAxes half_axes(const SymmetricTensor<D>& tensor) {
  if constexpr (D == 1) return {tensor(0, 0), tensor(0, 0)};
  const SymmetricEigen parts = symmetric_eigen(D, matrix_of(tensor).data());
  return {parts.values[0], parts.values[D - 1]};
}

void append_packed(const FieldView<double>& tensors, std::size_t i, double factor,
                   std::vector<double>& packed) {
  with_dimension(tensor_dimension(tensors.components()), [&](auto dimension) {
    for (const double number : tensor_at<dimension>(tensors, i).numbers)
      packed.push_back(number * factor);
  });
}

FieldView<double> view_of_packed(const std::vector<double>& packed, int dimension) {
  const int numbers = dimension * (dimension + 1) / 2;
  constexpr auto size = static_cast<std::ptrdiff_t>(sizeof(double));
  return {packed.size() / static_cast<std::size_t>(numbers), numbers, packed.data(), numbers * size,
          size};
}

template <class Scalar>
void require_tensors(const FieldView<double>& tensors, int dimension, std::size_t number,
                     const std::string& whose, const char* number_rule) {
  if (tensors.size() != number)
    throw_invalid("number of support tensors of " + whose.substr(0, whose.size() - 1) + "s",
                  tensors.size(), number_rule);
  if (number == 0) return;
  if (tensor_dimension(tensors.components()) != dimension)
    throw_invalid("components of a support tensor of a " + whose.substr(0, whose.size() - 1),
                  tensors.components(),
                  "must be " + std::to_string(dimension * (dimension + 1) / 2) + " (packed) or " +
                      std::to_string(dimension * dimension) + " (full) in " +
                      std::to_string(dimension) + " dimensions");
  with_dimension(dimension, [&](auto D) {
    for (std::size_t i = 0; i < number; ++i) {
      require_symmetric<D>(tensors, i, whose);
      require_tensor<Scalar>(tensor_at<D>(tensors, i), whose, i);
    }
  });
}

template <class Scalar>
void require_packed_tensors(const Array<Scalar>& tensors, int dimension, const std::string& whose) {
  with_dimension(dimension, [&](auto D) {
    using Tensor = SymmetricTensor<D>;
    for (std::size_t i = 0; i < tensors.size() / Tensor::size; ++i)
      require_tensor<Scalar>(Tensor::at(tensors.data() + i * Tensor::size), whose, i);
  });
}

template <class Scalar>
void add_support_tensors(const Ellipsoids& rule, int dimension, int threads,
                         NeighbourList<Scalar>& list) {
  with_dimension(dimension, [&](auto D) { add_tensors<D>(rule, threads, list); });
}
template <class Scalar>
void add_support_tensors(const PairEllipsoids& rule, int dimension, int threads,
                         NeighbourList<Scalar>& list) {
  with_dimension(dimension, [&](auto D) { add_tensors<D>(rule, threads, list); });
}

#define RECON_INSTANTIATE(S)                                                                       \
  template void require_tensors<S>(const FieldView<double>&, int, std::size_t, const std::string&, \
                                   const char*);                                                   \
  template void require_packed_tensors(const Array<S>&, int, const std::string&);                  \
  template void add_support_tensors(const Ellipsoids&, int, int, NeighbourList<S>&);               \
  template void add_support_tensors(const PairEllipsoids&, int, int, NeighbourList<S>&)
RECON_FLOAT(RECON_INSTANTIATE(float);)
RECON_INSTANTIATE(double);
#undef RECON_INSTANTIATE
template HalfAxes half_axes(const SymmetricTensor<1>&);
template HalfAxes half_axes(const SymmetricTensor<2>&);
template HalfAxes half_axes(const SymmetricTensor<3>&);

}  // namespace detail

std::vector<double> support_tensors(const FieldView<double>& half_axes) {
  const int components = half_axes.components();
  detail::require(components == 1 || components == 4 || components == 9, "components of half axes",
                  components, "must be 1, 4 or 9: D vectors of D numbers");
  std::vector<double> packed;
  const int D = detail::tensor_dimension(components);
  packed.reserve(half_axes.size() * static_cast<std::size_t>(D * (D + 1) / 2));
  for (std::size_t p = 0; p < half_axes.size(); ++p) {
    std::array<double, 9> axes, squares{};  // axes[c + D i]: component c of half axis i
    for (int c = 0; c < D * D; ++c) {
      axes[c] = half_axes(p, c);
      if (!std::isfinite(axes[c]))
        detail::throw_invalid("half axes of particle " + std::to_string(p), axes[c],
                              "must be finite");
    }
    for (int i = 0; i < D; ++i)
      for (int j = 0; j < D; ++j)
        for (int k = 0; k < D; ++k) squares[i * D + j] += axes[i + D * k] * axes[j + D * k];
    const detail::SymmetricEigen parts = detail::symmetric_eigen(D, squares.data());
    // The roots of the eigenvalues of F F^T would have lost half of the digits.
    std::array<double, 3> length;
    for (int d = 0; d < D; ++d) {
      double square = 0;
      for (int k = 0; k < D; ++k) {
        double along = 0;
        for (int c = 0; c < D; ++c) along += axes[c + D * k] * parts.direction[d][c];
        square += along * along;
      }
      length[d] = std::sqrt(square);
    }
    for (int i = 0; i < D; ++i)
      for (int j = i; j < D; ++j) {
        double entry = 0;
        for (int d = 0; d < D; ++d)
          entry += length[d] * parts.direction[d][i] * parts.direction[d][j];
        packed.push_back(entry);
      }
  }
  return packed;
}

}  // namespace recon
