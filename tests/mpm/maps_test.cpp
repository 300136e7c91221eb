// The maps between particles and nodes, quadratures and updates: the identities that define them.
#include <Eigen/Dense>
#include <cmath>
#include <cstring>
#include <set>

#include "mpm/support.hpp"
#include "recon/runs/ledger.hpp"

namespace recon::mpm::test {
namespace {

constexpr double rounding_of_maps = 1e-12;

template <int D>
Vector<D> random_vector(std::mt19937& random, double size = 1) {
  Vector<D> v;
  for (int d = 0; d < D; ++d) v[d] = uniform(random, -size, size);
  return v;
}

// A block whose particles are moved by up to a quarter of their own box, with masses of their own
// and random velocities.
template <int D>
Problem<D> cloud(int cells, double lower, double upper, const Method& method, int per_cell = 3) {
  Problem<D> problem = block<D>(cells, lower, upper, "mpm", per_cell);
  problem.method = method;
  std::mt19937 random(21);
  Particles<D>& particles = problem.particles;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    particles.x[p] += random_vector<D>(random, problem.grid.h() / per_cell / 4);
    particles.X[p] = particles.x[p];
    particles.mass[p] *= uniform(random, 0.5, 1.5);
    particles.v[p] = random_vector<D>(random);
  }
  return problem;
}

template <int D>
struct LinearField {
  Vector<D> constant;
  Matrix<D> slope;
  explicit LinearField(std::uint32_t seed = 22) {
    std::mt19937 random(seed);
    constant = random_vector<D>(random);
    for (int d = 0; d < D; ++d) slope.col(d) = random_vector<D>(random);
  }
  Vector<D> operator()(const Vector<D>& x) const { return constant + slope * x; }
  void give(Particles<D>& particles) const {
    for (std::size_t p = 0; p < particles.size(); ++p) {
      particles.v[p] = (*this)(particles.x[p]);
      particles.L[p] = slope;
    }
  }
};

Method changed(const std::string& name, const auto& change) {
  Method method = method_named(name);
  change(method);
  return method;
}
Method with(Basis basis, MassMatrix mass = MassMatrix::lumped) {
  return changed("mpm", [&](Method& m) {
    m.basis = basis;
    m.mass = mass;
  });
}

// S as a matrix: a row for each particle.
template <int D>
Eigen::MatrixXd shape_matrix(const Problem<D>& problem) {
  const std::size_t count = problem.particles.size();
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(count),
                                            static_cast<Eigen::Index>(problem.grid.size()));
  with_shape(problem.method, [&](auto policy) {
    NodeFunctions<D> shape;
    for (std::size_t p = 0; p < count; ++p) {
      policy.shape(problem.grid, problem.particles, p, shape);
      for (std::size_t k = 0; k < shape.size(); ++k)
        S(static_cast<Eigen::Index>(p), shape.node[k]) += shape.S[k];
    }
  });
  return S;
}
template <int D>
Eigen::MatrixXd rows(const std::vector<Vector<D>>& values) {
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(values.size()), D);
  for (std::size_t i = 0; i < values.size(); ++i)
    matrix.row(static_cast<Eigen::Index>(i)) = values[i].transpose();
  return matrix;
}
template <int D>
void give_rows(const Eigen::MatrixXd& matrix, std::vector<Vector<D>>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = matrix.row(static_cast<Eigen::Index>(i)).transpose();
}
Eigen::VectorXd column(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

template <int D>
double largest(const std::vector<Vector<D>>& values) {
  double most = 0;
  for (const Vector<D>& value : values) most = std::max(most, value.norm());
  return most;
}

std::string blamed(const auto& work) {
  try {
    work();
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

// ---- consistent mass (Andersen, Andersen 2007, eq. 10, 17) ----

template <class T>
class ConsistentMass : public testing::Test {};
TYPED_TEST_SUITE(ConsistentMass, AllDimensions);

template <int D>
std::vector<Basis> bases() {
  using enum Basis;
  std::vector<Basis> all{linear, q9, bspline2, bspline3, mls_bspline2};
  if (D == 2) all.push_back(q8);
  return all;
}

// The residual of the projection is orthogonal to every function: sum_p m_p N_i (v_p - v(x_p)) = 0;
// and the rows of M sum to the lumped mass.
TYPED_TEST(ConsistentMass, ProjectsByLeastSquares) {
  constexpr int D = TypeParam::value;
  for (const Basis basis : bases<D>()) {
    const Problem<D> problem = cloud<D>(2, 0, 1, with(basis, MassMatrix::consistent), 4);
    Simulation<D> simulation(problem);
    simulation.map();
    const Nodes<D>& nodes = simulation.nodes();
    const Eigen::MatrixXd S = shape_matrix(problem), v = rows<D>(problem.particles.v);
    const Eigen::VectorXd masses = column(problem.particles.mass);
    const auto mass = masses.asDiagonal();
    const Eigen::MatrixXd momentum = S.transpose() * mass * v,
                          residual = S.transpose() * mass * (v - S * rows<D>(nodes.mapped));
    EXPECT_LE(residual.norm(), 1e-11 * momentum.norm()) << name_of(basis);
    const Eigen::MatrixXd M = S.transpose() * mass * S;
    EXPECT_LE((Eigen::MatrixXd(nodes.mass_matrix) - M).norm(), rounding_of_maps * M.norm());
    const Eigen::VectorXd lumped = M.rowwise().sum();
    EXPECT_LE((lumped - column(nodes.mass)).norm(), rounding_of_maps * M.norm()) << name_of(basis);
  }
}

// Fields in the space of the functions are on the nodes what they are on the particles, and so is
// their energy: no interpolation error. Lumped mass smooths them.
TYPED_TEST(ConsistentMass, KeepsFieldsOfItsFunctions) {
  constexpr int D = TypeParam::value;
  for (const Basis basis : bases<D>())
    for (const MassMatrix mass : {MassMatrix::consistent, MassMatrix::lumped}) {
      Problem<D> problem = cloud<D>(2, 0, 1, with(basis, mass), 4);
      const Eigen::MatrixXd S = shape_matrix(problem);
      std::mt19937 random(23);
      std::vector<Vector<D>> values(problem.grid.size());
      for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = random_vector<D>(random);
        if (S.col(static_cast<Eigen::Index>(i)).cwiseAbs().maxCoeff() == 0) values[i].setZero();
      }
      give_rows<D>(S * rows<D>(values), problem.particles.v);
      Simulation<D> simulation(problem);
      simulation.map();
      const Ledger ledger = account(simulation);
      const double error = (rows<D>(simulation.nodes().mapped) - rows<D>(values)).norm();
      const double lost = 1 - ledger.node_kinetic / ledger.kinetic;
      if (mass == MassMatrix::consistent) {
        EXPECT_LE(error, 1e-10) << name_of(basis);
        EXPECT_NEAR(lost, 0, rounding_of_maps) << name_of(basis);
      } else {
        EXPECT_GE(error, 0.1) << name_of(basis);
        EXPECT_GE(std::abs(lost), 0.05) << name_of(basis);
      }
    }
}

// Linear fields are in the space of every basis: nodes have the field, particles its gradient; also
// where domains are not points.
TYPED_TEST(ConsistentMass, KeepsLinearFields) {
  constexpr int D = TypeParam::value;
  const LinearField<D> field;
  const auto check = [&](Method method) {
    method.mass = MassMatrix::consistent;
    Problem<D> problem = cloud<D>(2, 0, 1, method, 4);
    field.give(problem.particles);
    for (auto& L : problem.particles.L) L.setZero();
    Simulation<D> simulation(problem);
    simulation.map();
    for (std::size_t i = 0; i < problem.grid.size(); ++i)
      if (simulation.nodes().mass[i] != 0) {
        EXPECT_LE((simulation.nodes().mapped[i] - field(problem.grid.position(i))).norm(), 1e-10)
            << name_of(method.basis) << " " << name_of(method.domain) << " node " << i;
      }
    simulation.step(1e-3);
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      EXPECT_LE((simulation.particles().L[p] - field.slope).norm(), 1e-9);
      EXPECT_LE((simulation.particles().v[p] - problem.particles.v[p]).norm(), 1e-10);
    }
  };
  using enum Basis;
  for (const Basis basis : {linear, q9, bspline2, bspline3, mls_bspline2}) check(with(basis));
  for (const char* domain : {"ugimp", "cpgimp", "cpdi1", "cpdi2"}) check(method_named(domain));
}

// M a = f + M g with a = 0 where velocities are held: the other rows hold exactly.
TYPED_TEST(ConsistentMass, HoldsBoundaries) {
  constexpr int D = TypeParam::value;
  for (const Basis basis : {Basis::linear, Basis::bspline3}) {
    Problem<D> problem = cloud<D>(3, 0, 1, with(basis, MassMatrix::consistent));
    std::mt19937 random(24);
    for (auto& stress : problem.particles.stress) {
      for (int d = 0; d < D; ++d) stress.col(d) = random_vector<D>(random, 100);
      stress = (stress + stress.transpose()).eval();
    }
    problem.gravity = random_vector<D>(random);
    Boundary<D> roller;
    roller.axis = D - 1;
    roller.velocity[D - 1] = 0.25;
    problem.boundaries = {roller};
    Simulation<D> simulation(problem);
    simulation.map();
    const Nodes<D>& nodes = simulation.nodes();
    Eigen::MatrixXd rest = nodes.mass_matrix * rows<D>(nodes.acceleration) - rows<D>(nodes.force) -
                           column(nodes.mass) * problem.gravity.transpose();
    int held = 0;
    for (std::size_t i = 0; i < problem.grid.size(); ++i)
      if (problem.grid.position(i)[D - 1] == 0) {
        EXPECT_EQ(nodes.acceleration[i][D - 1], 0);
        EXPECT_EQ(nodes.velocity[i][D - 1], 0.25);
        rest(static_cast<Eigen::Index>(i), D - 1) = 0;
        ++held;
      }
    EXPECT_EQ(held, std::lround(std::pow(4, D - 1)));
    EXPECT_LE(rest.norm(), 1e-11 * rows<D>(nodes.force).norm()) << name_of(basis);
  }
}

// One particle a cell: fewer than nodes. The node that is named lies by the particles, not in the
// empty part of the grid.
TEST(ConsistentMassFailures, NameANode) {
  for (const double v : {0.0, 1.0}) {
    Problem<2> problem = block<2>(8, 0.5, 0.75, "mpm", 1);
    problem.method.mass = MassMatrix::consistent;
    for (auto& velocity : problem.particles.v) velocity << v, 0;
    Simulation<2> simulation(problem);
    try {
      simulation.map();
      FAIL() << "the mass matrix is singular";
    } catch (const Failure& failure) {
      const std::string what = failure.what();
      EXPECT_NE(what.find("singular"), std::string::npos) << what;
      EXPECT_NE(what.find("node " + std::to_string(failure.number())), std::string::npos) << what;
      const Vector<2> at = problem.grid.position(failure.number());
      EXPECT_LE((at - Vector<2>(0.625, 0.625)).cwiseAbs().maxCoeff(), 0.125 + rounding_of_maps)
          << what;
    }
  }
}

// ---- choices that do not go together ----

TEST(Methods, SayWhyChoicesAreRefused) {
  const auto why = [](const auto& change, int dimension = 2) {
    return blamed([&] { changed("mpm", change).validate(dimension); });
  };
  const auto expect = [](const std::string& what, const std::vector<std::string>& words) {
    for (const std::string& word : words)
      EXPECT_NE(what.find(word), std::string::npos) << "'" << word << "' is not in: " << what;
  };
  expect(why([](Method& m) { m.degree = 3; }), {"degree", "3", "imls"});
  expect(why([](Method& m) { m.order = 0; }), {"order", "0"});
  expect(why([](Method& m) { m.basis = Basis::q8; }, 1), {"q8", "2-D", "q9"});
  expect(why([](Method& m) { m.basis = Basis::q8; }, 3), {"q8", "2-D", "q9"});
  for (const Domain domain : {Domain::ugimp, Domain::cpgimp, Domain::cpdi1, Domain::cpdi2})
    expect(why([&](Method& m) {
             m.domain = domain;
             m.basis = Basis::bspline2;
           }),
           {"domain", std::string(name_of(domain)), "linear functions", "basis is bspline2"});
  for (const Quadrature quadrature : {Quadrature::cells, Quadrature::nodal_cells})
    expect(why([&](Method& m) {
             m.quadrature = quadrature;
             m.velocity = VelocityMap::mls;
             m.basis = Basis::bspline3;
           }),
           {"bspline3", "linear functions"});
  for (const Quadrature quadrature : {Quadrature::taylor_cells, Quadrature::gauss_cells}) {
    const std::string name(name_of(quadrature));
    for (const Basis basis : {Basis::q8, Basis::q9, Basis::mls_bspline2})
      expect(why([&](Method& m) {
               m.quadrature = quadrature;
               m.basis = basis;
             }),
             {name, "linear", "spline", "basis is " + std::string(name_of(basis))});
    expect(why([&](Method& m) {
             m.quadrature = quadrature;
             m.domain = Domain::cpdi1;
           }),
           {name, "point particles"});
    expect(why([&](Method& m) {
             m.quadrature = quadrature;
             m.velocity = VelocityMap::mls;
           }),
           {"mls", "momentum", "quadrature is " + name});
  }
  expect(why([](Method& m) {
           m.velocity = VelocityMap::polynomial;
           m.domain = Domain::ugimp;
         }),
         {"polynomial", "products", "domain is ugimp"});
  for (const VelocityMap map : {VelocityMap::affine, VelocityMap::polynomial}) {
    const std::string name(name_of(map));
    expect(why([&](Method& m) {
             m.velocity = map;
             m.basis = Basis::q9;
           }),
           {name, "nowhere negative", "basis is q9"});
    for (const Update update : {Update::xpic, Update::fmpm, Update::runge_kutta})
      expect(why([&](Method& m) {
               m.velocity = map;
               m.update = update;
             }),
             {name, "flip or pic", "update is " + std::string(name_of(update))});
  }
  for (const VelocityMap map : {VelocityMap::mls, VelocityMap::imls, VelocityMap::cpls})
    expect(why([&](Method& m) {
             m.mass = MassMatrix::consistent;
             m.velocity = map;
           }),
           {"consistent", "mass-weighted"});
  for (const Update update : {Update::xpic, Update::fmpm, Update::runge_kutta})
    expect(why([&](Method& m) {
             m.mass = MassMatrix::consistent;
             m.update = update;
           }),
           {std::string(name_of(update)), "lumped"});
  for (const VelocityMap map : {VelocityMap::mass_weighted, VelocityMap::taylor})
    for (const Quadrature quadrature : {Quadrature::cells, Quadrature::nodal_cells})
      expect(why([&](Method& m) {
               m.velocity = map;
               m.quadrature = quadrature;
             }),
             {std::string(name_of(map)), "mass of cells", std::string(name_of(quadrature))});
  for (const char* name : {"impm", "wls"}) {
    Method method = method_named(name);
    method.domain = Domain::cpdi1;
    expect(blamed([&] { method.validate(2); }), {"quadrature", "point particles"});
  }
  for (const Update update : {Update::xpic, Update::fmpm})
    for (const char* name : {"impm", "wls", "tls", "bspline_mls"}) {
      Method method = method_named(name);
      method.update = update;
      expect(blamed([&] { method.validate(2); }), {std::string(name_of(update)), "quadrature"});
    }
  expect(why([](Method& m) {
           m.domain = Domain::cpdi2;
           m.update = Update::runge_kutta;
         }),
         {"runge_kutta", "cpdi2", "corners"});
  for (const double blend : {-0.1, 1.1, double(NAN)})
    expect(why([&](Method& m) { m.blend = blend; }), {"blend", "from 0 to 1"});
  for (const Update update : {Update::pic, Update::xpic, Update::fmpm, Update::runge_kutta}) {
    expect(why([&](Method& m) {
             m.blend = 0.5;
             m.update = update;
           }),
           {"blend", "flip", "update is " + std::string(name_of(update))});
    expect(why([&](Method& m) {
             m.blend_rate = 0.5;
             m.update = update;
           }),
           {"blend_rate", "flip", "update is " + std::string(name_of(update))});
  }
  expect(why([](Method& m) {
           m.mass = MassMatrix::consistent;
           m.basis = Basis::cell_linear;
         }),
         {"consistent", "every nodal value", "basis is cell_linear"});
  for (const double rate : {-0.1, HUGE_VAL, double(NAN)})
    expect(why([&](Method& m) { m.blend_rate = rate; }), {"blend_rate", "not negative"});
  expect(why([](Method& m) { m.quadrature = Quadrature::adjoint_cells; }),
         {"adjoint_cells", "through the cells", "basis is linear"});
  expect(why([](Method& m) {
           m.quadrature = Quadrature::adjoint_cells;
           m.basis = Basis::cell_bspline2;
           m.border = SplineBorder::linear_cells;
         }),
         {"adjoint_cells", "corrected", "spline_border is linear_cells"});
  for (const Quadrature quadrature : {Quadrature::taylor_cells, Quadrature::gauss_cells})
    expect(why([&](Method& m) {
             m.quadrature = quadrature;
             m.basis = Basis::cell_bspline2;
           }),
           {"gradients", "basis is cell_bspline2"});
  for (const StressUpdate stress : {StressUpdate::first, StressUpdate::musl})
    for (const Update update : {Update::xpic, Update::fmpm, Update::runge_kutta})
      expect(why([&](Method& m) {
               m.stress = stress;
               m.update = update;
             }),
             {std::string(name_of(stress)), "flip or pic", std::string(name_of(update))});
  expect(why([](Method& m) {
           m.scheme = Scheme::symplectic_euler;
           m.update = Update::runge_kutta;
         }),
         {"symplectic_euler", "runge_kutta"});
  for (const Method& method : methods()) EXPECT_NO_THROW(method.validate(2)) << method.name;
}

// Every enumerator has a name, and no two have the same.
TEST(Methods, ChoicesHaveNames) {
  std::set<std::string> words;
  const Method method;
  method.choices([&]<class T>(const char* key, const T&) {
    if constexpr (std::is_enum_v<T>) {
      const std::vector<std::string> names = names_of<T>();
      for (std::size_t i = 0; i < names.size(); ++i) {
        EXPECT_TRUE(words.insert(names[i]).second) << names[i];
        EXPECT_EQ(name_of(static_cast<T>(i)), names[i]) << key;
      }
    }
  });
  EXPECT_EQ(names_of<Update>().back(), name_of(Update::runge_kutta));
}

// ---- negative mass ----

// Corners of 8-node elements are lighter than nothing from the start (bases_test.cpp).
TEST(NegativeMasses, AreReportedAtOnce) {
  const Problem<2> problem = block<2>(8, 0.25, 0.75, "q8");
  Simulation<2> simulation(problem);
  EXPECT_FALSE(simulation.negative_mass());
  simulation.map();
  ASSERT_TRUE(simulation.negative_mass());
  const NegativeMass found = *simulation.negative_mass();
  EXPECT_EQ(found.step, 0);
  EXPECT_LT(found.mass, 0);
  EXPECT_EQ(found.mass, simulation.nodes().mass[found.node]);
  for (std::size_t i = 0; i < found.node; ++i) EXPECT_GE(simulation.nodes().mass[i], 0);
  EXPECT_GE(simulation.nodes().negative, 9u);
  EXPECT_EQ(account(simulation).negative_nodes, simulation.nodes().negative);
  EXPECT_FALSE(simulation.sign_change());

  Problem<2> strict = problem;
  strict.method.at_negative_mass = AtNegativeMass::stop;
  Simulation<2> stopped(strict);
  try {
    stopped.map();
    FAIL() << "it must stop";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.step(), 0);
    EXPECT_EQ(failure.number(), found.node);
    EXPECT_STREQ(failure.place(), "node");
    EXPECT_NE(std::string(failure.what()).find("q8"), std::string::npos) << failure.what();
  }
}

