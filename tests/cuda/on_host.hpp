// The algorithms of the GPU on the processor: views of lists of points, and what came of them.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "cuda/host.hpp"
#include "cuda/sources_on.hpp"
#include "recon/points/generate.hpp"
#include "recon/points/make_view.hpp"

namespace recon::testing {

template <std::size_t D, class T>
cuda::Points<static_cast<int>(D), T> view_of(const std::vector<std::array<T, D>>& points) {
  return {points.empty() ? nullptr : points[0].data(), points.size()};
}

template <int D, class T>
using HostSources = cuda::SourcesOn<cuda::Host, D, T>;

template <std::size_t D, class T>
std::shared_ptr<HostSources<static_cast<int>(D), T>> host_sources(
    const std::vector<std::array<T, D>>& points, const SourcesOptions& options = {}) {
  return std::make_shared<HostSources<static_cast<int>(D), T>>(std::make_shared<cuda::Host>(),
                                                               view_of(points), options);
}

}  // namespace recon::testing
