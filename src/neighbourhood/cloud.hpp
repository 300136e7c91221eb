// What Sources own: particles in the order of cells, and the searches over them.
//
// Inside the library a particle is numbered by its place in that order; caller_of() and place_of()
// translate. Coordinates are divided by the stretch, in which an anisotropic support is a ball or a
// cube, and wrapped into the periodic domain.
#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <variant>
#include <vector>

#include "core/counting_sort.hpp"
#include "neighbourhood/search_index.hpp"
#include "recon/neighbourhood/sources.hpp"

namespace recon::detail {

template <class Scalar>
class Cloud {
 public:
  Cloud(const PointsView<Scalar>& points, const SourcesOptions& options);
  Cloud(const Cloud&) = delete;
  Cloud& operator=(const Cloud&) = delete;

  // Gives the strong guarantee. Without weights those that there are stay.
  void update(const PointsView<Scalar>& points, const std::span<const double>* weights);

  // Counts the updates: what was made of the cloud at another count is stale.
  std::uint64_t version() const { return version_; }

  const PointCloud<Scalar>& points() const { return *points_; }
  const PeriodicDomain<Scalar>& domain() const { return domain_; }
  const PeriodicDomain<double>& callers_domain() const { return options_.domain; }
  const std::array<double, max_dimension>& stretch() const { return options_.stretch; }
  std::span<const double> callers_weights() const { return callers_weights_; }
  // Divided by the largest; null: all ones.
  const Scalar* weights() const { return weights_.empty() ? nullptr : weights_.data(); }

  std::span<const std::uint32_t> caller_of() const { return caller_of_; }
  // Made when it is first asked for.
  std::span<const std::uint32_t> place_of() const;

  // Places to the caller's numbers in a list, and back from one list into another (or the same).
  void to_callers(std::span<ParticleIndex> indices, int threads) const;
  void to_places(std::span<const ParticleIndex> indices, ParticleIndex* places, int threads) const;

  // Points of the caller in the coordinates of the cloud, in the caller's order, into `into`.
  void take_targets(const PointsView<Scalar>& targets, const char* name, int threads,
                    PointCloud<Scalar>& into) const;

  // The order in which targets follow each other in space.
  void order(const PointCloud<Scalar>& targets, int threads, CountingSort& sort) const;

  // Neighbours in numbers of places, of targets in the coordinates of the cloud; see
  // find_with_index(). The rule speaks of the caller's particles.
  void find(const PointCloud<Scalar>& targets, const NeighbourRule& rule,
            const NeighbourOptions& options, const RowsAsked& rows,
            NeighbourList<Scalar>& list) const;
  // Gives back the memory that searches keep for the next one. No search may be going on.
  void forget_buffers() const;

 private:
  template <int D>
  void build(int threads);
  // use(*Kept<D>), with what is kept for the dimension of the points.
  template <class Use>
  void with_kept(const Use& use) const;

  // Owns the numbers of the caller's options, where spans refer to.
  SourcesOptions options_;
  std::vector<double> callers_weights_;
  PeriodicDomain<Scalar> domain_;
  PointCloud<Scalar> incoming_;
  const PointCloud<Scalar>* points_ = nullptr;  // those of the cells
  std::vector<Scalar> weights_;
  std::span<const std::uint32_t> caller_of_;
  std::uint64_t version_ = 0;

  template <int D>
  struct Kept {
    std::shared_ptr<CellGrid<Scalar, D>> ordered;
    SearchIndex<Scalar, D> index{ordered->sorted_cells().points()};
  };
  std::variant<std::monostate, std::unique_ptr<Kept<1>>, std::unique_ptr<Kept<2>>,
               std::unique_ptr<Kept<3>>>
      kept_;

  mutable std::mutex mutex_;
  mutable std::uint64_t placed_version_ = ~std::uint64_t{0};
  mutable Array<std::uint32_t> place_of_;
};

extern template class Cloud<float>;
extern template class Cloud<double>;

}  // namespace recon::detail