// A body that flies through cells of 9-node elements: all masses are positive at first, then one
// passes through zero. Nodes of positive functions stay positive.
TEST(NegativeMasses, ComeToNineNodeElementsByCrossing) {
  const auto fly = [](const std::string& name) {
    Problem<2> problem = block<2>(8, 0.25, 0.5, name);
    for (auto& v : problem.particles.v) v << 0.1, 0.05;
    Simulation<2> simulation(problem);
    simulation.map();
    EXPECT_FALSE(simulation.negative_mass()) << name;
    for (int s = 0; s < 40; ++s) {
      simulation.step(0.05);
      simulation.map();
    }
    return simulation;
  };
  const auto nine = fly("q9");
  ASSERT_TRUE(nine.negative_mass() && nine.sign_change());
  EXPECT_GT(nine.negative_mass()->step, 0);
  EXPECT_LT(nine.negative_mass()->mass, 0);
  for (const char* name : {"mpm", "bspline2", "bspline3", "mls_mpm"}) {
    const auto positive = fly(name);
    EXPECT_FALSE(positive.negative_mass() || positive.sign_change()) << name;
    for (const double mass : positive.nodes().mass) EXPECT_GE(mass, 0) << name;
  }
}

// ---- quadratures ----

template <class T>
class Quadratures : public testing::Test {};
TYPED_TEST_SUITE(Quadratures, AllDimensions);

