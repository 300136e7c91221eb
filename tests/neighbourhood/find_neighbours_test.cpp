// Neighbours of all targets: equal to a list made by hand over explicitly replicated particles.
#include "recon/neighbourhood/find_neighbours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "neighbourhood/neighbourhood_support.hpp"
#include "recon/neighbourhood/brute_force.hpp"
#include "recon/neighbourhood/find_neighbours_with.hpp"

namespace recon::testing {
namespace {

constexpr SearchMethod all_methods[] = {SearchMethod::automatic, SearchMethod::kd_tree,
                                        SearchMethod::r_tree, SearchMethod::cell_grid,
                                        SearchMethod::brute_force};

// Whole multiples of 1/64: sums with periods are exact in float too, and ties are everywhere.
template <class Scalar, int D>
PointList<Scalar, D> on_fine_lattice(PointList<Scalar, D> points) {
  for (auto& x : points)
    for (auto& c : x) c = std::round(c * 64) / 64;
  return points;
}

template <class Scalar, int D>
struct Image {
  ParticleIndex index;
  ImageShift shift;
  std::array<Scalar, D> x;
};

// Every particle at x + shift * period for all |shift| <= most along the periodic axes.
template <int D, class Scalar>
std::vector<Image<Scalar, D>> replicas(const PointCloud<Scalar>& particles,
                                       const PeriodicDomain<Scalar>& domain, int most) {
  std::vector<Image<Scalar, D>> images;
  std::array<int, 3> m{};
  for (int d = 0; d < 3; ++d) m[d] = domain.periodic[d] ? most : 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    for (int i = -m[0]; i <= m[0]; ++i)
      for (int j = -m[1]; j <= m[1]; ++j)
        for (int k = -m[2]; k <= m[2]; ++k) {
          const std::array<int, 3> s{i, j, k};
          Image<Scalar, D> image{static_cast<ParticleIndex>(p), {}, particles.template point<D>(p)};
          for (int d = 0; d < D; ++d) {
            image.shift[d] = static_cast<std::int8_t>(s[d]);
            image.x[d] += static_cast<Scalar>(s[d]) * domain.period(d);
          }
          images.push_back(image);
        }
  return images;
}

template <class Scalar>
struct Wanted {  // the rule of one target, spelled out
  std::size_t k = SIZE_MAX;
  Scalar radius = std::numeric_limits<Scalar>::infinity();
  bool by_distance = false;
};

template <int D, class Scalar>
std::vector<Image<Scalar, D>> reference(const std::vector<Image<Scalar, D>>& images,
                                        const std::array<Scalar, D>& x,
                                        const Wanted<Scalar>& wanted, bool cube,
                                        const std::function<bool(std::size_t)>& visible) {
  std::vector<Image<Scalar, D>> found;
  for (const auto& image : images) {
    Scalar largest = 0;
    for (int d = 0; d < D; ++d) largest = std::max(largest, std::abs(x[d] - image.x[d]));
    const bool near = cube ? largest <= wanted.radius
                           : squared_distance(x, image.x) <= wanted.radius * wanted.radius;
    if (near && visible(image.index)) found.push_back(image);
  }
  std::sort(found.begin(), found.end(), [&](const auto& a, const auto& b) {
    const Scalar da = wanted.by_distance ? squared_distance(x, a.x) : 0;
    const Scalar db = wanted.by_distance ? squared_distance(x, b.x) : 0;
    return std::tie(da, a.index, a.shift) < std::tie(db, b.index, b.shift);
  });
  if (found.size() > wanted.k) found.resize(wanted.k);
  return found;
}

template <class Scalar>
Wanted<Scalar> spelled_out(const NeighbourRule& rule, std::size_t target) {
  if (const auto* r = std::get_if<Radius>(&rule)) return {SIZE_MAX, Scalar(r->radius), false};
  if (const auto* r = std::get_if<Radii>(&rule)) return {SIZE_MAX, Scalar(r->radii[target]), false};
  if (const auto* r = std::get_if<Nearest>(&rule))
    return {r->k, std::numeric_limits<Scalar>::infinity(), true};
  const auto& r = std::get<NearestWithin>(rule);
  return {r.k, Scalar(r.radius), true};
}

// `most`: shifts that the reference looks at; must be more than enough for the rule.
template <int D, class Scalar>
void expect_reference(const PointCloud<Scalar>& particles, const PointCloud<Scalar>& targets,
                      const NeighbourRule& rule, const PeriodicDomain<Scalar>& domain, int most,
                      const NeighbourOptions& options) {
  const bool cube = options.shape == SupportShape::cube;
  const auto images = replicas<D>(particles, domain, most);
  const auto list = find_neighbours(particles, targets, rule, domain, options);
  list.validate(targets.size(), particles.size());
  ASSERT_EQ(list.shifts.size(), domain.any() ? list.indices.size() : 0u);
  for (std::size_t t = 0; t < targets.size(); ++t) {
    const auto wanted = spelled_out<Scalar>(rule, t);
    const auto x = targets.template point<D>(t);
    const auto expected = reference<D, Scalar>(images, x, wanted, cube, [&](std::size_t p) {
      return !options.visible || options.visible(t, p);
    });
    ASSERT_EQ(list.count(t), static_cast<std::int64_t>(expected.size())) << "target " << t;
    Scalar farthest = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(list.of(t)[i], expected[i].index) << "target " << t << ", neighbour " << i;
      const std::size_t at = static_cast<std::size_t>(list.offsets[t]) + i;
      if (domain.any()) {
        ASSERT_EQ(list.shifts[at], expected[i].shift) << "target " << t;
      }
      if (!cube) farthest = std::max(farthest, std::sqrt(squared_distance(x, expected[i].x)));
      for (int d = 0; d < D && cube; ++d)
        farthest = std::max(farthest, std::abs(x[d] - expected[i].x[d]));
    }
    const auto* nearest = std::get_if<Nearest>(&rule);
    if (nearest == nullptr) {
      EXPECT_EQ(list.support[t], wanted.radius);
    } else if (farthest > 0) {
      EXPECT_EQ(list.support[t], Scalar(nearest->factor * double(farthest))) << "target " << t;
    }
  }
}

template <class Scalar, int D>
PointCloud<Scalar> some_targets(const PointList<Scalar, D>& points,
                                const PeriodicDomain<Scalar>& domain) {
  auto targets = random_points<Scalar, D>(6, 77);
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / 5)
    targets.push_back(points[i]);
  return cloud_of(on_fine_lattice<Scalar, D>(targets), domain);
}

