// A linear map from vector fields of particles to targets that mixes components: divergence, curl,
// strain rate.
//
//     out(t, i) = sum over c, d of factor(i, c, d) * du_c/dx_d (t) ,
// with the gradient operator of a reconstruction and factors that do not depend on the target. The
// transpose takes target data f back to particles, so that <apply(u), f> = <u, apply_transpose(f)>
// to rounding: the transpose of the divergence is the discrete (negative) gradient of the weak
// form.
#pragma once

#include <vector>

#include "recon/operators/csr_operator.hpp"
#include "recon/operators/functional.hpp"

namespace recon {

template <class Scalar>
class VectorOperator {
 public:
  using Matrix = typename CsrOperator<Scalar>::Matrix;

  VectorOperator() = default;
  // Throws InvalidArgument for a curl in one dimension.
  VectorOperator(CsrOperator<Scalar> gradient, VectorFunctional functional);

  std::size_t rows() const { return gradient_.rows(); }        // targets
  std::size_t columns() const { return gradient_.columns(); }  // particles
  int inputs() const { return gradient_.blocks(); }            // components of a field of particles
  int outputs() const { return outputs_; }                     // components at a target
  const CsrOperator<Scalar>& gradient() const& { return gradient_; }
  const CsrOperator<Scalar>& gradient() && = delete;
  // The sum above: output += factor * (derivative of the component along the axis).
  struct Term {
    int output, component, axis;
    Scalar factor;
  };
  const std::vector<Term>& terms() const { return terms_; }

  // A row per target; the fill value of the gradient where there is no support. Throws
  // InvalidArgument as CsrOperator does, naming the components of these fields, and for fields of
  // other than inputs() components.
  Matrix apply(const FieldView<Scalar>& field) const;
  void apply(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out) const;
  // A row per particle, of fields of outputs() components.
  Matrix apply_transpose(const FieldView<Scalar>& field) const;
  void apply_transpose(const FieldView<Scalar>& field, const FieldSpan<Scalar>& out) const;

 private:
  Scalar mended(const FieldView<Scalar>& field, std::size_t target, int output) const;
  // Has any particle a slope other than 0 along the axis at this target?
  bool reads(std::size_t target, int axis) const;

  CsrOperator<Scalar> gradient_;
  std::vector<Term> terms_;
  int outputs_ = 0;
};

extern template class VectorOperator<float>;
extern template class VectorOperator<double>;

}  // namespace recon