// Taylor least squares keep the mass and the momentum of every cell (Wobbes et al. 2018), whatever
// the cloud; a hole makes cells that keep their particles.
TYPED_TEST(Quadratures, TaylorCellsConserve) {
  constexpr int D = TypeParam::value;
  for (const Basis basis : {Basis::linear, Basis::bspline2, Basis::bspline3})
    for (const int per_cell : {1, 2, 3}) {
      Problem<D> problem =
          cloud<D>(8, 0.125, 1, changed("tls", [&](Method& m) { m.basis = basis; }),
                   D == 3 ? std::min(per_cell, 2) : per_cell);
      Particles<D> some;
      for (std::size_t p = 0; p < problem.particles.size(); ++p) {
        const Vector<D> x = problem.particles.x[p];
        if (x.minCoeff() > 0.75) continue;
        some.add(x, problem.particles.half_edges[p], 1000, 0);
        some.v.back() = problem.particles.v[p];
        some.mass.back() = problem.particles.mass[p];
      }
      problem.particles = some;
      Simulation<D> simulation(problem);
      simulation.map();
      const auto& fill = simulation.cells().fill;
      const auto full = std::count(fill.begin(), fill.end(), 1.0);
      EXPECT_GT(full, 0);
      EXPECT_LT(static_cast<std::size_t>(full), fill.size());
      const Ledger ledger = account(simulation);
      EXPECT_NEAR(ledger.node_mass, ledger.mass, rounding_of_maps * ledger.mass);
      EXPECT_LE(distance(ledger.node_momentum, ledger.momentum), rounding_of_maps * ledger.mass);
    }
}

