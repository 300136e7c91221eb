// Particles change their ranks, and none is lost or there twice.
#include <numbers>
#include <numeric>

#include "petsc/petsc_support.hpp"
#include "recon/petsc/particles.hpp"

namespace recon::testing {
namespace {

using petsc::DistributedGrid;
using petsc::Particles;
using ::testing::HasSubstr;

// Each particle is told by what it carries: three numbers that are functions of its id.
double carried(std::int64_t id, int c) {
  return std::sin(static_cast<double>(id) + 0.25 * c);
}

// Every id is there once, on the rank of its position, with its own numbers.
void expect_all_there(Particles& particles, std::int64_t total) {
  const DistributedGrid& grid = particles.grid();
  const int D = grid.all().dimension;
  EXPECT_EQ(particles.total(), total);
  std::vector<int> seen(static_cast<std::size_t>(total), 0);
  const auto ids = particles.ids();
  const auto tag = particles.array("tag");
  ASSERT_EQ(tag.size(), 3 * ids.size());
  for (std::size_t p = 0; p < ids.size(); ++p) {
    ASSERT_GE(ids[p], 0);
    ASSERT_LT(ids[p], total);
    ++seen[static_cast<std::size_t>(ids[p])];
    std::array<double, 3> x{};
    for (int d = 0; d < D; ++d) x[d] = particles.points()(p, d);
    ASSERT_EQ(grid.rank_of(x), world().rank()) << "id " << ids[p];
    for (int c = 0; c < 3; ++c) ASSERT_EQ(tag[3 * p + c], carried(ids[p], c)) << "id " << ids[p];
  }
  MPI_Allreduce(MPI_IN_PLACE, seen.data(), static_cast<int>(total), MPI_INT, MPI_SUM,
                PETSC_COMM_WORLD);
  EXPECT_EQ(seen, std::vector<int>(seen.size(), 1));
}

// The first rank adds them all, as ids 0, 1, 2, ...
template <int D>
Particles made(const DistributedGrid& grid, const Points<D>& points,
               petsc::Outside outside = petsc::Outside::stop) {
  Particles particles(grid, {{"tag", 3}, {"other", 1}}, outside);
  const Points<D> own = world().rank() == 0 ? points : Points<D>();
  Matrix tag(own.size(), 3);
  for (std::size_t p = 0; p < own.size(); ++p)
    for (int c = 0; c < 3; ++c)
      tag(static_cast<Eigen::Index>(p), c) = carried(static_cast<std::int64_t>(p), c);
  const Matrix other = Matrix::Zero(static_cast<Eigen::Index>(own.size()), 1);
  particles.add(view_of<D>(own), {field_view(tag), field_view(other)});
  return particles;
}

// Nodes, and with them all planes, edges and corners between ranks; and the next numbers on both
// sides of each coordinate.
template <int D>
Points<D> nodes_and_their_neighbours(const StructuredGrid<double>& grid) {
  Points<D> points;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    std::array<double, D> x;
    for (int d = 0; d < D; ++d) x[d] = grid.coordinate(grid.index(i)[d], d);
    points.push_back(x);
    for (const double side : {-1.0, 2.0}) {
      for (int d = 0; d < D; ++d)
        x[d] = std::clamp(std::nextafter(x[d], side), grid.origin[d],
                          grid.coordinate(grid.counts[d] - 1, d));
      points.push_back(x);
    }
  }
  return points;
}

template <class Dimension>
class ParticlesOnRanks : public ::testing::Test {};
using Dimensions = ::testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                                    std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(ParticlesOnRanks, Dimensions);

TYPED_TEST(ParticlesOnRanks, PlanesEdgesAndCornersBetweenRanks) {
  constexpr int D = TypeParam::value;
  const auto all = unit_grid<D>({23, 12, 9});
  for (const bool periodic : {false, true}) {
    const DistributedGrid grid(PETSC_COMM_WORLD, all, {.periodic = {periodic, false, false}});
    const auto points = nodes_and_their_neighbours<D>(all);
    Particles particles = made<D>(grid, points);
    expect_all_there(particles, static_cast<std::int64_t>(points.size()));
    // From node to node, so that they stay on planes and corners, past several ranks.
    for (int step = 0; step < 6; ++step) {
      const auto x = particles.x();
      for (std::size_t p = 0; p < particles.size(); ++p)
        for (int d = 0; d < D; ++d) {
          double& at = x[p * D + d];
          const double jump = (step % 3 + 3.0) * all.spacing[d];
          const double last = all.coordinate(all.counts[d] - 1, d);
          if (grid.periodic()[d])
            at += jump;
          else
            at = at + jump <= last ? at + jump : all.origin[d];
        }
      particles.migrate();
      expect_all_there(particles, static_cast<std::int64_t>(points.size()));
    }
  }
}

TYPED_TEST(ParticlesOnRanks, JumpsAnywhere) {
  constexpr int D = TypeParam::value;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>());
  constexpr int count = 500;
  Particles particles = made<D>(grid, points_in<D>(grid.all(), count, 0, 1));
  std::mt19937_64 random(17 + static_cast<unsigned>(world().rank()));
  std::int64_t moved = 0;
  for (int step = 0; step < 30; ++step) {
    for (double& x : particles.x()) x = std::uniform_real_distribution<double>(0, 1)(random);
    const petsc::Migration done = particles.migrate();
    EXPECT_EQ(world().sum(done.sent), done.moved);
    EXPECT_EQ(world().sum(done.received), done.moved);
    EXPECT_EQ(done.outside, 0);
    moved += done.moved;
  }
  expect_all_there(particles, count);
  if (world().size() > 1) {
    EXPECT_GT(moved, count * 5);
  }
  // Nobody has left: nothing is moved.
  EXPECT_EQ(particles.migrate().moved, 0);
}

