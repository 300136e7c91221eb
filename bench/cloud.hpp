// The workload "cloud": uniform random sources in the unit cube (square), random targets in
// [0.1, 0.9]^D, k nearest neighbours, a product of sines as the field.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "recon/core/instruction_set.hpp"
#include "recon/points/generate.hpp"
#include "recon/recon.hpp"

namespace recon_bench {

inline constexpr std::uint64_t source_seed = 1, target_seed = 2;

struct CloudSize {
  std::size_t sources, targets;
};
inline constexpr CloudSize cloud_size{200000, 100000}, smoke_cloud_size{2000, 1000};

// The four settings that are compared everywhere.
struct CloudSetting {
  int dimension, degree, k;
  std::string name() const {
    return std::to_string(dimension) + "-D degree " + std::to_string(degree) +
           " k=" + std::to_string(k);
  }
};
inline constexpr CloudSetting cloud_settings[] = {{3, 2, 20}, {3, 1, 8}, {2, 2, 12}, {2, 1, 6}};

template <class Scalar, int D>
struct Cloud {
  recon::PointList<Scalar, D> sources, targets;
  std::vector<Scalar> u;  // the field at the sources

  explicit Cloud(CloudSize size)
      : Cloud(recon::random_points<Scalar, D>(size.sources, source_seed), inner(size.targets)) {}

  Cloud(recon::PointList<Scalar, D> from, recon::PointList<Scalar, D> to)
      : sources(std::move(from)), targets(std::move(to)) {
    for (const auto& x : sources) u.push_back(static_cast<Scalar>(field(x)));
  }

  static double field(const std::array<Scalar, D>& x) {
    double product = 1;
    for (const Scalar c : x) product *= std::sin(2 * std::numbers::pi * static_cast<double>(c));
    return product;
  }

  recon::PointsView<Scalar> from() const { return recon::points_of(sources); }
  recon::PointsView<Scalar> to() const { return recon::points_of(targets); }

 private:
  static recon::PointList<Scalar, D> inner(std::size_t count) {
    auto points = recon::random_points<Scalar, D>(count, target_seed);
    for (auto& x : points)
      for (Scalar& c : x) c = Scalar(0.1) + Scalar(0.8) * c;
    return points;
  }
};

// Options::instruction_set and NeighbourOptions::instruction_set, where they exist.
template <class AnyOptions>
inline constexpr bool has_instruction_set = requires(AnyOptions options) {
  options.instruction_set;
};

template <class AnyOptions>
void use_instruction_set(AnyOptions& options, recon::InstructionSet set) {
  if constexpr (has_instruction_set<AnyOptions>) options.instruction_set = set;
}

// The stages of recon as a user calls them.
struct ReconCall {
  int degree = 1;
  std::size_t k = 1;
  int threads = 0;
  recon::Solver solver = recon::Solver::gram_schmidt;
  recon::InstructionSet set = recon::InstructionSet::automatic;
  recon::SearchMethod search = recon::SearchMethod::automatic;

  recon::Options options() const {
    recon::Options options;
    options.degree = degree;
    options.neighbours = recon::Nearest{k};
    options.solver = solver;
    options.search = search;
    options.threads = threads;
    use_instruction_set(options, set);
    return options;
  }

  template <class Scalar, int D>
  recon::NeighbourList<Scalar> find(const Cloud<Scalar, D>& cloud) const {
    recon::NeighbourOptions options;
    options.search = search;
    options.threads = threads;
    use_instruction_set(options, set);
    return recon::find_neighbours(recon::PointCloud<Scalar>(cloud.from()),
                                  recon::PointCloud<Scalar>(cloud.to()), recon::Nearest{k}, {},
                                  options);
  }

  template <class Scalar, int D>
  recon::BasicReconstruction<Scalar> construct(const Cloud<Scalar, D>& cloud,
                                               recon::NeighbourList<Scalar> list) const {
    return {cloud.from(), cloud.to(), std::move(list), options()};
  }

  template <class Scalar, int D>
  recon::BasicReconstruction<Scalar> reconstruct(const Cloud<Scalar, D>& cloud) const {
    return {cloud.from(), cloud.to(), options()};
  }
};

}  // namespace recon_bench
