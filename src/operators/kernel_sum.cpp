#include "recon/operators/kernel_sum.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "core/instantiate.hpp"
#include "neighbourhood/cloud.hpp"
#include "operators/search_options.hpp"
#include "recon/core/parallel.hpp"

namespace recon {
namespace {

constexpr std::size_t targets_per_block = 256;

// The integral of w(q) q^power over 0 <= q <= 1: Gauss-Legendre with four points in intervals that
// halve towards q = 0, where narrow weights have their all, each cut into 60, so that the knots of
// the B-splines are among the borders.
double radial_moment(const WeightFunction& weight, int power) {
  constexpr int levels = 60, pieces = 60;
  constexpr std::array<double, 4> place{-0.86113631159405258, -0.33998104358485626,
                                        0.33998104358485626, 0.86113631159405258};
  constexpr std::array<double, 4> share{0.34785484513745386, 0.65214515486254614,
                                        0.65214515486254614, 0.34785484513745386};
  double sum = 0;
  for (int level = 0; level <= levels; ++level) {
    const double upper = std::ldexp(1.0, -level), lower = level < levels ? upper / 2 : 0;
    const double piece = (upper - lower) / pieces;
    double part = 0;
    for (int i = 0; i < pieces; ++i) {
      std::array<double, 4> q, w;
      for (std::size_t g = 0; g < 4; ++g) q[g] = lower + (i + 0.5 + 0.5 * place[g]) * piece;
      weight.evaluate(q.data(), w.data(), nullptr, 4);
      for (std::size_t g = 0; g < 4; ++g) part += share[g] / 2 * w[g] * std::pow(q[g], power);
    }
    sum += part * piece;
  }
  return sum;
}

// 1 / (c rho^D) at target t, with `unit` the part of c rho^D that all targets share.
template <class Scalar>
Scalar norm_of(double unit, Scalar rho, int dimension, std::size_t t) {
  const double power = std::pow(static_cast<double>(rho), dimension);
  const auto norm = static_cast<Scalar>(1 / (unit * power));
  // Below the smallest normal number digits are lost.
  if (!std::isnormal(power) || !std::isnormal(unit * power) || !std::isnormal(norm)) [[unlikely]]
    detail::throw_invalid("support radius of target " + std::to_string(t) + " in a kernel sum", rho,
                          "must have a 1 / (c rho^D) that is a normal number in " +
                              std::string(sizeof(Scalar) == sizeof(float) ? "float" : "double") +
                              ", and it is " + detail::to_text(1 / (unit * power)) +
                              ": choose another unit of length");
  return norm;
}

// 1 / (c det A) of a support tensor, as norm_of() gives it for a ball; `whose` names it.
template <class Scalar, int D>
Scalar norm_of_tensor(double unit, const detail::SymmetricTensor<D>& tensor,
                      const std::string& whose) {
  const double volume = unit * tensor.determinant();
  const auto norm = static_cast<Scalar>(1 / volume);
  if (!std::isnormal(volume) || !std::isnormal(norm)) [[unlikely]]
    detail::throw_invalid("determinant of the support tensor of " + whose + " in a kernel sum",
                          tensor.determinant(),
                          "must have a 1 / (c det A) that is a normal number in " +
                              std::string(sizeof(Scalar) == sizeof(float) ? "float" : "double") +
                              ": choose another unit of length");
  return norm;
}

// What turns the offsets of a target's entries, `count` along each axis, into A^-1 (x_p - x), and
// sets `w` to 1 / (c det A), where supports are ellipsoids.
template <int D, class Scalar>
void to_tensors(const NeighbourList<Scalar>& list, std::size_t t, double unit, Scalar* offsets,
                Scalar* w) {
  using Tensor = detail::SymmetricTensor<D>;
  const auto count = static_cast<std::size_t>(list.count(t));
  const bool of_pairs = !list.pair_tensor.empty();
  const auto first = static_cast<std::size_t>(list.offsets[t]);
  Tensor inverse;
  Scalar norm = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (of_pairs || i == 0) {
      const Tensor tensor =
          Tensor::at(of_pairs ? list.pair_tensor.data() + (first + i) * Tensor::size
                              : list.tensor.data() + t * Tensor::size);
      inverse = tensor.inverse();
      norm = norm_of_tensor<Scalar>(
          unit, tensor,
          of_pairs ? "entry " + std::to_string(first + i) : "target " + std::to_string(t));
    }
    std::array<double, D> offset;
    for (std::size_t d = 0; d < D; ++d) offset[d] = static_cast<double>(offsets[d * count + i]);
    const auto turned = inverse.times(offset);
    for (std::size_t d = 0; d < D; ++d) offsets[d * count + i] = static_cast<Scalar>(turned[d]);
    w[i] = norm;
  }
}

// The values of a list, in numbers of places, of targets in the coordinates of the cloud.
template <class Scalar>
void evaluate_kernels(const detail::Cloud<Scalar>& cloud, const PointCloud<Scalar>& targets,
                      const NeighbourList<Scalar>& list, const KernelOptions& options,
                      Array<Scalar>& values) {
  const PointCloud<Scalar>& particles = cloud.points();
  const int dimension = particles.dimension();
  const bool radial = options.form == WeightForm::radial;
  const double integral = weight_integral(options.weight, options.form, dimension);
  detail::require(integral > 0 && std::isfinite(integral), "integral of the weight", integral,
                  "must be positive and finite");
  double unit = integral;
  for (int d = 0; d < dimension; ++d) unit *= cloud.stretch()[d];
  values.resize(list.indices.size());
  const bool has_tensors = !list.tensor.empty();  // and where pairs have tensors targets have too
  parallel_blocks(
      list.targets(), targets_per_block, options.threads, [&](std::size_t begin, std::size_t end) {
        std::vector<Scalar> q, offsets;
        for (std::size_t t = begin; t < end; ++t) {
          const std::int64_t first = list.offsets[t];
          const auto count = static_cast<std::size_t>(list.count(t));
          Scalar* const w = values.data() + first;
          const Scalar* const of_pairs =
              list.pair_support.empty() ? nullptr : list.pair_support.data() + first;
          const auto rho = [&](std::size_t i) { return of_pairs ? of_pairs[i] : list.support[t]; };
          offsets.resize(count * static_cast<std::size_t>(dimension));
          for (int d = 0; d < dimension; ++d)
            for (std::size_t i = 0; i < count; ++i) {
              const std::size_t e = static_cast<std::size_t>(first) + i;
              Scalar along = particles(list.indices[e], d) - targets(t, d);
              if (!list.shifts.empty())
                along += static_cast<Scalar>(list.shifts[e][d]) * cloud.domain().period(d);
              offsets[static_cast<std::size_t>(d) * count + i] =
                  has_tensors ? along : along / rho(i);
            }
          if (has_tensors) {
            detail::with_dimension(
                dimension, [&](auto D) { to_tensors<D>(list, t, unit, offsets.data(), w); });
          } else {
            std::fill_n(w, count, norm_of(unit, list.support[t], dimension, t));
            for (std::size_t i = 0; of_pairs && i < count; ++i)
              w[i] = norm_of(unit, of_pairs[i], dimension, t);
          }
          // Radial: q is the length of an offset; tensor product: one factor for each axis.
          q.assign(count, Scalar(0));
          for (int d = 0; d < dimension; ++d) {
            for (std::size_t i = 0; i < count; ++i) {
              const Scalar along = offsets[static_cast<std::size_t>(d) * count + i];
              q[i] = radial ? q[i] + along * along : std::abs(along);
            }
            if (radial) continue;
            options.weight.evaluate(q.data(), q.data(), nullptr, count);
            for (std::size_t i = 0; i < count; ++i) w[i] *= q[i];
          }
          if (!radial) continue;
          for (Scalar& square : q) square = std::sqrt(square);
          options.weight.evaluate(q.data(), q.data(), nullptr, count);
          for (std::size_t i = 0; i < count; ++i) w[i] *= q[i];
        }
      });
}

}  // namespace