template <class Space>
class FindNeighbours : public ::testing::Test {};
TYPED_TEST_SUITE(FindNeighbours, Spaces);

TYPED_TEST(FindNeighbours, EqualsTheReferenceForEverySearchRuleAndShape) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  for (const auto& [name, points] : hostile_clouds<Scalar, D>()) {
    SCOPED_TRACE(name);
    const auto particles = cloud_of(points);
    const auto targets = some_targets<Scalar, D>(points, {});
    std::vector<double> radii;
    for (std::size_t t = 0; t < targets.size(); ++t) radii.push_back(0.01 + 0.1 * double(t % 7));
    for (const SearchMethod search : all_methods)
      for (const SupportShape shape : {SupportShape::ball, SupportShape::cube})
        for (const NeighbourRule& rule :
             {NeighbourRule(Radius{0.3}), NeighbourRule(Radius{1e-9}), NeighbourRule(Radius{1e30}),
              NeighbourRule(Radii{radii}), NeighbourRule(Nearest{6}),
              NeighbourRule(Nearest{1000, 1.01}), NeighbourRule(NearestWithin{4, 0.2}),
              NeighbourRule(NearestWithin{1000, 0.3})}) {
          SCOPED_TRACE(rule.index());
          expect_reference<D>(particles, targets, rule, {}, 0, {.shape = shape, .search = search});
          if (this->HasFatalFailure()) return;
        }
  }
}

// Periods 1 and 1.5, the third axis open; supports of up to 2.3 periods, more neighbours
// than particles.
template <class Scalar>
PeriodicDomain<Scalar> box_domain(int dimension) {
  PeriodicDomain<Scalar> domain;
  domain.lower = {0, Scalar(-0.25), 0};
  domain.upper = {1, Scalar(1.25), 0};
  domain.periodic = {true, dimension > 1, false};
  return domain;
}

