// Sums into nodes and values of nodes: what is conserved, that each is the transpose of the other,
// that the order of the sums does not depend on threads, and points that are where none should be.
#include "recon/transfer/scatter.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include "recon/points/make_view.hpp"
#include "support/message_of.hpp"
#include "support/nan.hpp"
#include "support/space.hpp"

namespace recon::test {
namespace {

using recon::testing::message_of;

template <class T>
class Transfer : public ::testing::Test {};
#ifdef RECON_SANITIZED  // under sanitizers the compiler takes minutes for each dimension
TYPED_TEST_SUITE(Transfer, ::testing::Types<Dimension<3>>);
#else
TYPED_TEST_SUITE(Transfer, AllDimensions);
#endif

// Particles in the unit box, those of every fifth exactly on faces and edges of cells.
template <int D>
struct Cloud {
  CartesianGrid<D> grid;
  std::vector<SpaceVector<D>> x, v;
  std::vector<SpaceMatrix<D>> H, F;
  std::vector<double> mass;

  Cloud(int cells, std::size_t count, std::uint32_t seed = 1) : grid(unit_grid<D>(cells)) {
    std::mt19937 random(seed);
    for (std::size_t p = 0; p < count; ++p) {
      x.push_back(random_point<D>(random));
      if (p % 5 == 0)
        for (int d = 0; d < D; ++d) x[p][d] = std::round(x[p][d] * cells) / cells;
      v.push_back(random_point<D>(random, -1, 1));
      H.push_back(0.3 / cells * random_deformation<D>(random, 0.2));
      F.push_back(random_deformation<D>(random, 0.3));
      mass.push_back(uniform(random, 0.5, 1.5));
    }
  }
  std::size_t size() const { return x.size(); }
};

// Calls work(functions, domain_of, name) with all functions that are for D dimensions.
template <int D, class Work>
void with_functions(const Cloud<D>& cloud, const Work& work) {
  const auto point = [&](std::size_t p) { return cloud.x[p]; };
  work(LinearFunctions{}, point, "linear");
  work(SplineFunctions<2>{}, point, "bspline2");
  work(SplineFunctions<3>{}, point, "bspline3");
  work(MomentSplineFunctions{}, point, "bspline2 by moments");
  work(CellFunctions<1>{}, point, "cell_linear");
  work(CellFunctions<2>{}, point, "cell_bspline2");
  work(NineNodeFunctions{}, point, "q9");
  if constexpr (D == 2) work(EightNodeFunctions{}, point, "q8");
  work(
      GimpFunctions{},
      [&](std::size_t p) { return cpgimp_domain<D>(cloud.x[p], cloud.H[p], cloud.F[p]); }, "gimp");
  const auto deformed = [&](std::size_t p) {
    return ParallelepipedDomain<D>{cloud.x[p], cloud.F[p] * cloud.H[p]};
  };
  work(Cpdi1Functions{}, deformed, "cpdi1");
  work(
      Cpdi2Functions{}, [&](std::size_t p) { return CornerDomain<D>(corners_of(deformed(p))); },
      "cpdi2");
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

TYPED_TEST(Transfer, ConservesMassMomentumAndTheirPlace) {
  constexpr int D = TypeParam::value;
  const Cloud<D> cloud(6, 700);
  with_functions<D>(cloud, [&](const auto& functions, const auto& domain_of, const char* name) {
    std::vector<double> mass(cloud.grid.size());
    std::vector<SpaceVector<D>> momentum(cloud.grid.size(), SpaceVector<D>::Zero());
    scatter(cloud.grid, functions, cloud.size(), domain_of, [&](std::size_t p, const auto& at) {
      at.add(mass, cloud.mass[p]);
      at.add(momentum, SpaceVector<D>(cloud.mass[p] * cloud.v[p]));
    });
    double m = 0;
    SpaceVector<D> p = SpaceVector<D>::Zero(), centre = p;
    for (std::size_t k = 0; k < cloud.size(); ++k) {
      m += cloud.mass[k];
      p += cloud.mass[k] * cloud.v[k];
      centre += cloud.mass[k] * cloud.x[k];
    }
    const double rounding = 1e-15 * m * std::sqrt(static_cast<double>(cloud.size()));
    for (std::size_t i = 0; i < mass.size(); ++i) {
      m -= mass[i];
      p -= momentum[i];
      centre -= mass[i] * cloud.grid.position(i);
    }
    EXPECT_NEAR(m, 0, rounding) << name;
    EXPECT_LE(p.norm(), rounding) << name;
    EXPECT_LE(centre.norm(), rounding) << name;
  });
}

// sum_i u_i . w_i with u = sum_p S_ip a_p is sum_p a_p . value(w), and with u = sum_p P_p G_ip it
// is sum_p P_p : gradient(w); for numbers, arrays and vectors, which all have the same bits.
TYPED_TEST(Transfer, GatherIsTheTransposeOfScatter) {
  constexpr int D = TypeParam::value;
  const Cloud<D> cloud(6, 300);
  std::mt19937 random(2);
  std::vector<SpaceVector<D>> w;
  std::vector<std::array<double, D>> w_array(cloud.grid.size());
  std::vector<double> w_first;
  for (std::size_t i = 0; i < cloud.grid.size(); ++i) {
    w.push_back(random_point<D>(random, -1, 1));
    for (int d = 0; d < D; ++d) w_array[i][d] = w[i][d];
    w_first.push_back(w[i][0]);
  }
  with_functions<D>(cloud, [&](const auto& functions, const auto& domain_of, const char* name) {
    std::vector<SpaceVector<D>> u(cloud.grid.size(), SpaceVector<D>::Zero()), flux = u;
    std::vector<std::array<double, D>> u_array(cloud.grid.size()), flux_array = u_array;
    std::vector<double> u_first(cloud.grid.size()), flux_first = u_first;
    scatter(cloud.grid, functions, cloud.size(), domain_of, [&](std::size_t p, const auto& at) {
      std::array<double, D> a;
      for (int d = 0; d < D; ++d) a[d] = cloud.v[p][d];
      at.add(u, cloud.v[p]);
      at.add(u_array, a);
      at.add(u_first, a[0]);
      at.add_gradient(flux, cloud.F[p]);
      at.add_gradient(flux_array, cloud.F[p]);
      at.add_gradient(flux_first, SpaceVector<D>(cloud.F[p].row(0).transpose()));
    });
    std::vector<double> values(cloud.size()), slopes(cloud.size());
    gather(cloud.grid, functions, cloud.size(), domain_of, [&](std::size_t p, const auto& at) {
      const SpaceVector<D> value = at.value(w);
      const SpaceMatrix<D> gradient = at.gradient(w);
      values[p] = cloud.v[p].dot(value);
      slopes[p] = cloud.F[p].cwiseProduct(gradient).sum();
      const std::array<double, D> array = at.value(w_array);
      const SpaceMatrix<D> of_arrays = at.gradient(w_array);
      for (int d = 0; d < D; ++d) EXPECT_EQ(array[d], value[d]) << name;
      EXPECT_EQ(of_arrays, gradient) << name;
      EXPECT_EQ(at.value(w_first), value[0]) << name;
      EXPECT_EQ(SpaceVector<D>(at.gradient(w_first)).transpose(), gradient.row(0)) << name;
      EXPECT_EQ(at.value([&](std::uint32_t i) { return w[i]; }), value) << name;
    });
    double size = 0, value = 0, slope = 0;
    for (std::size_t p = 0; p < cloud.size(); ++p) {
      value += values[p];
      slope += slopes[p];
      size += std::abs(values[p]) + std::abs(slopes[p]);
    }
    for (std::size_t i = 0; i < w.size(); ++i) {
      value -= u[i].dot(w[i]);
      slope -= flux[i].dot(w[i]);
      for (int d = 0; d < D; ++d) {
        EXPECT_EQ(u_array[i][d], u[i][d]) << name;
        EXPECT_NEAR(flux_array[i][d], flux[i][d], 1e-12 * size) << name;
      }
      EXPECT_EQ(u_first[i], u[i][0]) << name;
      EXPECT_NEAR(flux_first[i], flux[i][0], 1e-12 * size) << name;
    }
    EXPECT_NEAR(value, 0, 1e-13 * size) << name;
    EXPECT_NEAR(slope, 0, 1e-13 * size) << name;
  });
}

// Nodal data in single precision, and amounts of another type than the elements.
TEST(NodalData, MayBeFloatsAndVectorsMayMix) {
  const CartesianGrid<2> grid = unit_grid<2>(4);
  NodeFunctions<2> at;
  SplineFunctions<2>{}.at(grid, SpaceVector<2>(0.3, 0.6), at);
  std::vector<float> number(grid.size());
  std::vector<std::array<float, 2>> array(grid.size());
  std::vector<SpaceVector<2>> vector(grid.size(), SpaceVector<2>::Zero());
  Eigen::VectorXd column = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(grid.size()));
  at.add(number, 2.0f);
  at.add(array, SpaceVector<2>(2, 3));
  at.add(vector, SpaceVector<2>(1, 1.5) * 2);
  at.add(column, 2.0);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    EXPECT_EQ(number[i], static_cast<float>(vector[i][0]));
    EXPECT_EQ(array[i][1], static_cast<float>(vector[i][1]));
    EXPECT_EQ(column[static_cast<Eigen::Index>(i)], vector[i][0]);
  }
  EXPECT_NEAR(at.value(number), at.value(column), 1e-7);
  EXPECT_NEAR(at.value(array)[1], at.value(vector)[1], 1e-7);
  EXPECT_NEAR(at.gradient(number).norm(), at.gradient(column).norm(), 1e-6);
}

// Every particle once, with the same bits for any number of threads, also where one particle
// reaches over the whole grid and so makes slabs thick.
TYPED_TEST(Transfer, HasTheSameBitsForAnyNumberOfThreads) {
  constexpr int D = TypeParam::value;
  for (const bool one_is_large : {false, true}) {
    Cloud<D> cloud(D == 3 ? 16 : 30, 20000);
    if (one_is_large) cloud.H[17] *= 0.5 / cloud.H[17].norm();
    with_functions<D>(cloud, [&](const auto& functions, const auto& domain_of, const char* name) {
      const auto sums = [&](int threads) {
        std::vector<SpaceVector<D>> sum(cloud.grid.size(), SpaceVector<D>::Zero());
        std::vector<int> seen(cloud.size());
        scatter(
            cloud.grid, functions, cloud.size(), domain_of,
            [&](std::size_t p, const auto& at) {
              ++seen[p];
              at.add(sum, cloud.v[p]);
            },
            threads);
        EXPECT_EQ(seen, std::vector<int>(cloud.size(), 1)) << name;
        return sum;
      };
      const auto one = sums(1);
      for (const int threads : {2, 3, 8}) EXPECT_TRUE(same_bits(sums(threads), one)) << name;
      std::vector<SpaceVector<D>> plain(cloud.grid.size(), SpaceVector<D>::Zero());
      typename std::remove_cvref_t<decltype(functions)>::template Nodes<D> at;
      for (std::size_t p = 0; p < cloud.size(); ++p) {
        functions.at(cloud.grid, domain_of(p), at);
        at.add(plain, cloud.v[p]);
      }
      for (std::size_t i = 0; i < plain.size(); ++i)
        EXPECT_LE((plain[i] - one[i]).norm(), 1e-10) << name;
    });
  }
}

// The order in which a node is added to: even slabs of rows before odd ones, particles ascending.
TEST(ScatterOrder, IsThatOfSlabsAndParticles) {
  const std::vector<int> first{9, 0, 4, 5, 8, 1, 3, 12};
  std::vector<std::size_t> order;
  scatter_by_rows<int>(
      first.size(), 1, [&](std::size_t p) { return std::pair(first[p], first[p] + 1); },
      [&](std::size_t p, int&) { order.push_back(p); });
  EXPECT_EQ(order, (std::vector<std::size_t>{1, 5, 6, 0, 4, 2, 3, 7}));
  order.clear();
  scatter_by_rows<int>(
      0, 1, [&](std::size_t) { return std::pair(0, 0); },
      [&](std::size_t p, int&) { order.push_back(p); });
  EXPECT_TRUE(order.empty());
}

// A model of the concept NodalFunctions with no more than it asks for: the nearest node alone, as
// particle-in-cell codes had it first.
struct NearestNode {
  template <int D>
  using Nodes = NodeFunctions<D, Exactly<1>>;
  template <int D, class Point>
  void at(const CartesianGrid<D>& grid, const Point& x, Nodes<D>& out) const {
    std::array<int, D> index;
    for (int d = 0; d < D; ++d) index[d] = nodes_along(grid, x, d).first;
    out.node[0] = grid.number(index);
    out.S[0] = 1;
    out.G[0].setZero();
  }
  template <int D, class Point>
  std::pair<int, int> nodes_along(const CartesianGrid<D>& grid, const Point& x, int d) const {
    const int i = grid.cell(x[d] + grid.h() / 2, d);
    return {i, i};
  }
};
static_assert(NodalFunctions<NearestNode, 2, std::array<double, 2>>);

TEST(OwnFunctions, GoThroughTheSameLoops) {
  const CartesianGrid<2> grid = unit_grid<2>(4);
  const std::vector<std::array<double, 2>> x{{0.1, 0.2}, {0.3, 0.45}, {0.3, 0.55}};
  const auto place = [&](std::size_t p) { return x[p]; };
  std::vector<double> count(grid.size());
  scatter(grid, NearestNode{}, x.size(), place,
          [&](std::size_t, const auto& at) { at.add(count, 1.0); });
  EXPECT_EQ(count[grid.number({0, 1})], 1);
  EXPECT_EQ(count[grid.number({1, 2})], 2);
}

// ---- points where none should be ----

template <int D, class Functions>
Eigen::VectorXd values_at(const Functions& functions, const CartesianGrid<D>& grid,
                          const SpaceVector<D>& x) {
  typename Functions::template Nodes<D> at;
  functions.at(grid, x, at);
  Eigen::VectorXd S = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(grid.size()));
  at.add(S, 1.0);
  return S;
}