// sigma = constant + one slope for each axis.
template <int D>
struct LinearStress {
  Matrix<D> constant;
  std::array<Matrix<D>, D> slope;
  explicit LinearStress(bool varies) {
    std::mt19937 random(25);
    const auto symmetric = [&] {
      Matrix<D> A;
      for (int d = 0; d < D; ++d) A.col(d) = random_vector<D>(random, 100);
      return Matrix<D>(A + A.transpose());
    };
    constant = symmetric();
    for (auto& each : slope) each = varies ? symmetric() : Matrix<D>(Matrix<D>::Zero());
  }
  Matrix<D> operator()(const Vector<D>& x) const {
    Matrix<D> sum = constant;
    for (int d = 0; d < D; ++d) sum += x[d] * slope[d];
    return sum;
  }
  Vector<D> divergence() const {
    Vector<D> sum = Vector<D>::Zero();
    for (int d = 0; d < D; ++d) sum += slope[d].col(d);
    return sum;
  }
};

// Where all cells about a node are full, f_i = -int sigma grad N_i = div sigma h^D, for clouds that
// are not regular.
TYPED_TEST(Quadratures, OfLinearStressAreExactInside) {
  constexpr int D = TypeParam::value;
  for (const char* name : {"tls", "bspline_mls", "wls"})
    for (const bool varies : {false, true}) {
      Problem<D> problem = cloud<D>(8, 0, 1, method_named(name), D == 1 ? 3 : 2);
      const LinearStress<D> stress(varies);
      for (std::size_t p = 0; p < problem.particles.size(); ++p)
        problem.particles.stress[p] = stress(problem.particles.x[p]);
      Simulation<D> simulation(problem);
      simulation.map();
      const double h = problem.grid.h();
      const Vector<D> exact = stress.divergence() * std::pow(h, D);
      double most = 0;
      for (std::size_t i = 0; i < problem.grid.size(); ++i) {
        const Vector<D> x = problem.grid.position(i);
        if (x.minCoeff() > 2.5 * h && x.maxCoeff() < 1 - 2.5 * h)
          most = std::max(most, (simulation.nodes().force[i] - exact).norm());
      }
      EXPECT_LE(most, 1e-11 * stress.constant.norm() * std::pow(h, D - 1)) << name << varies;
    }
}

// Wallstedt, Guilkey 2011: density and stress are linear between the nodes, so a linear stress over
// a block of whole cells gives the exact integrals, also at its border and in the nodes around.
TYPED_TEST(Quadratures, NodalCellsAreExactOverABlock) {
  constexpr int D = TypeParam::value;
  Problem<D> problem = cloud<D>(4, 0.25, 0.75, method_named("wls"), 3);
  const LinearStress<D> stress(true);
  Particles<D>& particles = problem.particles;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    particles.stress[p] = stress(particles.x[p]);
    particles.mass[p] = 1000 * particles.volume0[p];
  }
  Simulation<D> simulation(problem);
  simulation.map();
  // By Gauss points of the cells, exact for these integrands.
  const double h = problem.grid.h(), offset = h / (2 * std::sqrt(3.0));
  std::vector<Vector<D>> force(problem.grid.size(), Vector<D>::Zero());
  std::vector<double> mass(problem.grid.size());
  for (int g = 0; g < 1 << (2 * D); ++g) {
    Vector<D> x;
    for (int d = 0; d < D; ++d)
      x[d] = 0.375 + (g >> d & 1) * h + (g >> (D + d) & 1 ? offset : -offset);
    LinearFunctions::Nodes<D> shape;
    LinearFunctions{}.at(problem.grid, x, shape);
    const double volume = std::pow(h / 2, D);
    for (std::size_t k = 0; k < shape.size(); ++k) {
      force[shape.node[k]] -= volume * stress(x) * shape.G[k];
      mass[shape.node[k]] += volume * 1000 * shape.S[k];
    }
  }
  EXPECT_LE((rows<D>(force) - rows<D>(simulation.nodes().force)).norm(),
            1e-11 * rows<D>(force).norm());
  EXPECT_LE((column(mass) - column(simulation.nodes().mass)).norm(), 1e-11 * column(mass).norm());
}

// With three regular particles an axis all that Taylor least squares get wrong in a quadratic is
// its mean: that of the particles, sum psi_3 / 3 = -1/54 for psi_3 = xi^2 / 2 - 1/6 at xi = 0,
// +-2/3, not that of the cell, which is zero.
TYPED_TEST(Quadratures, TaylorCellsReproduceQuadratics) {
  constexpr int D = TypeParam::value;
  const int cells = D == 3 ? 6 : 8;
  Problem<D> problem = block<D>(cells, 0, 1, "tls", 3);
  const double h = problem.grid.h();
  const LinearField<D> linear;
  std::array<Matrix<D>, D> curved;  // of each component
  for (int d = 0; d < D; ++d) {
    curved[d] = LinearField<D>(30 + static_cast<std::uint32_t>(d)).slope;
    curved[d] = (curved[d] + curved[d].transpose()).eval();
  }
  const auto field = [&](const Vector<D>& x) {
    Vector<D> v = linear(x);
    for (int d = 0; d < D; ++d) v[d] += x.dot(curved[d] * x) / 2;
    return v;
  };
  Vector<D> shift;  // psi_3 has the factor u'' (h / 2)^2 on each axis
  for (int d = 0; d < D; ++d) shift[d] = -curved[d].trace() * h * h / 4 / 54;
  for (std::size_t p = 0; p < problem.particles.size(); ++p)
    problem.particles.v[p] = field(problem.particles.x[p]);
  Simulation<D> simulation(problem);
  simulation.map();
  std::vector<Vector<D>> momentum(problem.grid.size(), Vector<D>::Zero());
  std::vector<double> mass(problem.grid.size());
  const int all = static_cast<int>(std::lround(std::pow(2 * cells, D)));
  for (int g = 0; g < all; ++g) {
    Vector<D> x;
    for (int d = 0, rest = g; d < D; ++d, rest /= 2 * cells) {
      const int k = rest % (2 * cells);
      x[d] = (k / 2 + 0.5 + (k % 2 ? 0.5 : -0.5) / std::sqrt(3.0)) * h;
    }
    SplineFunctions<3>::Nodes<D> shape;
    SplineFunctions<3>{}.at(problem.grid, x, shape);
    for (std::size_t k = 0; k < shape.size(); ++k) {
      const double part = 1000 * std::pow(h / 2, D) * shape.S[k];
      mass[shape.node[k]] += part;
      momentum[shape.node[k]] += part * (field(x) + shift);
    }
  }
  EXPECT_LE((column(mass) - column(simulation.nodes().mass)).norm(), 1e-11 * column(mass).norm());
  EXPECT_LE((rows<D>(momentum) - rows<D>(simulation.nodes().momentum)).norm(),
            1e-11 * rows<D>(momentum).norm());
}

// ---- stress at the centres of cells, strain as its transpose ----