TYPED_TEST(ParticlesOnRanks, PeriodsWrapHoweverFar) {
  constexpr int D = TypeParam::value;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<D>(), {.periodic = {true, D > 1, D > 2}});
  constexpr int count = 200;
  const auto points = points_in<D>(grid.all(), count, 0, 2);
  Particles particles = made<D>(grid, points);
  const auto domain = grid.domain();
  for (const double periods : {1.0, -1.0, 3.0, -250.0}) {
    for (std::size_t p = 0; p < particles.size(); ++p)
      for (int d = 0; d < D; ++d) particles.x()[p * D + d] += periods * domain.period(d);
    particles.migrate();
    expect_all_there(particles, count);
  }
  const auto ids = particles.ids();
  for (std::size_t p = 0; p < ids.size(); ++p)
    for (int d = 0; d < D; ++d) {
      const double x = particles.points()(p, d);
      EXPECT_GE(x, domain.lower[d]);
      EXPECT_LT(x, domain.upper[d]);
      const double away = std::abs(x - points[static_cast<std::size_t>(ids[p])][d]);
      EXPECT_LT(std::min(away, domain.period(d) - away), 1e-12);
    }
}

TEST(Particles, IdsFollowTheRanksAndCalls) {
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<2>());
  Particles particles(grid, {});
  const std::size_t own = 2 + static_cast<std::size_t>(world().rank());
  std::int64_t total = 0;
  for (int r = 0; r < world().size(); ++r) total += 2 + r;
  const Points<2> points(own, {0.5, 0.5});
  particles.add(view_of<2>(points), {});
  EXPECT_EQ(particles.total(), total);
  particles.add(view_of<2>(points), {});
  EXPECT_EQ(particles.total(), 2 * total);
  EXPECT_EQ(world().sum(static_cast<long long>(particles.size())), 2 * total);
  long long sum = 0;
  for (const std::int64_t id : particles.ids()) sum += id;
  EXPECT_EQ(world().sum(sum), total * (2 * total - 1));
  // All lie in one place, so with one rank.
  EXPECT_EQ(world().largest(static_cast<double>(particles.size())), static_cast<double>(2 * total));
}

TEST(Particles, NoneAtAll) {
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<3>());
  Particles particles = made<3>(grid, {});
  EXPECT_EQ(particles.migrate().moved, 0);
  expect_all_there(particles, 0);
}

TEST(Particles, BeyondTheBoxTheyAreRefusedOrKept) {
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<2>());
  const Points<2> points{{0.2, 0.3}, {1, 1}, {0, 0.4}};
  for (const auto outside : {petsc::Outside::stop, petsc::Outside::keep}) {
    Particles particles = made<2>(grid, points, outside);
    EXPECT_EQ(particles.migrate().outside, 0);
    const auto ids = particles.ids();
    for (std::size_t p = 0; p < ids.size(); ++p)
      if (ids[p] == 1) particles.x()[2 * p + 1] = 1e300;
    if (outside == petsc::Outside::stop) {
      EXPECT_THAT(refusal([&] { particles.migrate(); }),
                  HasSubstr("coordinate y of the particle with the id 1 = "));
      for (std::size_t p = 0; p < ids.size(); ++p)
        if (ids[p] == 1) particles.x()[2 * p + 1] = 1;
      EXPECT_EQ(particles.migrate().outside, 0);
    } else {
      EXPECT_EQ(particles.migrate().outside, 1);
    }
    expect_all_there(particles, 3);
    const Points<2> out{{-1e-9, 0.5}};
    const Matrix zero = Matrix::Zero(1, 3);
    const auto add = [&] {
      particles.add(view_of<2>(out), {field_view(zero), field_view(zero.leftCols(1))});
    };
    if (outside == petsc::Outside::stop) {
      EXPECT_THAT(refusal(add), HasSubstr("rank 0: coordinate x of point 0 of the new particles"));
      EXPECT_EQ(particles.total(), 3);
    } else {
      EXPECT_EQ(refusal(add), "");
      EXPECT_EQ(particles.total(), 3 + world().size());
    }
  }
}