TYPED_TEST(Transfer, PointsBeyondTheGridAreThoseOnItsFace) {
  constexpr int D = TypeParam::value;
  const CartesianGrid<D> grid = unit_grid<D>(4);
  const auto check = [&](const auto& functions, const char* name) {
    for (const double beyond : {1e-17, 1e-3, 0.6, 1e5, 1e300})
      for (const double face : {0.0, 1.0}) {
        SpaceVector<D> on = SpaceVector<D>::Constant(0.4), off = on;
        on[D - 1] = face;
        off[D - 1] = face == 0 ? -beyond : 1 + beyond;
        EXPECT_LE((values_at(functions, grid, off) - values_at(functions, grid, on)).norm(), 1e-13)
            << name << ' ' << beyond;
        const std::pair<int, int> rows = functions.nodes_along(grid, off, D - 1);
        EXPECT_GE(rows.first, 0) << name;
        EXPECT_LE(rows.second, 4) << name;
      }
  };
  check(LinearFunctions{}, "linear");
  check(SplineFunctions<2>{}, "bspline2");
  check(SplineFunctions<3>{}, "bspline3");
  check(MomentSplineFunctions{}, "bspline2 by moments");
  check(NineNodeFunctions{}, "q9");
  if constexpr (D == 2) check(EightNodeFunctions{}, "q8");
  // But for what asks to go on.
  SpaceVector<D> off = SpaceVector<D>::Constant(0.4);
  off[0] = 1.5;
  ContinuedLinearFunctions::Nodes<D> at;
  ContinuedLinearFunctions{}.at(grid, off, at);
  const auto place = [&](std::uint32_t i) { return grid.position(i); };
  EXPECT_LE((at.value(place) - off).norm(), 1e-13);
}