TYPED_TEST(FindNeighbours, EqualsTheReferenceInPeriodicDomains) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto domain = box_domain<Scalar>(D);
  for (const auto& [name, rough] : hostile_clouds<Scalar, D>()) {
    SCOPED_TRACE(name);
    const auto points = on_fine_lattice<Scalar, D>(rough);
    const auto particles = cloud_of(points, domain);
    const auto targets = some_targets<Scalar, D>(points, domain);
    const std::vector<double> radii(targets.size(), 0.75);
    for (const SupportShape shape : {SupportShape::ball, SupportShape::cube})
      for (const NeighbourRule& rule :
           {NeighbourRule(Radius{0.125}), NeighbourRule(Radius{0.5}), NeighbourRule(Radius{2.3}),
            NeighbourRule(Radii{radii}), NeighbourRule(Nearest{9}), NeighbourRule(Nearest{250}),
            NeighbourRule(NearestWithin{5, 0.25}), NeighbourRule(NearestWithin{300, 1})}) {
        if (rule.index() == 2 && std::get<Nearest>(rule).k > 8 * points.size()) continue;
        SCOPED_TRACE(rule.index());
        const auto search = rule.index() == 2 ? SearchMethod::automatic : SearchMethod::cell_grid;
        expect_reference<D>(particles, targets, rule, domain, 7,
                            {.shape = shape, .search = search});
        if (this->HasFatalFailure()) return;
      }
  }
}

TYPED_TEST(FindNeighbours, HiddenParticlesTakeNoPlace) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const Visibility visible = [](std::size_t t, std::size_t p) { return (t + p) % 5 == 0; };
  for (const auto& domain : {PeriodicDomain<Scalar>{}, box_domain<Scalar>(D)})
    for (const auto& [name, rough] : hostile_clouds<Scalar, D>()) {
      SCOPED_TRACE(name);
      if (rough.size() < 10) continue;
      const auto points = on_fine_lattice<Scalar, D>(rough);
      const auto particles = cloud_of(points, domain);
      const auto targets = some_targets<Scalar, D>(points, domain);
      for (const SupportShape shape : {SupportShape::ball, SupportShape::cube})
        for (const NeighbourRule& rule :
             {NeighbourRule(Radius{0.5}), NeighbourRule(Nearest{4}), NeighbourRule(Nearest{30}),
              NeighbourRule(NearestWithin{3, 0.25})}) {
          SCOPED_TRACE(rule.index());
          expect_reference<D>(particles, targets, rule, domain, 12,
                              {.shape = shape, .visible = visible});
          if (this->HasFatalFailure()) return;
        }
    }
}

TYPED_TEST(FindNeighbours, NothingVisibleIsNoNeighbourButASupport) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const Visibility none = [](std::size_t, std::size_t) { return false; };
  for (const auto& domain : {PeriodicDomain<Scalar>{}, box_domain<Scalar>(D)})
    for (const NeighbourRule& rule : {NeighbourRule(Radius{0.5}), NeighbourRule(Nearest{4}),
                                      NeighbourRule(NearestWithin{3, 0.25})}) {
      const auto cloud = cloud_of(random_points<Scalar, D>(40, 3), domain);
      const auto list = find_neighbours(cloud, cloud, rule, domain, {.visible = none});
      list.validate(40, 40);
      EXPECT_TRUE(list.indices.empty());
      const auto empty = find_neighbours(cloud_of(PointList<Scalar, D>{}), cloud, rule, domain);
      empty.validate(40, 0);
      EXPECT_TRUE(empty.indices.empty());
    }
}

TYPED_TEST(FindNeighbours, SameBitsForAnyNumberOfThreads) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  const auto domain = box_domain<Scalar>(D);
  const auto particles = cloud_of(random_points<Scalar, D>(700, 3), domain);
  const auto targets = cloud_of(random_points<Scalar, D>(900, 4), domain);  // several blocks
  for (const NeighbourRule& rule : {NeighbourRule(Radius{0.1}), NeighbourRule(Nearest{7})})
    for (const auto& where : {PeriodicDomain<Scalar>{}, domain}) {
      const auto one = find_neighbours(particles, targets, rule, where, {.threads = 1});
      EXPECT_GT(one.indices.size(), 900u);
      for (const int threads : {2, 3}) {
        const auto many = find_neighbours(particles, targets, rule, where, {.threads = threads});
        EXPECT_EQ(one.offsets, many.offsets);
        EXPECT_EQ(one.indices, many.indices);
        EXPECT_EQ(one.shifts, many.shifts);
        EXPECT_EQ(one.support, many.support);
      }
    }
}

