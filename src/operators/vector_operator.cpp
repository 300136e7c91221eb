#include "recon/operators/vector_operator.hpp"

#include <cmath>
#include <string>

#include "core/instantiate.hpp"
#include "operators/product.hpp"
#include "recon/core/error.hpp"
#include "recon/core/parallel.hpp"
#include "recon/core/sums.hpp"
#include "recon/points/make_view.hpp"

namespace recon {
namespace {

using detail::require;

constexpr std::size_t targets_per_block = 4096;

}  // namespace

template <class Scalar>
VectorOperator<Scalar>::VectorOperator(CsrOperator<Scalar> gradient, VectorFunctional functional)
    : gradient_(std::move(gradient)) {
  const int D = gradient_.blocks();
  const Scalar one = 1, half = Scalar(0.5);
  switch (functional.kind()) {
    case VectorFunctional::Kind::divergence:
      for (int d = 0; d < D; ++d) terms_.push_back({0, d, d, one});
      outputs_ = 1;
      break;
    case VectorFunctional::Kind::curl:
      require(D > 1, "dimension of the curl", D, "must be 2 or 3");
      if (D == 2) {
        terms_ = {{0, 1, 0, one}, {0, 0, 1, -one}};
        outputs_ = 1;
        break;
      }
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        terms_.push_back({i, k, j, one});
        terms_.push_back({i, j, k, -one});
      }
      outputs_ = 3;
      break;
    case VectorFunctional::Kind::strain_rate:
      for (int a = 0; a < D; ++a)
        for (int b = a; b < D; ++b, ++outputs_) {
          if (a == b) {
            terms_.push_back({outputs_, a, a, one});
          } else {
            terms_.push_back({outputs_, a, b, half});
            terms_.push_back({outputs_, b, a, half});
          }
        }
      break;
  }
}

template <class Scalar>
void VectorOperator<Scalar>::apply(const FieldView<Scalar>& field,
                                   const FieldSpan<Scalar>& out) const {
  require(field.components() == inputs(), "components of the field", field.components(),
          "must be as many as there are dimensions");
  require(out.size() == rows(), "size of the output", out.size(), "must be the number of targets");
  require(out.components() == outputs_, "components of the output", out.components(),
          "must be outputs()");
  // Unchecked, because of components of the gradient that nobody asked for: what is asked for is
  // checked below.
  const int D = inputs();
  Matrix slopes(static_cast<Eigen::Index>(rows()), D * D);
  gradient_.apply(field, field_of(slopes), trusted);
  parallel_blocks(
      rows(), targets_per_block, gradient_.threads(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
          for (int i = 0; i < outputs_; ++i) out(t, i) = 0;
          for (const Term& term : terms_)
            out(t, term.output) +=
                term.factor * slopes(static_cast<Eigen::Index>(t), term.component * D + term.axis);
        }
      });
  const std::vector<std::uint32_t> empty = gradient_.empty_rows();
  for (const std::uint32_t t : empty)
    for (int i = 0; i < outputs_; ++i) out(t, i) = gradient_.fill();
  auto next = empty.begin();
  for (std::size_t t = 0; t < rows(); ++t) {
    if (next != empty.end() && *next == t) {
      ++next;
      continue;
    }
    for (int i = 0; i < outputs_; ++i)
      if (!std::isfinite(out(t, i))) [[unlikely]]
        out(t, i) = mended(field, t, i);
  }
}

// One number formed again with scaled factors, without numbers of the field that are multiplied by 0.
template <class Scalar>
Scalar VectorOperator<Scalar>::mended(const FieldView<Scalar>& field, std::size_t t,
                                      int output) const {
  const auto row = gradient_.row(t);
  Scalar sum = 0;
  for (const Term& term : terms_) {
    if (term.output != output) continue;
    const auto data = [&](std::size_t i) {
      const ParticleIndex particle = row.particle(i);
      const Scalar value = field(particle, term.component);
      if (std::isfinite(value)) return value;
      if (row.value(i, term.axis) != 0)
        detail::throw_not_finite(particle, term.component, static_cast<double>(value));
      return Scalar(0);
    };
    sum +=
        term.factor * detail::scaled_sum_of_products<Scalar>(
                          row.size(), [&](std::size_t i) { return row.value(i, term.axis); }, data);
  }
  if (!std::isfinite(sum))
    detail::throw_invalid(
        "component " + std::to_string(output) + " of the result at target " + std::to_string(t),
        sum, "overflows: the slopes of the data are too large");
  return sum;
}

template <class Scalar>
void VectorOperator<Scalar>::apply_transpose(const FieldView<Scalar>& field,
                                             const FieldSpan<Scalar>& out) const {
  require(field.size() == rows(), "size of the field", field.size(),
          "must be the number of targets");
  require(field.components() == outputs_, "components of the field", field.components(),
          "must be outputs()");
  const int D = inputs();
  Matrix slopes = Matrix::Zero(static_cast<Eigen::Index>(rows()), D * D);
  parallel_blocks(rows(), targets_per_block, gradient_.threads(),
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t t = begin; t < end; ++t)
                      for (const Term& term : terms_) {
                        Scalar value = field(t, term.output);
                        if (!std::isfinite(value)) [[unlikely]] {
                          if (reads(t, term.axis))
                            detail::throw_not_finite(t, term.output, static_cast<double>(value));
                          value = 0;
                        }
                        slopes(static_cast<Eigen::Index>(t), term.component * D + term.axis) +=
                            term.factor * value;
                      }
                  });
  gradient_.apply_transpose(field_of(std::as_const(slopes)), out);
}

template <class Scalar>
bool VectorOperator<Scalar>::reads(std::size_t target, int axis) const {
  const auto row = gradient_.row(target);
  for (std::size_t i = 0; i < row.size(); ++i)
    if (row.value(i, axis) != 0) return true;
  return false;
}

template <class Scalar>
typename VectorOperator<Scalar>::Matrix VectorOperator<Scalar>::apply(
    const FieldView<Scalar>& field) const {
  Matrix out(static_cast<Eigen::Index>(rows()), outputs_);
  apply(field, field_of(out));
  return out;
}

template <class Scalar>
typename VectorOperator<Scalar>::Matrix VectorOperator<Scalar>::apply_transpose(
    const FieldView<Scalar>& field) const {
  Matrix out(static_cast<Eigen::Index>(columns()), inputs());
  apply_transpose(field, field_of(out));
  return out;
}

RECON_FLOAT(template class VectorOperator<float>;)
template class VectorOperator<double>;

}  // namespace recon