// A point or domain that is refused is named by its particle, the first of several, before anything
// has been written, on whichever axis it is wrong.
TYPED_TEST(Transfer, RefusesDomainsBeforeAnythingIsWritten) {
  constexpr int D = TypeParam::value;
  const auto check = [](const Cloud<D>& cloud, const auto& functions, const auto& domain_of,
                        const std::string& expected) {
    for (const int threads : {1, 3}) {
      int written = 0;
      const auto count = [&](std::size_t, const auto&) { ++written; };
      for (const std::string& words :
           {message_of(
                [&] { scatter(cloud.grid, functions, cloud.size(), domain_of, count, threads); }),
            message_of(
                [&] { gather(cloud.grid, functions, cloud.size(), domain_of, count, threads); })})
        EXPECT_EQ(words.find("particle 31: " + expected), 0) << words << " not: " << expected;
      EXPECT_EQ(written, 0) << expected;
    }
  };
  for (const double bad : {nan, std::numeric_limits<double>::infinity()})
    for (int d = 0; d < D; ++d) {
      Cloud<D> cloud(4, 50);
      cloud.x[31][d] = cloud.x[40][0] = bad;
      const std::string coordinate = std::string("coordinate ") + "xyz"[d];
      with_functions<D>(cloud, [&](const auto& functions, const auto& domain_of, const char*) {
        check(cloud, functions, domain_of, coordinate);
      });
      // Also where functions of one's own have no check().
      check(
          cloud, NearestNode{}, [&](std::size_t p) { return cloud.x[p]; },
          coordinate + (std::isnan(bad) ? " = nan" : " = inf"));
    }
  for (int d = 0; d < D; ++d) {
    Cloud<D> cloud(4, 50);
    const std::string axis(1, "xyz"[d]);
    const auto box = [&](std::size_t p) {
      SpaceVector<D> half = SpaceVector<D>::Constant(0.1);
      if (p == 31) half[d] = -0.125;
      return BoxDomain<D>{cloud.x[p], half};
    };
    check(cloud, GimpFunctions{}, box,
          "half edge of the particle domain along " + axis + " = -0.125: must be positive");
    cloud.H[31].col(d).setZero();
    const auto flat = [&](std::size_t p) {
      return ParallelepipedDomain<D>{cloud.x[p], cloud.H[p]};
    };
    check(cloud, Cpdi1Functions{}, flat, "determinant of the half edges");
    const auto corners = [&](std::size_t p) {
      if (p != 31) return CornerDomain<D>(corners_of(flat(p)));
      DomainCorners<D> none;
      none.fill(SpaceVector<D>::Zero());
      return CornerDomain<D>(none);
    };
    check(cloud, Cpdi2Functions{}, corners, "volume of the particle domain = 0");
  }
}