// The power of the nodes' forces is that of the stresses in the strains that follow,
// sum_i f_i . v_i+ = -sum_p W_p sigma_p : L_p, to rounding_of_maps, with W_p = sum_c W_cp: whatever the cloud,
// at walls and at free surfaces. Where the strain is not the transpose, as in impm, it is not.
TYPED_TEST(Quadratures, OfAdjointCellsAreTransposes) {
  constexpr int D = TypeParam::value;
  const auto mismatch = [](const Method& method, double lower) {
    Problem<D> problem = cloud<D>(6, lower, 5.0 / 6, method, 2);
    const LinearStress<D> stress(true);
    std::vector<double> volumes;
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      problem.particles.stress[p] = stress(problem.particles.x[p]);
      volumes.push_back(problem.particles.volume(p));
    }
    if (method.quadrature == Quadrature::adjoint_cells) {
      CellWeights<D> weights;
      weights.fill(problem.grid, 2, problem.particles.x, volumes);
      for (std::size_t p = 0; p < volumes.size(); ++p) {
        double sum = 0;
        weights.for_cells(problem.grid, problem.particles.x[p], volumes[p],
                          [&](std::size_t, double weight) { sum += weight; });
        volumes[p] = sum;
      }
    }
    Simulation<D> simulation(problem);
    simulation.map();
    const std::vector<Vector<D>> force = simulation.nodes().force;
    simulation.step(1e-4);
    double of_nodes = 0, of_particles = 0, size = 0;
    for (std::size_t i = 0; i < force.size(); ++i)
      of_nodes += force[i].dot(simulation.nodes().velocity[i]);
    for (std::size_t p = 0; p < volumes.size(); ++p) {
      const Matrix<D> flux = volumes[p] * problem.particles.stress[p];
      of_particles -= flux.cwiseProduct(simulation.particles().L[p]).sum();
      size += flux.norm() * simulation.particles().L[p].norm();
    }
    return std::abs(of_nodes - of_particles) / size;
  };
  for (const double lower : {0.0, 1.0 / 6}) {
    for (const char* name : {"sgmp", "impm_adjoint"})
      EXPECT_LE(mismatch(method_named(name), lower), 1e-13) << name;
    EXPECT_LE(
        mismatch(changed("sgmp", [](Method& m) { m.border = SplineBorder::extra_column; }), lower),
        1e-13);
    EXPECT_GE(mismatch(method_named("impm"), lower), 1e-3);
  }
}

// A linear stress is exact inside, for clouds that are not regular: f_i = div sigma h^D, as with
// impm. Without least squares the sum over particles is not.
TYPED_TEST(Quadratures, OfAdjointCellsAreExactInside) {
  constexpr int D = TypeParam::value;
  const auto error = [](const Method& method) {
    Problem<D> problem = cloud<D>(10, 0.1, 0.9, method, 2);
    const LinearStress<D> stress(true);
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      problem.particles.stress[p] = stress(problem.particles.x[p]);
    Simulation<D> simulation(problem);
    simulation.map();
    const double h = problem.grid.h();
    double most = 0;
    for (std::size_t i = 0; i < problem.grid.size(); ++i) {
      const Vector<D> x = problem.grid.position(i);
      if (x.minCoeff() > 0.1 + 1.5 * h && x.maxCoeff() < 0.9 - 1.5 * h)
        most = std::max(
            most, (simulation.nodes().force[i] / std::pow(h, D) - stress.divergence()).norm());
    }
    return most / (stress.constant.norm() / h);
  };
  EXPECT_LE(error(method_named("impm_adjoint")), 1e-12);
  EXPECT_GE(error(changed("impm_adjoint", [](Method& m) { m.quadrature = Quadrature::particles; })),
            1e-4);
}

// ---- velocity maps that carry slopes ----

template <class T>
class SlopeMaps : public testing::Test {};
TYPED_TEST_SUITE(SlopeMaps, AllDimensions);

// Particles that carry the slope of a linear field: nodes have the field, particles get it back, at
// the borders of the body as well (Wallstedt, Guilkey 2007; Jiang et al. 2015).
TYPED_TEST(SlopeMaps, KeepLinearFields) {
  constexpr int D = TypeParam::value;
  const LinearField<D> field;
  const auto check = [&](const Method& method) {
    Problem<D> problem = cloud<D>(6, 1.0 / 3, 5.0 / 6, method, 2);
    field.give(problem.particles);
    Simulation<D> simulation(problem);
    simulation.map();
    for (std::size_t i = 0; i < problem.grid.size(); ++i)
      if (simulation.nodes().mass[i] > 0) {
        EXPECT_LE((simulation.nodes().mapped[i] - field(problem.grid.position(i))).norm(), 1e-11)
            << method.name;
      }
    simulation.step(1e-4);
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      EXPECT_LE((simulation.particles().v[p] - problem.particles.v[p]).norm(), 1e-11)
          << method.name;
      EXPECT_LE((simulation.particles().L[p] - field.slope).norm(), 1e-10) << method.name;
    }
  };
  for (const char* name : {"improved_projection", "tpic", "apic", "mls_mpm", "polypic",
                           "affine_cpdi", "affine_cpdi2", "impm_adjoint"})
    check(method_named(name));
  for (const char* name : {"apic", "polypic", "tpic"})
    check(changed(name, [](Method& m) { m.basis = Basis::bspline3; }));
  for (const char* name : {"cpgimp", "cpdi1", "cpdi2", "q9"})
    if (D == 2 || std::string(name) != "q9")
      check(changed(name, [](Method& m) { m.velocity = VelocityMap::taylor; }));
}

// What apic carries is C = B_p D_p^-1, the slope of a linear field; its angular momentum is that of
// B = D_p C with D_p = h^2 / 4 on quadratic and h^2 / 3 on cubic splines.
TYPED_TEST(SlopeMaps, ApicCarriesTheSlope) {
  constexpr int D = TypeParam::value;
  const LinearField<D> field;
  for (const Basis basis : {Basis::bspline2, Basis::bspline3, Basis::mls_bspline2}) {
    Problem<D> problem =
        cloud<D>(6, 1.0 / 3, 2.0 / 3, changed("apic", [&](Method& m) { m.basis = basis; }), 2);
    field.give(problem.particles);
    Simulation<D> simulation(problem);
    simulation.map();
    const double moment = (basis == Basis::bspline3 ? 1.0 / 3 : 1.0 / 4) / 36;
    double spin = 0;
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      const auto& at = simulation.particles();
      spin += at.mass[p] * moment * (D == 1 ? 0 : field.slope(D - 1, 0) - field.slope(0, D - 1));
      if (D == 2) spin += at.mass[p] * (at.x[p][0] * at.v[p][D - 1] - at.x[p][D - 1] * at.v[p][0]);
    }
    if (D == 2) {
      EXPECT_NEAR(account(simulation).angular[2], spin, 1e-12) << name_of(basis);
    }
    simulation.step(1e-4);
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      for (int d = 0; d < D; ++d) {
        const Vector<D>& c = simulation.particles().modes[p * D + static_cast<std::size_t>(d)];
        EXPECT_LE((c - field.slope.col(d)).norm(), 1e-11) << name_of(basis);
      }
  }
}

