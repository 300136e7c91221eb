#include "recon/shape/shape_kernel.hpp"

#include "recon/core/error.hpp"

namespace recon {

namespace detail {
template <class Scalar, int D>
std::unique_ptr<ShapeKernel<Scalar>> make_kernel(const ShapeChoice& choice);  // kernel_*.cpp
}

template <class Scalar>
std::unique_ptr<ShapeKernel<Scalar>> make_shape_kernel(int dimension, const ShapeChoice& choice) {
  switch (dimension) {
    case 1:
      return detail::make_kernel<Scalar, 1>(choice);
    case 2:
      return detail::make_kernel<Scalar, 2>(choice);
    case 3:
      return detail::make_kernel<Scalar, 3>(choice);
    default:
      detail::throw_invalid("dimension", dimension, "must be 1, 2 or 3");
  }
}

template std::unique_ptr<ShapeKernel<float>> make_shape_kernel(int, const ShapeChoice&);
template std::unique_ptr<ShapeKernel<double>> make_shape_kernel(int, const ShapeChoice&);

}  // namespace recon