// Coordinates that are not exact: all searches agree on every image and every tie.
TYPED_TEST(FindNeighbours, SearchesAgreeInPeriodicDomainsFarFromTheOrigin) {
  using Scalar = typename TypeParam::Scalar;
  constexpr int D = TypeParam::D;
  auto domain = box_domain<Scalar>(D);
  for (int d = 0; d < D; ++d) {
    domain.lower[d] += Scalar(1e6);
    domain.upper[d] += Scalar(1e6);
  }
  auto points = random_points<Scalar, D>(150, 5);
  for (auto& x : points)
    for (auto& c : x) c += Scalar(1e6);
  const auto cloud = cloud_of(points, domain);
  for (const NeighbourRule& rule : {NeighbourRule(Radius{0.7}), NeighbourRule(Nearest{200}),
                                    NeighbourRule(NearestWithin{30, 0.6})}) {
    const auto expected =
        find_neighbours(cloud, cloud, rule, domain, {.search = SearchMethod::brute_force});
    for (const SearchMethod search : all_methods) {
      const auto list = find_neighbours(cloud, cloud, rule, domain, {.search = search});
      EXPECT_EQ(list.indices, expected.indices);
      EXPECT_EQ(list.shifts, expected.shifts);
      EXPECT_EQ(list.support, expected.support);
    }
  }
}

TEST(NearestSupport, StaysPositiveWhereAllNeighboursCoincideWithTheTarget) {
  const PointList<double, 2> points{{0.5, 0.5}, {0.5, 0.5}, {0.5, 0.5}, {0.5, 0.75}};
  const auto target = cloud_of(PointList<double, 2>{{0.5, 0.5}});
  for (const SupportShape shape : {SupportShape::ball, SupportShape::cube}) {
    auto list = find_neighbours(cloud_of(points), target, Nearest{3}, {}, {.shape = shape});
    EXPECT_EQ(list.count(0), 3);
    EXPECT_EQ(list.support[0], 0.25);  // the next particle
    list = find_neighbours(target, target, Nearest{3}, {}, {.shape = shape});
    EXPECT_EQ(list.count(0), 1);
    EXPECT_EQ(list.support[0], 1);  // nothing else to go by
  }
  PeriodicDomain<double> domain;
  domain.upper = {4, 4, 0};
  domain.periodic = {true, true, false};
  const auto list = find_neighbours(target, target, Nearest{1}, domain);
  EXPECT_NEAR(list.support[0], 4, 1e-12);  // mean spacing of one particle in the periodic box
}

