// Neighbours found by the threads of a GPU are those of find_neighbours(), in its numbers and with
// its supports; here the threads are a loop on the processor.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "cuda/neighbours.hpp"
#include "cuda/on_host.hpp"
#include "recon/neighbourhood/search.hpp"
#include "support/clouds.hpp"

namespace recon::testing {
namespace {

using cuda::Host;

template <class T>
struct FoundRow {
  std::vector<std::pair<ParticleIndex, ImageShift>> entries;
  T support = 0;
};

// The row of one target, by the places of the sources; in the caller's numbers, sorted.
template <bool periodic, int D, class T>
std::vector<FoundRow<T>> rows_of(const HostSources<D, T>& sources,
                                 const std::vector<std::array<T, static_cast<std::size_t>(D)>>& at,
                                 const NeighbourRule& rule) {
  const cuda::CloudView<D, T> cloud = sources.view();
  std::vector<T> x;
  for (const auto& point : at)
    for (int d = 0; d < D; ++d)
      x.push_back(sources.frame().take(point[static_cast<std::size_t>(d)], d));
  std::vector<std::int64_t> offsets(at.size() + 1);
  std::vector<T> support(at.size());
  std::vector<std::uint32_t> places, shifts;
  cuda::Trouble trouble;
  const auto rows = [&] {
    return cuda::Rows<T>{offsets.data(), places.data(), shifts.data(), support.data()};
  };
  if (const auto* nearest = std::get_if<Nearest>(&rule)) {
    const std::size_t k =
        periodic && sources.size() > 0 ? nearest->k : std::min(nearest->k, sources.size());
    for (std::size_t t = 0; t <= at.size(); ++t) offsets[t] = static_cast<std::int64_t>(t * k);
    places.resize(k * at.size());
    shifts.resize(k * at.size());
    std::vector<T> far(k * at.size());
    std::vector<cuda::KeyOf<periodic>> keys(k * at.size());
    for (std::size_t t = 0; t < at.size(); ++t) {
      const cuda::FindNearest<D, T, periodic, 24> few{
          cloud, x.data(), static_cast<int>(k), 1, nearest->factor, rows(), &trouble};
      const cuda::FindNearest<D, T, periodic, 0> many{
          cloud,  x.data(), static_cast<int>(k), 2,          nearest->factor,
          rows(), &trouble, far.data(),          keys.data()};
      if (k <= 24 && t % 2 == 0)
        few(t);
      else
        many(t);
    }
  } else {
    const T rho = static_cast<T>(std::get<Radius>(rule).radius), far = reach(rho);
    for (std::size_t t = 0; t < at.size(); ++t)
      cuda::CountWithin<D, T, periodic>{cloud, x.data(), rho, far, rows(), &trouble}(t);
    std::int64_t total = 0;
    for (std::int64_t& offset : offsets) total += std::exchange(offset, total);
    places.resize(static_cast<std::size_t>(total));
    shifts.resize(static_cast<std::size_t>(total));
    for (std::size_t t = 0; t < at.size(); ++t)
      cuda::FindWithin<D, T, periodic>{cloud, x.data(), rho, far, rows()}(t);
  }
  EXPECT_EQ(trouble.shift, cuda::none);
  std::vector<FoundRow<T>> found(at.size());
  for (std::size_t t = 0; t < at.size(); ++t) {
    found[t].support = support[t];
    std::uint64_t before = 0;
    for (std::int64_t e = offsets[t]; e < offsets[t + 1]; ++e) {
      const auto i = static_cast<std::size_t>(e);
      const std::uint64_t key = std::uint64_t{places[i]} << 24 | (periodic ? shifts[i] : 0);
      if (e > offsets[t]) {
        EXPECT_LT(before, key) << "rows are in the order of places and shifts";
      }
      before = key;
      found[t].entries.push_back(
          {sources.order()[places[i]],
           periodic ? detail::NeighbourKey<true>::shift(shifts[i]) : ImageShift{}});
    }
    std::sort(found[t].entries.begin(), found[t].entries.end());
  }
  return found;
}

template <int D, class T, bool periodic>
void expect_the_neighbours_of_the_library(
    const std::vector<std::array<T, static_cast<std::size_t>(D)>>& points,
    const std::vector<std::array<T, static_cast<std::size_t>(D)>>& targets,
    const NeighbourRule& rule, const SourcesOptions& options, const std::string& what) {
  const auto sources = host_sources(points, options);
  const auto found = rows_of<periodic, D, T>(*sources, targets, rule);
  const auto view = [](const auto& list) {
    PointsView<T> all = points_of(list);
    return all;
  };
  if (points.empty()) {
    for (const auto& row : found) EXPECT_TRUE(row.entries.empty()) << what;
    return;
  }
  const BasicSources<T> library(view(points), options);
  const NeighbourList<T> list = find_neighbours(library, view(targets), rule, {});
  // The same order of particles, so that ties are told apart in the same way.
  EXPECT_TRUE(std::equal(library.order().begin(), library.order().end(), sources->order())) << what;
  for (std::size_t t = 0; t < targets.size(); ++t) {
    std::vector<std::pair<ParticleIndex, ImageShift>> expected;
    for (std::int64_t e = list.offsets[t]; e < list.offsets[t + 1]; ++e) {
      const auto i = static_cast<std::size_t>(e);
      expected.push_back({list.indices[i], periodic ? list.shifts[i] : ImageShift{}});
    }
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(found[t].entries, expected) << what << ", target " << t;
    EXPECT_EQ(found[t].support, list.support[t]) << what << ", target " << t;
  }
}

template <int D, class T>
std::vector<std::array<T, static_cast<std::size_t>(D)>> targets_for(
    const std::vector<std::array<T, static_cast<std::size_t>(D)>>& points) {
  auto targets = random_points<T, D>(40, 77);
  for (auto& x : targets)
    for (T& c : x) c = c * T(1.4) - T(0.2);  // some outside
  for (std::size_t i = 0; i < points.size(); i += 7) targets.push_back(points[i]);
  std::array<T, static_cast<std::size_t>(D)> far;
  far.fill(T(30));
  targets.push_back(far);
  return targets;
}

template <int D, class T>
void expect_all_clouds() {
  for (const auto& [name, points] : hostile_clouds<T, D>()) {
    const auto targets = targets_for<D, T>(points);
    for (const NeighbourRule& rule :
         {NeighbourRule(Nearest{1}), NeighbourRule(Nearest{9}), NeighbourRule(Nearest{70, 1.25}),
          NeighbourRule(Radius{0.05}), NeighbourRule(Radius{0.3}), NeighbourRule(Radius{40})})
      expect_the_neighbours_of_the_library<D, T, false>(points, targets, rule, {}, name);
  }
}

TEST(CudaSearch, FindsWhatTheLibraryFindsIn1d) {
  expect_all_clouds<1, double>();
}
TEST(CudaSearch, FindsWhatTheLibraryFindsIn2d) {
  expect_all_clouds<2, double>();
}
TEST(CudaSearch, FindsWhatTheLibraryFindsIn3d) {
  expect_all_clouds<3, double>();
}
TEST(CudaSearch, FindsWhatTheLibraryFindsInFloat) {
  expect_all_clouds<3, float>();
}

TEST(CudaSearch, FindsPeriodicImages) {
  SourcesOptions options;
  options.domain.periodic = {true, false, true};
  options.domain.lower = {0, 0, 0};
  options.domain.upper = {1, 1, 1.25};
  const auto inside = [](auto points) {
    for (auto& x : points)
      for (std::size_t d = 0; d < 3; ++d) x[d] = x[d] * 1.5 - 0.25;  // wrapped
    return points;
  };
  const auto targets = inside(random_points<double, 3>(25, 78));
  for (const std::size_t count : {std::size_t{1}, std::size_t{5}, std::size_t{300}})
    for (const NeighbourRule& rule : {NeighbourRule(Nearest{12}), NeighbourRule(Nearest{60}),
                                      NeighbourRule(Radius{0.2}), NeighbourRule(Radius{1.6})})
      expect_the_neighbours_of_the_library<3, double, true>(
          inside(random_points<double, 3>(count, 79)), targets, rule, options,
          std::to_string(count) + " particles");
}

TEST(CudaSearch, FollowsStretchAndManyCells) {
  SourcesOptions options;
  options.stretch = {1, 0.25, 3};
  const auto points = random_points<double, 3>(4000, 80);
  for (const NeighbourRule& rule : {NeighbourRule(Nearest{21}), NeighbourRule(Radius{0.15})})
    expect_the_neighbours_of_the_library<3, double, false>(points, targets_for<3, double>(points),
                                                           rule, options, "stretched");
}

TEST(CudaSearch, TiesAreThoseOfTheLibrary) {
  // On a lattice the k-th and the next are equally far, and targets lie on faces of cells.
  const auto lattice = regular_points<double, 3>(12);
  for (const NeighbourRule& rule :
       {NeighbourRule(Nearest{5}), NeighbourRule(Nearest{20}), NeighbourRule(Radius{1.0 / 6})})
    expect_the_neighbours_of_the_library<3, double, false>(lattice, lattice, rule, {}, "lattice");
}

TEST(CudaSearch, BadCoordinatesAreNamed) {
  auto points = random_points<double, 2>(50, 81);
  const auto sources = host_sources(points);
  EXPECT_NO_THROW(sources->check());
  points[31][1] = std::numeric_limits<double>::quiet_NaN();
  points[40][0] = std::numeric_limits<double>::infinity();
  sources->update(view_of(points));
  try {
    sources->check();
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_EQ(error.argument(), "coordinate y of point 31 of the points");
    EXPECT_EQ(error.rule(), "must be finite");
  }
  points = random_points<double, 2>(50, 81);
  points[3][0] = 1e200;
  sources->update(view_of(points));
  EXPECT_THROW(sources->check(), InvalidArgument);
  EXPECT_THROW(host_sources(points, {.stretch = {0, 1, 1}}), InvalidArgument);
  const std::vector<double> weights(50, 1.0);
  EXPECT_THROW(host_sources(points, {.particle_weights = weights}), InvalidArgument);
}

TEST(CudaSearch, WrapsAsTheLibraryDoes) {
  PeriodicDomain<double> domain{{0.1, 0, 0}, {0.8, 0, 0}, {true, false, false}};
  cuda::Frame<1, double> frame;
  frame.periodic[0] = true;
  frame.lower[0] = 0.1;
  frame.upper[0] = 0.8;
  frame.period[0] = domain.period(0);
  frame.stretch[0] = 1;
  for (int i = -300; i < 300; ++i)
    for (const double off : {0.0, 1e-17, 1e-9, 0.013}) {
      const double x = 0.1 * i + off;
      EXPECT_EQ(frame.wrap(x, 0), domain.wrap(x, 0)) << x;
    }
}

TEST(CudaSearch, AnUpdateAllocatesNothing) {
  auto points = random_points<double, 3>(500, 82);
  const auto sources = host_sources(points);
  const int before = sources->executor()->allocations();
  for (auto& x : points) x[0] += 1;
  sources->update(view_of(points));
  points.resize(300);
  sources->update(view_of(points));
  EXPECT_EQ(sources->executor()->allocations(), before);
}

}  // namespace
}  // namespace recon::testing