// Random velocities and slopes: the nodes have the momentum of the particles, for what the slopes
// add vanishes in the sum over nodes: sum_i S_ip (x_i - x_p) = 0.
TYPED_TEST(SlopeMaps, KeepMomentum) {
  constexpr int D = TypeParam::value;
  for (const char* name : {"improved_projection", "tpic", "apic", "mls_mpm", "polypic",
                           "affine_cpdi", "affine_cpdi2", "sgmp", "impm_adjoint"}) {
    Problem<D> problem = cloud<D>(6, 0, 1, method_named(name), 2);
    std::mt19937 random(41);
    for (auto& L : problem.particles.L)
      for (int d = 0; d < D; ++d) L.col(d) = random_vector<D>(random, 10);
    Simulation<D> simulation(problem);
    simulation.map();
    const Ledger ledger = account(simulation);
    EXPECT_LE(distance(ledger.momentum, ledger.node_momentum), rounding_of_maps * ledger.mass)
        << name;
  }
}

// Two blocks collide and turn, inside the grid.
template <int D>
Problem<D> turning(const Method& method) {
  Problem<D> problem = block<D>(10, 0.2, 0.4, "mpm", 2);
  const Problem<D> other = block<D>(10, 0.5, 0.7, "mpm", 2);
  problem.method = method;
  const LinearField<D> field;
  field.give(problem.particles);
  for (std::size_t p = 0; p < other.particles.size(); ++p) {
    problem.particles.add(other.particles.X[p], other.particles.half_edges[p], 1000, 0);
    problem.particles.v.back().setConstant(-1);
  }
  for (std::size_t p = 0; p < problem.particles.size(); ++p) {
    problem.particles.v[p] *= 0.3;
    problem.particles.L[p] *= 0.3;
    problem.particles.v[p][0] += 0.2;
  }
  return problem;
}

template <class T>
class Turning : public testing::Test {};
using PlaneAndSpace = testing::Types<Dimension<2>, Dimension<3>>;
TYPED_TEST_SUITE(Turning, PlaneAndSpace);

// Jiang et al. 2015: with the affine part, sum m (x cross v + B), angular momentum is conserved
// from particles to nodes, by nodes, and back; without it PIC loses it. PolyPIC has the same linear
// part. Nodes lighter than 1e-10 of the heaviest feel no force, which is accounted for.
TYPED_TEST(Turning, ApicConservesAngularMomentum) {
  constexpr int D = TypeParam::value;
  const auto worst = [](const Method& method, bool& collided) {
    Simulation<D> simulation(turning<D>(method));
    simulation.map();
    const Ledger start = account(simulation);
    const double size = start.mass * 0.3;
    double drift = 0, unfelt = 0;
    Ledger due = start;  // less the impulse of forces that too light nodes do not feel
    for (int s = 0; s < 80; ++s) {
      const double kick = s == 0 ? 0.005 : 0.01;
      const Nodes<D>& nodes = simulation.nodes();
      const double lightest = 1e-10 * *std::max_element(nodes.mass.begin(), nodes.mass.end());
      for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
        if (nodes.mass[i] > lightest) continue;
        const Vector<D> x = simulation.problem().grid.position(i), lost = kick * nodes.force[i];
        unfelt = std::max(unfelt, lost.norm());
        for (int d = 0; d < D; ++d) due.momentum[d] -= lost[d];
        due.angular[2] -= x[0] * lost[1] - x[1] * lost[0];
        if (D == 3) {
          due.angular[0] -= x[1] * lost[D - 1] - x[D - 1] * lost[1];
          due.angular[1] -= x[D - 1] * lost[0] - x[0] * lost[D - 1];
        }
      }
      simulation.step(0.01);
      simulation.map();
      const Ledger now = account(simulation);
      EXPECT_LE(distance(now.momentum, due.momentum), 1e-12 * size) << method.name;
      EXPECT_LE(distance(now.momentum, now.node_momentum), 1e-12 * size) << method.name;
      if (method.velocity != VelocityMap::mass_weighted) {
        EXPECT_LE(distance(now.angular, now.node_angular), 1e-12 * size) << method.name;
      }
      drift = std::max(drift, distance(now.angular, due.angular) / size);
    }
    EXPECT_LE(unfelt, 1e-8 * size) << method.name;
    // The first block was slowed down along the diagonal by the second.
    collided = largest<D>({simulation.particles().v[0] - turning<D>(method).particles.v[0]}) > 0.05;
    return drift;
  };
  bool collided = false;
  for (const char* name : {"apic", "mls_mpm", "polypic"}) {
    EXPECT_LE(worst(method_named(name), collided), 1e-12) << name;
    EXPECT_TRUE(collided) << name;
  }
  EXPECT_LE(worst(changed("apic", [](Method& m) { m.basis = Basis::bspline3; }), collided), 1e-12);
  const Method pic = changed("apic", [](Method& m) { m.velocity = VelocityMap::mass_weighted; });
  EXPECT_GE(worst(pic, collided), 1e-3);
}

// Affine velocities over domains: all angular momentum of the particles is on the nodes, in every
// step, and what is lost from one step to the next is less than a quarter of what the same part of
// PIC takes without the affine field. The wide functions through the cells have D = h^2 / 2
// everywhere inside, and keep all of it with PIC.
TYPED_TEST(Turning, AffineDomainsBringTheirAngularMomentum) {
  constexpr int D = TypeParam::value;
  const auto drift = [](const Method& method) {
    Problem<D> problem = turning<D>(method);
    for (std::size_t p = 0; p < problem.particles.size(); ++p) {
      const Vector<D> x = problem.particles.x[p];
      Matrix<D> spin = Matrix<D>::Zero();
      spin(0, 1) = -1;
      spin(1, 0) = 1;
      problem.particles.v[p] = 0.3 * spin * (x - Vector<D>::Constant(0.45));
      problem.particles.L[p] = 0.3 * spin;
    }
    Simulation<D> simulation(problem);
    simulation.map();
    const Ledger start = account(simulation);
    double most = 0;
    for (int s = 0; s < 60; ++s) {
      simulation.step(0.01);
      simulation.map();
      const Ledger now = account(simulation);
      EXPECT_LE(distance(now.angular, now.node_angular), 1e-12 * start.mass) << method.name;
      most = std::max(most, distance(now.angular, start.angular));
    }
    return most / distance(start.angular, {});
  };
  const double plain =
      drift(changed("affine_cpdi", [](Method& m) { m.velocity = VelocityMap::mass_weighted; }));
  for (const char* name : {"affine_cpdi", "affine_cpdi2"})
    EXPECT_LE(drift(method_named(name)), 0.25 * plain) << name;
  EXPECT_LE(drift(changed("impm_adjoint", [](Method& m) { m.update = Update::pic; })), 1e-9);
}

// MLS-MPM: F moves with the affine part itself, L = C_p = (4 / h^2) B_p; and a constant stress
// has no force inside.
TYPED_TEST(SlopeMaps, MlsMpmStrainsByTheAffinePart) {
  constexpr int D = TypeParam::value;
  Problem<D> problem = cloud<D>(8, 0.25, 0.75, method_named("mls_mpm"), 2);
  Simulation<D> simulation(problem);
  simulation.step(1e-4);
  for (std::size_t p = 0; p < problem.particles.size(); ++p)
    for (int d = 0; d < D; ++d) {
      const Vector<D>& slope = simulation.particles().modes[p * D + static_cast<std::size_t>(d)];
      EXPECT_LE((simulation.particles().L[p].col(d) - slope).norm(), 1e-11);
    }
  problem = block<D>(8, 0.25, 0.75, "mls_mpm", 2);
  const LinearStress<D> stress(false);
  for (auto& each : problem.particles.stress) each = stress.constant;
  Simulation<D> pressed(problem);
  pressed.map();
  double inside = 0;
  for (std::size_t i = 0; i < problem.grid.size(); ++i) {
    const Vector<D> x = problem.grid.position(i);
    if (x.minCoeff() > 0.25 + 0.15 && x.maxCoeff() < 0.75 - 0.15)
      inside = std::max(inside, pressed.nodes().force[i].norm());
  }
  const double all = largest<D>(pressed.nodes().force);
  EXPECT_GT(all, 0);
  EXPECT_LE(inside, 1e-12 * all);
}

