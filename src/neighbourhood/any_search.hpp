// One of the searches of recon behind a pointer, and the neighbours of one target after another by
// it: what rules ask of single targets is compiled once for all searches.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "recon/neighbourhood/find_neighbours.hpp"
#include "recon/neighbourhood/search.hpp"

namespace recon::detail {

// A model of NeighbourSearch that refers to another one, which must live as long.
template <class S, int D>
class AnySearch {
 public:
  using Scalar = S;
  static constexpr int dimension = D;
  using Point = std::array<S, D>;
  using Found = std::vector<Neighbour<S>>;

  template <NeighbourSearch Search>
  explicit AnySearch(const Search& search)
      : search_(&search),
        size_(search.size()),
        within_([](const void* own, const Point& x, S radius, Found& found) {
          static_cast<const Search*>(own)->within(x, radius, found);
        }),
        nearest_([](const void* own, const Point& x, std::size_t k, Found& found) {
          static_cast<const Search*>(own)->nearest(x, k, found);
        }),
        nearest_within_([](const void* own, const Point& x, std::size_t k, S radius, Found& found) {
          static_cast<const Search*>(own)->nearest_within(x, k, radius, found);
        }),
        in_box_([](const void* own, const Point& lower, const Point& upper, Found& found) {
          static_cast<const Search*>(own)->in_box(lower, upper, found);
        }) {}

  std::size_t size() const { return size_; }
  void within(const Point& x, S radius, Found& found) const { within_(search_, x, radius, found); }
  void nearest(const Point& x, std::size_t k, Found& found) const {
    nearest_(search_, x, k, found);
  }
  void nearest_within(const Point& x, std::size_t k, S radius, Found& found) const {
    nearest_within_(search_, x, k, radius, found);
  }
  void in_box(const Point& lower, const Point& upper, Found& found) const {
    in_box_(search_, lower, upper, found);
  }

 private:
  const void* search_;
  std::size_t size_;
  void (*within_)(const void*, const Point&, S, Found&);
  void (*nearest_)(const void*, const Point&, std::size_t, Found&);
  void (*nearest_within_)(const void*, const Point&, std::size_t, S, Found&);
  void (*in_box_)(const void*, const Point&, const Point&, Found&);
};

// find_neighbours_with() of any search.
template <int D, class Scalar>
void find_one_by_one(const AnySearch<Scalar, D>& search, const PointCloud<Scalar>& particles,
                     const PointCloud<Scalar>& targets, const NeighbourRule& rule,
                     const PeriodicDomain<Scalar>& domain, const NeighbourOptions& options,
                     NeighbourList<Scalar>& list);

template <NeighbourSearch S>
class TargetNeighbours;

// Finds single targets among others that are found in another way. Refers to all that it is given.
template <class S, int D>
class SingleTargets {
 public:
  SingleTargets(const AnySearch<S, D>& search, const PointCloud<S>& particles,
                const PointCloud<S>& targets, const PeriodicDomain<S>& domain,
                const NeighbourOptions& options, S spacing);
  ~SingleTargets();

  struct Found {
    ParticleIndex index;
    ImageShift shift;
  };
  // The neighbours of a target, valid until the next call, and its support radius.
  S find(std::size_t target, const NeighbourRule& rule);
  const std::vector<Found>& found() const { return found_; }

 private:
  AnySearch<S, D> search_;
  std::unique_ptr<TargetNeighbours<AnySearch<S, D>>> neighbours_;
  std::vector<Found> found_;
};

}  // namespace recon::detail
