// The public classes on top of the algorithms; each dimension and precision is compiled in a file
// of its own.
#pragma once

#include "cuda/device.cuh"
#include "cuda/reconstruction_on.hpp"
#include "recon/cuda/reconstruct.hpp"

namespace recon::cuda {

template <int D, class T>
using OnTheGpu = ReconstructionOn<Device, D, T, Degrees<0, 1, 2>>;

template <int D, class T>
Sources<D, T>::Sources(const Points<D, T>& points, const SourcesOptions& options, Stream stream)
    : on_device_(std::make_shared<SourcesOn<Device, D, T>>(std::make_shared<Device>(stream), points,
                                                           options)) {}
template <int D, class T>
void Sources<D, T>::update(const Points<D, T>& points) {
  on_device_->update(points);
}
template <int D, class T>
void Sources<D, T>::check() const {
  on_device_->check();
}
template <int D, class T>
std::size_t Sources<D, T>::size() const {
  return on_device_->size();
}
template <int D, class T>
const std::uint32_t* Sources<D, T>::order() const {
  return on_device_->order();
}

template <int D, class T>
struct Operator<D, T>::Numbers : OnTheGpu<D, T>::Operator {};
template <int D, class T>
Operator<D, T>::Operator() : numbers_(std::make_unique<Numbers>()) {}
template <int D, class T>
Operator<D, T>::Operator(Operator&&) noexcept = default;
template <int D, class T>
Operator<D, T>& Operator<D, T>::operator=(Operator&&) noexcept = default;
template <int D, class T>
Operator<D, T>::~Operator() = default;
template <int D, class T>
int Operator<D, T>::blocks() const {
  return numbers_->blocks;
}
template <int D, class T>
const T* Operator<D, T>::values() const {
  return numbers_->values.data();
}

template <int D, class T>
struct Reconstruction<D, T>::OnDevice {
  OnTheGpu<D, T> fit;
};
template <int D, class T>
Reconstruction<D, T>::Reconstruction(const Sources<D, T>& sources, const Points<D, T>& targets,
                                     const Options& options)
    : on_device_(new OnDevice{{sources.on_device(), targets, options}}) {}
template <int D, class T>
Reconstruction<D, T>::Reconstruction(Reconstruction&&) noexcept = default;
template <int D, class T>
Reconstruction<D, T>& Reconstruction<D, T>::operator=(Reconstruction&&) noexcept = default;
template <int D, class T>
Reconstruction<D, T>::~Reconstruction() = default;
template <int D, class T>
void Reconstruction<D, T>::update(const Points<D, T>& targets) {
  on_device_->fit.update(targets);
}
template <int D, class T>
void Reconstruction<D, T>::reserve(std::int64_t neighbours, std::int64_t of_one_target) {
  on_device_->fit.reserve(neighbours, of_one_target);
}
template <int D, class T>
void Reconstruction<D, T>::check() const {
  on_device_->fit.check();
}
template <int D, class T>
std::size_t Reconstruction<D, T>::targets() const {
  return on_device_->fit.targets();
}
template <int D, class T>
const FitReport* Reconstruction<D, T>::reports() const {
  return on_device_->fit.reports();
}
template <int D, class T>
const T* Reconstruction<D, T>::support() const {
  return on_device_->fit.support();
}
template <int D, class T>
CsrRows Reconstruction<D, T>::rows() const {
  const OnTheGpu<D, T>& fit = on_device_->fit;
  return {fit.targets(), fit.offsets(), fit.columns(), fit.shifts(), fit.target_of()};
}
template <int D, class T>
const T* Reconstruction<D, T>::values() const {
  return on_device_->fit.values().values.data();
}
template <int D, class T>
std::int64_t Reconstruction<D, T>::entries() const {
  return on_device_->fit.entries();
}
template <int D, class T>
Operator<D, T> Reconstruction<D, T>::gradient(Derivative kind) {
  Operator<D, T> made;
  gradient(made, kind);
  return made;
}
template <int D, class T>
Operator<D, T> Reconstruction<D, T>::hessian() {
  Operator<D, T> made;
  hessian(made);
  return made;
}
template <int D, class T>
Operator<D, T> Reconstruction<D, T>::laplacian() {
  Operator<D, T> made;
  laplacian(made);
  return made;
}
template <int D, class T>
void Reconstruction<D, T>::gradient(Operator<D, T>& into, Derivative kind) {
  on_device_->fit.derive(Asked::gradient, kind, into.numbers());
}
template <int D, class T>
void Reconstruction<D, T>::hessian(Operator<D, T>& into) {
  on_device_->fit.derive(Asked::hessian, Derivative::diffuse, into.numbers());
}
template <int D, class T>
void Reconstruction<D, T>::laplacian(Operator<D, T>& into) {
  on_device_->fit.derive(Asked::laplacian, Derivative::diffuse, into.numbers());
}
template <int D, class T>
void Reconstruction<D, T>::apply(const Field<const T>& in, const Field<T>& out) {
  on_device_->fit.apply(on_device_->fit.values(), in, out);
}
template <int D, class T>
void Reconstruction<D, T>::apply(const Operator<D, T>& values, const Field<const T>& in,
                                 const Field<T>& out) {
  on_device_->fit.apply(values.numbers(), in, out);
}
template <int D, class T>
void Reconstruction<D, T>::apply_transpose(const Field<const T>& in, const Field<T>& out) {
  on_device_->fit.apply_transpose(on_device_->fit.values(), in, out);
}
template <int D, class T>
void Reconstruction<D, T>::apply_transpose(const Operator<D, T>& values, const Field<const T>& in,
                                           const Field<T>& out) {
  on_device_->fit.apply_transpose(values.numbers(), in, out);
}

}  // namespace recon::cuda

// In a file of its own for each.
#define RECON_CUDA_INSTANTIATE(D, T)     \
  namespace recon::cuda {                \
  template class Sources<D, T>;          \
  template class Operator<D, T>;         \
  template class Reconstruction<D, T>;   \
  }