// ---- PolyPIC (Fu et al. 2017) ----

// On an axis 1, delta, delta^2 - kappa delta - h^2 / 4 with delta = x_i - x_p,
// kappa = z (h^2 - 4 z^2) / h^2, z = x_p less the nearest node: a particle alone may have any such
// field, and the nodes have its values. Coefficients of the products come back from the nodes:
// sum w v; (4 / h^2) sum w delta v; (v- - 2 v0 + v+) / (2 h^2).
TYPED_TEST(SlopeMaps, PolypicHasTheClosedForms) {
  constexpr int D = TypeParam::value;
  constexpr int modes = D == 1 ? 3 : D == 2 ? 9 : 27;
  std::mt19937 random(42);
  for (int round = 0; round < 20; ++round) {
    Problem<D> problem = block<D>(6, 0.5, 0.5 + 1.0 / 6, "polypic", 1);
    const double h = problem.grid.h();
    Particles<D>& particles = problem.particles;
    ASSERT_EQ(particles.size(), 1u);
    for (int d = 0; d < D; ++d) particles.x[0][d] = uniform(random, 0.3, 0.7);
    particles.v[0] = random_vector<D>(random);
    std::vector<Vector<D>> coefficient{particles.v[0]};
    for (int r = 1; r < modes; ++r) {
      double size = 1;
      for (int d = 0, rest = r; d < D; ++d, rest /= 3) size *= std::pow(h, rest % 3);
      coefficient.push_back(random_vector<D>(random) / size);
      particles.modes.push_back(coefficient.back());
    }
    const Vector<D> x = particles.x[0];
    const auto at_node = [&](const Vector<D>& node) {
      Vector<D> v = Vector<D>::Zero();
      for (int r = 0; r < modes; ++r) {
        double value = 1;
        for (int d = 0, rest = r; d < D; ++d, rest /= 3) {
          const double delta = node[d] - x[d], z = x[d] - std::round(x[d] / h) * h;
          const double kappa = z * (h * h - 4 * z * z) / (h * h);
          if (rest % 3 == 1) value *= delta;
          if (rest % 3 == 2) value *= delta * delta - kappa * delta - h * h / 4;
        }
        v += value * coefficient[static_cast<std::size_t>(r)];
      }
      return v;
    };
    Simulation<D> simulation(problem);
    simulation.map();
    const Nodes<D>& nodes = simulation.nodes();
    int touched = 0;
    for (std::size_t i = 0; i < problem.grid.size(); ++i) {
      if (nodes.mass[i] == 0) continue;
      ++touched;
      const Vector<D> exact = at_node(problem.grid.position(i));
      EXPECT_LE((nodes.mapped[i] - exact).norm(), 1e-11 * (1 + exact.norm()));
    }
    EXPECT_EQ(touched, modes);
    // And back: nothing is lost for any values at its 3^D nodes.
    simulation.step(1e-9);
    EXPECT_LE((simulation.particles().v[0] - particles.v[0]).norm(), 1e-11);
    for (std::size_t r = 0; r + 1 < modes; ++r)
      EXPECT_LE((simulation.particles().modes[r] - particles.modes[r]).norm(),
                1e-10 * (1 + particles.modes[r].norm()));
  }
}

// What a particle holds, sum_r norm_r c_r^2 m / 2, is the energy of its nodes under its functions,
// so nodes lose nothing to particles; maps are exact and only the mean on the nodes loses. APIC is
// lossless for affine fields only. Measured by the energy of nodes that are mapped twice.
TEST(Polypic, LosesNothingOfAParticleAlone) {
  const auto kept = [](const char* name, bool affine) {
    Problem<2> problem = block<2>(8, 0.25, 0.5, name, 2);
    std::mt19937 random(43);
    const LinearField<2> field;
    for (std::size_t p = 0; p < problem.particles.size(); ++p)
      problem.particles.v[p] = random_vector<2>(random);
    if (affine) field.give(problem.particles);
    // A map to the nodes by all particles; then one particle alone takes it from there.
    Problem<2> alone = problem;
    Simulation<2> all(problem);
    all.step(1e-9);
    const std::size_t p = 12, count = all.particles().modes.size() / all.particles().size();
    alone.particles = {};
    alone.particles.add(problem.particles.x[p], problem.particles.half_edges[p], 1000, 0);
    alone.particles.v[0] = all.particles().v[p];
    const auto first = all.particles().modes.begin() + static_cast<std::ptrdiff_t>(p * count);
    alone.particles.modes.assign(first, first + static_cast<std::ptrdiff_t>(count));
    Simulation<2> again(alone);
    again.map();
    double worst = 0;
    for (std::size_t i = 0; i < problem.grid.size(); ++i)
      if (again.nodes().mass[i] > 0)
        worst = std::max(worst, (again.nodes().mapped[i] - all.nodes().mapped[i]).norm());
    return worst;
  };
  EXPECT_LE(kept("polypic", false), 1e-11);
  EXPECT_LE(kept("polypic", true), 1e-11);
  EXPECT_GE(kept("apic", false), 1e-2);
  EXPECT_LE(kept("apic", true), 1e-11);
}

// A cloud without stress that drifts over many cells: energy of the nodes falls, never grows. (The
// moment of the quadratic mode, kept instead of its coefficient, makes it grow sevenfold.)
TEST(Polypic, DriftMakesNoEnergy) {
  Problem<2> problem = block<2>(10, 0.2, 0.5, "polypic", 2);
  problem.materials = {NeoHookean{Lame::from(1e-9, 0.3)}};
  std::mt19937 random(44);
  for (auto& v : problem.particles.v) v = Vector<2>(0.3, 0.17) + random_vector<2>(random, 0.1);
  Simulation<2> simulation(problem);
  simulation.map();
  const double start = account(simulation).node_kinetic;
  for (int s = 0; s < 150; ++s) {
    simulation.step(0.01);
    simulation.map();
    EXPECT_LE(account(simulation).node_kinetic, start * 1.001);
  }
}

// ---- updates: PIC, XPIC, FMPM ----

// Order 1 of both is PIC, bit for bit.
TEST(Filters, OfOrderOneArePic) {
  std::vector<std::vector<Vector<2>>> results;
  for (const Update update : {Update::pic, Update::xpic, Update::fmpm}) {
    Problem<2> problem = turning<2>(changed("xpic", [&](Method& m) {
      m.update = update;
      m.order = 1;
    }));
    problem.boundaries = {{0, 0, {0.0, 0.0}}};
    Simulation<2> simulation(problem);
    for (int s = 0; s < 30; ++s) simulation.step(0.01);
    results.push_back(simulation.particles().x);
    results.push_back(simulation.particles().v);
  }
  for (std::size_t i = 2; i < results.size(); ++i)
    EXPECT_EQ(0, std::memcmp(results[i].data(), results[i % 2].data(),
                             results[i].size() * sizeof(Vector<2>)));
}