TEST(ScatterErrors, NameTheParticle) {
  const auto words = [](int first, int last) {
    return message_of([&] {
      scatter_by_rows<int>(
          3, 1, [&](std::size_t p) { return p == 2 ? std::pair(first, last) : std::pair(0, 1); },
          [](std::size_t, int&) {});
    });
  };
  EXPECT_EQ(words(-1, 1),
            "particle 2: rows = -1 to 1: must be the first and the last index of a node, from 0 "
            "on");
  EXPECT_NE(words(3, 2).find("particle 2: rows = 3 to 2"), std::string::npos);
  const Cloud<2> cloud(3, 7);
  const auto place = [&](std::size_t p) { return cloud.x[p]; };
  EXPECT_EQ(message_of([&] {
              scatter(cloud.grid, NineNodeFunctions{}, 7, place, [](std::size_t, const auto&) {});
            }),
            "particle 0: cells of the grid along x = 3: must be even with elements of 2 x 2 cells");
  EXPECT_EQ(message_of([&] {
              scatter(CartesianGrid<2>(), SplineFunctions<2>{}, 7, place,
                      [](std::size_t, const auto&) {});
            }),
            "particle 0: grid = without cells: must be made with its box and its spacing");
}

// ---- data that are no numbers ----

TEST(TransferData, AmountsThatAreNotFiniteAreNamed) {
  const Cloud<2> cloud(4, 50);
  const auto place = [&](std::size_t p) { return cloud.x[p]; };
  std::vector<double> mass(cloud.grid.size());
  std::vector<SpaceVector<2>> flow(cloud.grid.size(), SpaceVector<2>::Zero());
  std::vector<std::array<float, 2>> array(cloud.grid.size());
  const auto words = [&](const auto& add) {
    return message_of([&] { scatter(cloud.grid, LinearFunctions{}, 50, place, add); });
  };
  const auto bad = [](std::size_t p, double value) { return p == 17 ? value : 1.0; };
  const std::string amount = " of the amount that is added to nodes = ";
  EXPECT_EQ(words([&](std::size_t p, const auto& at) { at.add(mass, bad(p, nan)); }),
            "particle 17: component 0" + amount + "nan: must be finite");
  EXPECT_EQ(words([&](std::size_t p, const auto& at) {
              at.add(flow, SpaceVector<2>(1, bad(p, -HUGE_VAL)) * 2);
            }),
            "particle 17: component 1" + amount + "-inf: must be finite");
  EXPECT_EQ(
      words([&](std::size_t p, const auto& at) { at.add(array, SpaceVector<2>(bad(p, nan), 1)); }),
      "particle 17: component 0" + amount + "nan: must be finite");
  EXPECT_EQ(words([&](std::size_t p, const auto& at) {
              at.add_gradient(flow, SpaceMatrix<2>{{1, 2}, {bad(p, nan), 4}});
            }),
            "particle 17: component 2 of the flux that is added to nodes = nan: must be finite");
  // Trusted ones pass.
  EXPECT_EQ(words([&](std::size_t p, const auto& at) { at.add(mass, bad(p, nan), trusted); }),
            "no InvalidArgument was thrown");
  double sum = 0;
  for (const double m : mass) sum += m;
  EXPECT_TRUE(std::isnan(sum));
}