// One particle at the target in a box of period 1: its images are the neighbours.
TEST(PeriodicImages, OneParticleIsItsOwnNeighbour) {
  PeriodicDomain<double> domain;
  domain.upper = {1, 0, 0};
  domain.periodic = {true, false, false};
  const auto cloud = cloud_of(PointList<double, 1>{{0.25}});
  auto list = find_neighbours(cloud, cloud, Radius{2.5}, domain);
  EXPECT_EQ(list.shifts,
            (Array<ImageShift>{{-2, 0, 0}, {-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {2, 0, 0}}));
  list = find_neighbours(cloud, cloud, Nearest{4}, domain);
  EXPECT_EQ(list.shifts, (Array<ImageShift>{{0, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {-2, 0, 0}}));
  EXPECT_EQ(list.support[0], 3);
  EXPECT_EQ(find_neighbours(cloud, cloud, Radius{127.5}, domain).count(0), 255);
  EXPECT_EQ(find_neighbours(cloud, cloud, Nearest{255}, domain).count(0), 255);
  EXPECT_EQ(blamed([&] { find_neighbours(cloud, cloud, Radius{128}, domain); }),
            "shift of a periodic image");
  EXPECT_EQ(blamed([&] { find_neighbours(cloud, cloud, Nearest{256}, domain); }),
            "shift of a periodic image");
}

TEST(NeighbourRules, WrongValuesAreNamed) {
  const auto cloud = cloud_of(random_points<float, 2>(5, 1));
  const auto blame = [&](const NeighbourRule& rule) {
    return blamed([&] { find_neighbours(cloud, cloud, rule); });
  };
  for (const double radius :
       {0.0, -1.0, double(NAN), double(INFINITY), 1e-60, 1e60}) {  // the last two: in float
    EXPECT_EQ(blame(Radius{radius}), "radius") << radius;
    EXPECT_EQ(blame(NearestWithin{3, radius}), "radius") << radius;
    const std::vector<double> radii{1, 1, 1, radius, 1};
    EXPECT_EQ(blame(Radii{radii}), "radius of target 3") << radius;
  }
  const std::vector<double> radii(4, 1.0);
  EXPECT_EQ(blame(Radii{radii}), "number of radii");
  EXPECT_EQ(blame(Nearest{0}), "k");
  EXPECT_EQ(blame(NearestWithin{0, 1}), "k");
  for (const double factor : {1.0, 0.0, double(NAN), double(INFINITY)})
    EXPECT_EQ(blame(Nearest{3, factor}), "factor") << factor;
  EXPECT_EQ(blame(Nearest{3, 1e60}), "factor");
  const auto spatial = cloud_of(random_points<float, 3>(5, 1));
  EXPECT_EQ(blamed([&] { find_neighbours(cloud, spatial, Radius{1}); }),
            "dimension of the targets");
  PeriodicDomain<float> domain;
  domain.upper = {0.001f, 0, 0};
  domain.periodic = {true, false, false};
  EXPECT_EQ(blamed([&] { find_neighbours(cloud, cloud, Radius{1}, domain); }),
            "particle coordinate");
  try {
    find_neighbours(cloud, cloud, Radii{radii});
    FAIL() << "four radii for five targets were accepted";
  } catch (const InvalidArgument& error) {
    EXPECT_STREQ(error.what(), "number of radii = 4: must be the number of targets");
  }
}

// The least that a search of your own must have.
struct OwnSearch {
  using Scalar = double;
  static constexpr int dimension = 2;
  using Point = std::array<double, 2>;
  using Found = std::vector<Neighbour<double>>;

  PointList<double, 2> points;

  std::size_t size() const { return points.size(); }
  void within(const Point& x, double radius, Found& found) const {
    nearest_within(x, size(), radius, found, 0);
  }
  void nearest(const Point& x, std::size_t k, Found& found) const {
    nearest_within(x, k, 1e100, found);
  }
  void nearest_within(const Point& x, std::size_t k, double radius, Found& found,
                      bool sort = true) const {
    found.clear();
    for (ParticleIndex i = 0; i < points.size(); ++i)
      if (squared_distance(x, points[i]) <= radius * radius)
        found.push_back({i, squared_distance(x, points[i])});
    if (sort)
      std::stable_sort(found.begin(), found.end(),
                       [](const auto& a, const auto& b) { return a.distance2 < b.distance2; });
    if (found.size() > k) found.resize(k);
  }
  void in_box(const Point& lower, const Point& upper, Found& found) const {
    found.clear();
    for (ParticleIndex i = 0; i < points.size(); ++i) {
      const auto& x = points[i];
      if (lower[0] <= x[0] && x[0] <= upper[0] && lower[1] <= x[1] && x[1] <= upper[1])
        found.push_back({i, 0});
    }
  }
};
static_assert(NeighbourSearch<OwnSearch>);

TEST(OwnNeighbourSearch, GivesTheSameList) {
  const auto domain = box_domain<double>(2);
  const OwnSearch search{regular_points<double, 2>(9)};
  const auto particles = cloud_of(search.points),
             targets = cloud_of(random_points<double, 2>(300, 2));
  for (const SupportShape shape : {SupportShape::ball, SupportShape::cube})
    for (const NeighbourRule& rule : {NeighbourRule(Radius{0.3}), NeighbourRule(Nearest{12})}) {
      const auto own =
          find_neighbours_with(search, particles, targets, rule, domain, {.shape = shape});
      const auto list = find_neighbours(particles, targets, rule, domain, {.shape = shape});
      EXPECT_EQ(own.offsets, list.offsets);
      EXPECT_EQ(own.indices, list.indices);
      EXPECT_EQ(own.shifts, list.shifts);
      EXPECT_EQ(own.support, list.support);
    }
  EXPECT_EQ(blamed([&] { find_neighbours_with(search, targets, targets, Radius{1}); }),
            "particles in the search");
}

}  // namespace
}  // namespace recon::testing
