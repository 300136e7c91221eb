// The maps between particles and nodes, quadratures and updates: the identities that define them.
#include <Eigen/Dense>
#include <cmath>
#include <cstring>

#include "mpm/support.hpp"
#include "recon/mpm/ledger.hpp"

namespace recon::mpm::test {
namespace {

constexpr double rounding = 1e-12;

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
    ShapeFunctions<D> shape;
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
    EXPECT_LE((Eigen::MatrixXd(nodes.mass_matrix) - M).norm(), rounding * M.norm());
    const Eigen::VectorXd lumped = M.rowwise().sum();
    EXPECT_LE((lumped - column(nodes.mass)).norm(), rounding * M.norm()) << name_of(basis);
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
        EXPECT_NEAR(lost, 0, rounding) << name_of(basis);
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
    simulation.advance(1e-3);
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
      EXPECT_LE((at - Vector<2>(0.625, 0.625)).cwiseAbs().maxCoeff(), 0.125 + rounding) << what;
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
           {"bspline2", "point particles"});
  for (const Quadrature quadrature : {Quadrature::cells, Quadrature::nodal_cells})
    expect(why([&](Method& m) {
             m.quadrature = quadrature;
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
             {name, "linear or spline basis"});
    expect(why([&](Method& m) {
             m.quadrature = quadrature;
             m.domain = Domain::cpdi1;
           }),
           {name, "point particles"});
    expect(why([&](Method& m) {
             m.quadrature = quadrature;
             m.velocity = VelocityMap::mls;
           }),
           {"mls", "momentum"});
  }
  for (const VelocityMap map : {VelocityMap::affine, VelocityMap::polynomial}) {
    const std::string name(name_of(map));
    expect(why([&](Method& m) {
             m.velocity = map;
             m.update = Update::pic;
             m.domain = Domain::ugimp;
           }),
           {name, "point particles"});
    expect(why([&](Method& m) {
             m.velocity = map;
             m.update = Update::pic;
             m.basis = Basis::q9;
           }),
           {name, "positive"});
    expect(why([&](Method& m) { m.velocity = map; }), {"flip", "remember", "pic"});
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
  for (const Method& method : methods()) EXPECT_NO_THROW(method.validate(2)) << method.name;
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
  strict.method.stop_at_negative_mass = true;
  Simulation<2> stopped(strict);
  try {
    stopped.map();
    FAIL() << "it must stop";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.step(), 0);
    EXPECT_EQ(failure.number(), found.node);
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
      simulation.advance(0.05);
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
      EXPECT_NEAR(ledger.node_mass, ledger.mass, rounding * ledger.mass);
      EXPECT_LE(distance(ledger.node_momentum, ledger.momentum), rounding * ledger.mass);
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
    Particles<D> point;
    Vector<D> x;
    for (int d = 0; d < D; ++d)
      x[d] = 0.375 + (g >> d & 1) * h + (g >> (D + d) & 1 ? offset : -offset);
    point.add(x, Matrix<D>::Identity(), 1, 0);
    ShapeFunctions<D> shape;
    PointDomain{}.shape(problem.grid, point, 0, shape);
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
    Particles<D> point;
    point.add(x, Matrix<D>::Identity(), 1, 0);
    ShapeFunctions<D> shape;
    BSpline<3>{}.shape(problem.grid, point, 0, shape);
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

}  // namespace
}  // namespace recon::mpm::test