double weight_integral(const WeightFunction& weight, WeightForm form, int dimension) {
  detail::require(dimension >= 1 && dimension <= max_dimension, "dimension", dimension,
                  "must be 1, 2 or 3");
  detail::require_form(form);
  if (form == WeightForm::tensor_product) return std::pow(2 * radial_moment(weight, 0), dimension);
  constexpr std::array<double, max_dimension> unit_sphere{2, 2 * std::numbers::pi,
                                                          4 * std::numbers::pi};
  return unit_sphere[dimension - 1] * radial_moment(weight, dimension - 1);
}

template <class Scalar>
CsrOperator<Scalar> kernel_operator(const BasicSources<Scalar>& sources,
                                    const PointsView<Scalar>& targets,
                                    const KernelOptions& options) {
  const detail::Cloud<Scalar>& cloud = *sources.cloud();
  detail::require_form(options.form);
  detail::require(options.form == WeightForm::radial ||
                      !std::holds_alternative<PairEllipsoids>(options.support),
                  "form", "tensor_product",
                  "must be radial where pairs have ellipsoids of their own");
  const NeighbourOptions search = detail::search_options(options, options.form);
  PointCloud<Scalar> at;
  cloud.take_targets(targets, "targets", options.threads, at);
  auto pattern = std::make_shared<SparsityPattern<Scalar>>();
  NeighbourList<Scalar>& list = pattern->neighbours;
  cloud.find(at, options.support, search, {.by_index = true}, list);
  if (std::holds_alternative<Nearest>(options.support) ||
      std::holds_alternative<NearestWithin>(options.support)) {
    const std::vector<double> radii(list.support.begin(), list.support.end());
    cloud.find(at, Radii{radii}, search, {.by_index = true}, list);
  }
  Array<Scalar> values;
  evaluate_kernels(cloud, at, list, options, values);
  cloud.to_callers(list.indices, options.threads);
  pattern->columns = cloud.points().size();
  pattern->cloud = sources.cloud();
  pattern->version = cloud.version();
  pattern->remedy = "make the kernel operator anew";
  return CsrOperator<Scalar>(std::move(pattern), std::move(values), 1, Scalar(0), options.threads);
}

RECON_FLOAT(template CsrOperator<float> kernel_operator(const SourcesF&, const PointsView<float>&,
                                                        const KernelOptions&);)
template CsrOperator<double> kernel_operator(const Sources&, const PointsView<double>&,
                                             const KernelOptions&);

}  // namespace recon