TEST(Particles, CoordinatesThatAreNotFiniteAreNamed) {
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<1>(), {.periodic = {true}});
  Particles particles = made<1>(grid, points_in<1>(grid.all(), 40, 0, 3));
  const auto ids = particles.ids();
  for (std::size_t p = 0; p < ids.size(); ++p)
    if (ids[p] == 17) particles.x()[p] = std::nan("");
  EXPECT_THAT(refusal([&] { particles.migrate(); }),
              HasSubstr("coordinate x of the particle with the id 17 = nan: must be finite"));
}

TEST(Particles, BadArraysAreRefused) {
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<1>());
  const auto make = [&](const std::vector<petsc::ParticleArray>& arrays) {
    return refusal([&] { Particles(grid, arrays); });
  };
  EXPECT_THAT(make({{"", 1}}), HasSubstr("must not be empty"));
  EXPECT_THAT(make({{"x", 1}}), HasSubstr("not be x or id"));
  EXPECT_THAT(make({{"a", 1}, {"a", 2}}), HasSubstr("must not be said twice"));
  EXPECT_THAT(make({{"a", 0}}), HasSubstr("components of an array of the particles = 0"));
  EXPECT_THAT(make({{"DMSwarm_rank", 1}}), HasSubstr("PETSc's own names"));
  if (world().size() > 1) {
    EXPECT_THAT(make({{"a", world().rank() == 0 ? 1 : 2}}),
                HasSubstr("arrays of the particles = different on some ranks"));
    EXPECT_THAT(make({{world().rank() == 0 ? "a" : "b", 1}}),
                HasSubstr("arrays of the particles = different on some ranks"));
  }
  Particles particles = made<1>(grid, {{0.5}});
  EXPECT_THAT(refusal([&] { particles.array("tga"); }),
              HasSubstr("those that they have: tag, other"));
  const Points<1> one{{0.5}};
  const Matrix zero = Matrix::Zero(2, 3);
  EXPECT_THAT(refusal([&] { particles.add(view_of<1>(one), {}); }),
              HasSubstr("must be one for each array"));
  EXPECT_THAT(refusal([&] {
                particles.add(view_of<1>(one), {field_view(zero), field_view(zero)});
              }),
              HasSubstr("values of the array tag = 2"));
  EXPECT_THAT(refusal([&] {
                particles.add(view_of<1>(one), {field_view(zero.topRows(1).leftCols(2)),
                                                field_view(zero.topRows(1))});
              }),
              HasSubstr("components of the array tag = 2"));
  EXPECT_EQ(particles.total(), 1);
}

// A vortex without divergence that turns about the middle of the box, and now and then a jump to
// anywhere. No particle leaves the box: the stream function is constant on its border.
void turn(std::int64_t steps, bool periodic) {
  constexpr double pi = std::numbers::pi;
  const DistributedGrid grid(PETSC_COMM_WORLD, unit_grid<2>(), {.periodic = {periodic, periodic}});
  const std::int64_t count = 600;
  Particles particles = made<2>(grid, points_in<2>(grid.all(), count, 0, 4));
  std::mt19937_64 random(31 + static_cast<unsigned>(world().rank()));
  std::uniform_real_distribution<double> part(0, 1);
  const double dt = 0.02;
  std::int64_t moved = 0;
  for (std::int64_t step = 0; step < steps; ++step) {
    const auto x = particles.x();
    for (std::size_t p = 0; p < particles.size(); ++p) {
      double &a = x[2 * p], &b = x[2 * p + 1];
      if (part(random) < 1e-3) {
        a = part(random) + (periodic ? std::floor(5 * part(random)) : 0);
        b = part(random);
        continue;
      }
      const double u = std::sin(pi * a) * std::cos(pi * b);
      const double v = -std::cos(pi * a) * std::sin(pi * b);
      a += dt * u + (periodic ? 0.01 : 0);
      b += dt * v;
      if (periodic) continue;
      a = std::clamp(a, 0.0, 1.0);
      b = std::clamp(b, 0.0, 1.0);
    }
    moved += particles.migrate().moved;
  }
  expect_all_there(particles, count);
  if (world().size() > 1) {
    EXPECT_GT(moved, steps);
  }
}

TEST(Vortex, NoParticleIsLostIn300Steps) {
  turn(300, false);
  turn(300, true);
}
TEST(VortexSlow, NoParticleIsLostIn10000Steps) {
  turn(10000, false);
  turn(10000, true);
}

}  // namespace
}  // namespace recon::testing
