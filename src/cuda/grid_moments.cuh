// The public class on top of the algorithms; each precision is compiled in a file of its own.
#pragma once

// Eigen is included, and is for the processor alone; its marks for nvcc are more than nvcc 13 likes.
#define EIGEN_NO_CUDA

#include "cuda/device.cuh"
#include "cuda/grid_moments_on.hpp"
#include "recon/cuda/grid_moments.hpp"

namespace recon::cuda {

template <int D, class T>
struct GridMoments<D, T>::OnDevice {
  GridMomentsOn<Device, D, T, Degrees<0, 1, 2>> moments;
};
template <int D, class T>
GridMoments<D, T>::GridMoments(const Sources<D, T>& sources, const StructuredGrid<T>& grid,
                               int components, const Options& options)
    : on_device_(new OnDevice{{sources.on_device(), grid, components, options}}) {}
template <int D, class T>
GridMoments<D, T>::GridMoments(GridMoments&&) noexcept = default;
template <int D, class T>
GridMoments<D, T>& GridMoments<D, T>::operator=(GridMoments&&) noexcept = default;
template <int D, class T>
GridMoments<D, T>::~GridMoments() = default;
template <int D, class T>
void GridMoments<D, T>::sum(const Field<const T>& field) {
  on_device_->moments.sum(field);
}
template <int D, class T>
void GridMoments<D, T>::solve(const Field<T>& values) {
  on_device_->moments.solve(values, {});
}
template <int D, class T>
void GridMoments<D, T>::solve(const Field<T>& values, const Field<T>& gradients) {
  detail::require(gradients.data != nullptr, "gradients", "null", "must have an address");
  on_device_->moments.solve(values, gradients);
}
template <int D, class T>
std::size_t GridMoments<D, T>::nodes() const {
  return on_device_->moments.nodes();
}
template <int D, class T>
int GridMoments<D, T>::per_node() const {
  return on_device_->moments.per_node();
}
template <int D, class T>
T* GridMoments<D, T>::values() {
  return on_device_->moments.values();
}
template <int D, class T>
const FitReport* GridMoments<D, T>::reports() const {
  return on_device_->moments.reports();
}

}  // namespace recon::cuda