// What no particle sees may be anything, also where a function is 0 at a node of its cell.
TEST(TransferData, NodalDataThatAreNotFiniteAreNamedWhereTheyAreSeen) {
  const CartesianGrid<2> grid = unit_grid<2>(4);
  std::vector<std::array<double, 2>> u(grid.size(), {nan, nan});
  std::vector<double> first(grid.size(), nan);
  const BoxDomain<2> on_nodes{{0.25, 0.5}, {0.125, 0.25}};
  NodeFunctions<2> at;
  GimpFunctions::at(grid, on_nodes, at);
  std::size_t unseen = 0;
  for (std::size_t k = 0; k < at.size(); ++k) {
    if (at.S[k] == 0 && at.G[k].isZero(0)) {
      ++unseen;
      continue;
    }
    const SpaceVector<2> x = grid.position(at.node[k]);
    u[at.node[k]] = {x[0], 2 * x[1]};
    first[at.node[k]] = x[0];
  }
  EXPECT_GT(unseen, 0u);
  EXPECT_NEAR(at.value(u)[1], 1, 1e-15);
  EXPECT_NEAR(at.value(first), 0.25, 1e-15);
  EXPECT_NEAR(at.gradient(u)(1, 1), 2, 1e-14);
  EXPECT_TRUE(std::isnan(at.value(first, trusted)));
  std::uint32_t seen = 0;
  for (std::size_t k = 0; k < at.size(); ++k)
    if (at.S[k] > 0 && at.G[k].norm() > at.G[seen].norm()) seen = static_cast<std::uint32_t>(k);
  seen = at.node[seen];
  u[seen][1] = nan;
  const std::string words =
      "component 1 of the nodal data at node " + std::to_string(seen) + " = nan: must be finite";
  EXPECT_EQ(message_of([&] { at.value(u); }), words);
  EXPECT_EQ(message_of([&] { at.gradient(u); }), words);
  EXPECT_EQ(message_of([&] {
              gather(
                  grid, GimpFunctions{}, 3, [&](std::size_t) { return on_nodes; },
                  [&](std::size_t, const auto& nodes) { nodes.value(u); });
            }),
            "particle 0: " + words);
  std::vector<double> large(grid.size(), 1e308);
  large[0] = -1e308;
  LinearFunctions{}.at(grid, SpaceVector<2>(0.1, 0.1), at);
  EXPECT_EQ(message_of([&] { at.gradient(large); }).find("component 0 of the sum over nodal data"),
            0);
}