// sum_{j < m} (1 - S+ S)^j is the Neumann series of the consistent mass: e_m = |v*_m - M^-1 p| in
// the norm of the lumped mass falls by at most the largest eigenvalue of 1 - M_L^-1 M, and each
// step by less than the one before (Nairn, Hammerquist 2021).
TYPED_TEST(SlopeMaps, FmpmTendsToTheConsistentMass) {
  constexpr int D = TypeParam::value;
  const auto make = [](int order) {
    return cloud<D>(D == 3 ? 2 : 4, 0, 1, changed("fmpm", [&](Method& m) {
                      m.domain = Domain::point;
                      m.order = order;
                    }));
  };
  Problem<D> problem = make(1);
  const Eigen::MatrixXd S = shape_matrix(problem);
  const Eigen::VectorXd masses = column(problem.particles.mass);
  const Eigen::MatrixXd M = S.transpose() * masses.asDiagonal() * S;
  const Eigen::VectorXd lumped = M.rowwise().sum();
  const Eigen::VectorXd root = lumped.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = root.asDiagonal() * M * root.asDiagonal();
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled).eigenvalues()[0];
  problem.method = with(Basis::linear, MassMatrix::consistent);
  Simulation<D> consistent(problem);
  consistent.map();
  const Eigen::MatrixXd exact = rows<D>(consistent.nodes().mapped);
  const auto error = [&](int order) {
    Simulation<D> simulation(make(order));
    simulation.step(1e-9);
    const Eigen::MatrixXd difference = rows<D>(simulation.nodes().velocity) - exact;
    return (lumped.cwiseSqrt().asDiagonal() * difference).norm();
  };
  double before = error(1), last_ratio = 0;
  EXPECT_GE(before, 0.1);
  for (int order = 2; order <= 20; ++order) {
    const double now = error(order), ratio = now / before;
    EXPECT_LE(ratio, (1 - least) * (1 + 1e-9)) << order;
    EXPECT_GE(ratio, last_ratio * (1 - 1e-9)) << order;
    before = now;
    last_ratio = ratio;
  }
  EXPECT_LE(error(400), std::pow(1 - least, 399) * error(1) + 1e-10);
  EXPECT_GT(least, 0.01);
}

// A field of the functions of the grid comes back unchanged as m grows, for both; PIC smooths it.
TEST(Filters, KeepFieldsOfTheGrid) {
  for (const char* name : {"xpic", "fmpm"})
    for (const Basis basis : {Basis::linear, Basis::bspline2}) {
      const auto error = [&](int order) {
        Problem<2> problem = cloud<2>(4, 0, 1, changed(name, [&](Method& m) {
                                        m.domain = Domain::point;
                                        m.basis = basis;
                                        m.order = order;
                                      }));
        std::mt19937 random(45);
        std::vector<Vector<2>> values(problem.grid.size());
        for (auto& value : values) value = random_vector<2>(random);
        give_rows<2>(shape_matrix(problem) * rows<2>(values), problem.particles.v);
        Simulation<2> simulation(problem);
        simulation.step(1e-9);
        return (rows<2>(simulation.particles().v) - rows<2>(problem.particles.v)).norm();
      };
      EXPECT_GE(error(1), 1) << name;
      EXPECT_LE(error(4), error(2)) << name;
      EXPECT_LE(error(1000), 1e-5) << name << " " << name_of(basis);
    }
}

// ---- high-order PIC (Edwards, Bridson 2012) ----

// Least squares of degree 3: cubic fields are on the nodes what they are on the particles.
TYPED_TEST(SlopeMaps, HopicKeepsCubics) {
  constexpr int D = TypeParam::value;
  Problem<D> problem = cloud<D>(4, 0, 1, method_named("hopic"), 3);
  const LinearField<D> a(51), b(52), c(53);
  const auto field = [&](const Vector<D>& x) {
    return Vector<D>(a(x).array() * b(x).array() * c(x).array());
  };
  for (std::size_t p = 0; p < problem.particles.size(); ++p)
    problem.particles.v[p] = field(problem.particles.x[p]);
  Simulation<D> simulation(problem);
  simulation.map();
  const Nodes<D>& nodes = simulation.nodes();
  ASSERT_EQ(nodes.fit.size(), problem.grid.size());
  for (std::size_t i = 0; i < problem.grid.size(); ++i) {
    ASSERT_EQ(nodes.fit_nodes[i], i);
    ASSERT_EQ(nodes.fit[i].degree, 3);
    EXPECT_LE((nodes.mapped[i] - field(problem.grid.position(i))).norm(), 1e-10);
  }
}

// The order of the step, from the differences of halved steps on one grid; particles stay between
// the knots of all functions. FLIP is of first order in this sense: velocities of t + dt / 2 are
// taken at the places of t, so what the map smooths is smoothed elsewhere.
TEST(RungeKutta, IsOfFourthOrder) {
  const auto order = [](Update update) {
    std::vector<Eigen::MatrixXd> results;
    for (const int steps : {32, 64, 128}) {
      Problem<1> problem = block<1>(8, 0, 1, "hopic", 3);
      problem.method.update = update;
      for (std::size_t p = 0; p < problem.particles.size(); ++p)
        problem.particles.v[p][0] = 0.02 * std::sin(3 * problem.particles.x[p][0] + 0.3);
      problem.boundaries = {{0, 0, {0.0}}, {0, 1, {0.0}}};
      Simulation<1> simulation(problem);
      for (int s = 0; s < steps; ++s) simulation.step(0.5 / steps);
      results.push_back(rows<1>(simulation.particles().x));
    }
    return std::log2((results[0] - results[1]).norm() / (results[1] - results[2]).norm());
  };
  EXPECT_NEAR(order(Update::runge_kutta), 4, 0.1);
  EXPECT_NEAR(order(Update::flip), 1, 0.1);
}

// ---- all of them ----

// Whatever goes together keeps a constant velocity, without strain.
TEST(Methods, EveryCombinationKeepsAConstantVelocity) {
  using enum Quadrature;
  using enum VelocityMap;
  int accepted = 0;
  Method method;
  std::vector<Basis> all = bases<2>();
  all.insert(all.end(), {Basis::cell_linear, Basis::cell_bspline2});
  for (const Domain domain :
       {Domain::point, Domain::ugimp, Domain::cpgimp, Domain::cpdi1, Domain::cpdi2})
    for (const Basis basis : all)
      for (const VelocityMap map : {mass_weighted, mls, imls, cpls, taylor, affine, polynomial})
        for (const Quadrature quadrature :
             {particles, cells, nodal_cells, taylor_cells, gauss_cells, adjoint_cells})
          for (const Update update :
               {Update::flip, Update::pic, Update::xpic, Update::fmpm, Update::runge_kutta})
            for (const MassMatrix mass : {MassMatrix::lumped, MassMatrix::consistent}) {
              method.domain = domain;
              method.basis = basis;
              method.velocity = map;
              method.quadrature = quadrature;
              method.update = update;
              method.mass = mass;
              if (!blamed([&] { method.validate(2); }).empty()) continue;
              ++accepted;
              const double lower = mass == MassMatrix::lumped ? 0.25 : 0;
              Problem<2> problem = cloud<2>(4, lower, 1 - lower, method);
              for (auto& v : problem.particles.v) v << 0.03, -0.02;
              Simulation<2> simulation(problem);
              for (int s = 0; s < 3; ++s) simulation.step(1e-3);
              double error = 0;
              for (std::size_t p = 0; p < problem.particles.size(); ++p)
                error =
                    std::max({error, (simulation.particles().v[p] - problem.particles.v[p]).norm(),
                              simulation.particles().L[p].norm()});
              EXPECT_LE(error, 1e-10)
                  << name_of(domain) << " " << name_of(basis) << " " << name_of(map) << " "
                  << name_of(quadrature) << " " << name_of(update) << " " << name_of(mass);
            }
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace recon::mpm::test