// Fields go through the same loops as what one writes oneself, in every bit.
TYPED_TEST(Transfer, FieldsAreSummedAndSeen) {
  constexpr int D = TypeParam::value;
  const Cloud<D> cloud(6, 700);
  std::vector<std::array<double, D>> v(cloud.size());
  for (std::size_t p = 0; p < cloud.size(); ++p)
    for (int d = 0; d < D; ++d) v[p][d] = cloud.v[p][d];
  with_functions<D>(cloud, [&](const auto& functions, const auto& domain_of, const char* name) {
    std::vector<std::array<double, D>> sum(cloud.grid.size()), by_hand = sum;
    scatter(cloud.grid, functions, cloud.size(), domain_of,
            [&](std::size_t p, const auto& at) { at.add(by_hand, v[p]); });
    scatter(cloud.grid, functions, domain_of, field_of(v), field_of(sum));
    EXPECT_EQ(sum, by_hand) << name;
    std::vector<std::array<double, D>> seen(cloud.size()), seen_by_hand = seen;
    gather(cloud.grid, functions, cloud.size(), domain_of,
           [&](std::size_t p, const auto& at) { seen_by_hand[p] = at.value(sum); });
    gather(cloud.grid, functions, domain_of, field_of(std::as_const(sum)), field_of(seen));
    EXPECT_EQ(seen, seen_by_hand) << name;
  });
}

// A field with a number that is not finite leaves the output as it was.
TEST(TransferData, FieldsAreCheckedBeforeAnythingIsWritten) {
  const Cloud<2> cloud(4, 5000);
  const auto place = [&](std::size_t p) { return cloud.x[p]; };
  std::vector<std::array<double, 2>> v(cloud.size(), {1, 2}), out(cloud.size(), {7, 7});
  std::vector<std::array<double, 2>> nodes(cloud.grid.size(), {3, 3}), before = nodes;
  const LinearFunctions linear;
  const auto add = [&] {
    return message_of([&] { scatter(cloud.grid, linear, place, field_of(v), field_of(nodes)); });
  };
  const auto take = [&] {
    return message_of([&] { gather(cloud.grid, linear, place, field_of(nodes), field_of(out)); });
  };
  v[4321][1] = v[4999][0] = nan;
  EXPECT_EQ(add(),
            "particle 4321: component 1 of the amount that is added to nodes = nan: must be "
            "finite");
  EXPECT_EQ(nodes, before);
  v[4321][1] = v[4999][0] = 1;
  nodes[12][1] = HUGE_VAL;
  EXPECT_EQ(add(), "component 1 of the nodal data at node 12 = inf: must be finite");
  EXPECT_NE(take().find(": component 1 of the nodal data at node 12 = inf: must be finite"),
            std::string::npos);
  EXPECT_EQ(out, (std::vector<std::array<double, 2>>(cloud.size(), {7, 7})));
  nodes[12][1] = 1.7e308;
  v.assign(v.size(), {1, 1e306});
  const std::string words = add();
  EXPECT_NE(words.find("component 1 of the nodal data at node"), std::string::npos) << words;
  EXPECT_NE(words.find("= inf: overflows"), std::string::npos) << words;
  nodes.pop_back();
  EXPECT_EQ(add(), "size of the nodal data = 24: must be the number of nodes");
  std::vector<double> one(cloud.grid.size());
  EXPECT_EQ(message_of([&] { scatter(cloud.grid, linear, place, field_of(v), field_of(one)); }),
            "components of the nodal data = 1: must be those of the amounts");
  // Nodes that no particle sees may hold anything.
  const CartesianGrid<2> wide({-1, -1}, {2, 2}, 0.25);
  std::vector<double> values(wide.size(), nan), seen(cloud.size());
  scatter(wide, linear, cloud.size(), place, [&](std::size_t, const auto& at) {
    for (std::size_t k = 0; k < at.size(); ++k) values[at.node[k]] = 1;
  });
  gather(wide, linear, place, field_of(values), field_of(seen));
  for (const double value : seen) EXPECT_NEAR(value, 1, 1e-15);
}

TEST(TransferData, OutputsOfLessRangeAreChecked) {
  const CartesianGrid<2> grid({0, 0}, {4, 4}, 1);
  const std::vector<std::array<double, 2>> at{{1.5, 1.5}};
  const std::vector<double> nodes(grid.size(), 1e300);
  std::vector<float> out(1, 7);
  const std::string message = message_of([&] {
    gather(
        grid, LinearFunctions{}, [&](std::size_t p) { return at[p]; }, field_of(nodes),
        field_of(out));
  });
  EXPECT_NE(message.find("particle 0: component 0 of the output"), std::string::npos) << message;
}

}  // namespace
}  // namespace recon::test
