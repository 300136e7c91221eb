// A state in several parts, each with a step of its own, moves as the whole does.
#include <barrier>
#include <cmath>
#include <thread>

#include "mpm/support.hpp"
#include "recon/runs/compose.hpp"
#include "recon/runs/ledger.hpp"

namespace recon::mpm::test {
namespace {

// Parts in the threads of one program, which wait for each other wherever they ask.
template <int D>
class Together {
 public:
  Together(const Problem<D>& of, int parts)
      : problem(of), ask(parts), states(parts), lists(parts), numbers(parts) {}

  // What all parts do, each with its number.
  template <class Work>
  void run(const Work& work) {
    std::vector<std::thread> threads;
    for (std::size_t r = 0; r < states.size(); ++r) threads.emplace_back([&, r] { work(r); });
    for (std::thread& thread : threads) thread.join();
  }

  struct Copy {
    std::size_t part, particle;
  };
  const Problem<D>& problem;
  std::barrier<> ask;
  std::vector<const State<D>*> states;
  std::vector<std::span<double>> lists;
  std::vector<double> numbers;
  std::vector<const std::vector<Vector<D>>*> vectors{states.size()};
  std::vector<std::vector<std::size_t>> ids{states.size()};  // of the own particles
};

template <int D>
class OnePart : public OtherParts<D> {
 public:
  OnePart(Together<D>& all, std::size_t part) : all_(all), part_(part) {}

  void copy_to(State<D>& s) override {
    const Kept kept = all_.problem.kept();
    all_.states[part_] = &s;
    const std::size_t own = s.own();
    all_.ask.arrive_and_wait();
    if (s.others == 0) choose(own);
    Particles<D> copies;
    for (const auto& [part, particle] : copies_)
      append(chosen(all_.states[part]->particles, kept, std::array{particle}), kept, copies);
    all_.ask.arrive_and_wait();  // before anybody's particles are changed
    keep_first(own, kept, s.particles);
    append(copies, kept, s.particles);
    s.others = copies.size();
    all_.ask.arrive_and_wait();
  }
  void copy_to(const State<D>& s, std::vector<Vector<D>>& of_particles) override {
    all_.vectors[part_] = &of_particles;
    all_.ask.arrive_and_wait();
    for (std::size_t i = 0; i < copies_.size(); ++i)
      of_particles[s.own() + i] = (*all_.vectors[copies_[i].part])[copies_[i].particle];
    all_.ask.arrive_and_wait();
  }
  void sum(std::span<double> numbers) override {
    all_.lists[part_] = numbers;
    all_.ask.arrive_and_wait();
    std::vector<double> sums(numbers.size());
    for (const auto& each : all_.lists)
      for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += each[i];
    all_.ask.arrive_and_wait();
    std::copy(sums.begin(), sums.end(), numbers.begin());
  }
  double largest(double number) override {
    all_.numbers[part_] = number;
    all_.ask.arrive_and_wait();
    const double most = *std::max_element(all_.numbers.begin(), all_.numbers.end());
    all_.ask.arrive_and_wait();
    return most;
  }
  std::optional<std::size_t> place_of(std::size_t number) const override {
    const auto& own = all_.ids[part_];
    for (std::size_t i = 0; i < own.size(); ++i)
      if (own[i] == number) return i;
    for (std::size_t i = 0; i < copies_.size(); ++i)
      if (all_.ids[copies_[i].part][copies_[i].particle] == number) return own.size() + i;
    return {};
  }
  std::size_t copies() const { return copies_.size(); }

 private:
  // Those within reach of any own particle, along all axes, and of its next periods.
  void choose(std::size_t own) {
    const Particles<D>& mine = all_.states[part_]->particles;
    double widest = 0;
    for (const State<D>* s : all_.states)
      widest = std::max(widest, half_width(all_.problem, s->particles));
    const double reach = reach_of_copies(all_.problem, widest);
    copies_.clear();
    const auto near = [&](const Vector<D>& x) {
      for (std::size_t p = 0; p < own; ++p) {
        bool within = true;
        for (int d = 0; d < D; ++d) {
          double apart = std::abs(x[d] - mine.x[p][d]);
          const auto [from, to] = all_.problem.room(d);
          if (all_.problem.periodic[d]) apart = std::min(apart, to - from - apart);
          within = within && apart <= reach;
        }
        if (within) return true;
      }
      return false;
    };
    for (std::size_t r = 0; r < all_.states.size(); ++r)
      for (std::size_t p = 0; r != part_ && p < all_.ids[r].size(); ++p)
        if (near(all_.states[r]->particles.x[p])) copies_.push_back({r, p});
  }

  Together<D>& all_;
  std::size_t part_;
  std::vector<typename Together<D>::Copy> copies_;
};

template <class T>
double size_of(const T& x) {
  if constexpr (std::is_arithmetic_v<T>)
    return std::abs(static_cast<double>(x));
  else
    return x.norm();
}
template <class T, std::size_t N>
double size_of(const std::array<T, N>& x) {
  double most = 0;
  for (const T& each : x) most = std::max(most, size_of(each));
  return most;
}
template <class T>
T difference(const T& a, const T& b) {
  return a - b;
}
template <class T, std::size_t N>
std::array<T, N> difference(const std::array<T, N>& a, const std::array<T, N>& b) {
  std::array<T, N> out;
  for (std::size_t i = 0; i < N; ++i) out[i] = a[i] - b[i];
  return out;
}

// The whole and its parts after some steps: all that particles carry, to rounding, and the ledger.
// part_of(X) is the number of the part of a particle.
template <int D, class PartOf>
void expect_parts_move_as_the_whole(const Problem<D>& problem, int parts, const PartOf& part_of,
                                    double dt, int steps, bool copies_are_fewer = false) {
  const std::string& name = problem.method.name;
  State<D> whole = start(problem);
  Step<D> step(problem);
  Together<D> all(problem, parts);
  const Kept kept = problem.kept();
  std::vector<State<D>> states(all.states.size());
  for (std::size_t p = 0; p < whole.particles.size(); ++p)
    all.ids[static_cast<std::size_t>(part_of(whole.particles.X[p]))].push_back(p);
  for (std::size_t r = 0; r < states.size(); ++r) {
    states[r].particles = chosen(whole.particles, kept, all.ids[r]);
    ASSERT_FALSE(all.ids[r].empty());
  }
  for (int i = 0; i < steps; ++i) step(whole, dt);
  step.to_nodes(whole);
  std::vector<Ledger> sums(states.size());
  std::vector<double> power(states.size());
  std::vector<std::string> failed(states.size());
  all.run([&](std::size_t r) {
    try {
      OnePart<D> part(all, r);
      Step<D> mine(problem, states[r].own(), &part);
      for (int i = 0; i < steps; ++i) {
        mine(states[r], dt);
        if (copies_are_fewer) {
          EXPECT_GT(states[r].others, 0u) << name;
          EXPECT_LT(states[r].others, problem.particles.size() - states[r].own()) << name;
        }
        keep_first(states[r].own(), kept, states[r].particles);
        states[r].others = 0;
      }
      mine.to_nodes(states[r]);
      sums[r] = sums_of(states[r], mine);
      power[r] = external_forces(states[r], mine).power;
    } catch (const std::exception& e) {
      failed[r] = e.what();
      all.ask.arrive_and_drop();
    }
  });
  for (const std::string& text : failed) ASSERT_EQ(text, "") << name;
  for (std::size_t r = 0; r < states.size(); ++r) {
    const Particles<D> of_whole = chosen(whole.particles, kept, all.ids[r]);
    keep_first(states[r].own(), kept, states[r].particles);
    of_whole.arrays(kept, [&](const ParticleArray& array, const auto& values) {
      states[r].particles.arrays(kept, [&](const ParticleArray& other, const auto& of_part) {
        if constexpr (std::is_same_v<std::decay_t<decltype(values)>,
                                     std::decay_t<decltype(of_part)>>) {
          if (std::string(array.name) != other.name) return;
          ASSERT_EQ(values.size(), of_part.size()) << name << array.name;
          double largest = 0, off = 0;
          for (std::size_t i = 0; i < values.size(); ++i) {
            largest = std::max(largest, size_of(values[i]));
            off = std::max(off, size_of(difference(values[i], of_part[i])));
          }
          EXPECT_LE(off, 1e-12 * largest) << name << " " << array.name << " of part " << r;
        }
      });
    });
  }
  const Ledger one = sums_of(whole, step);
  Ledger sum;
  double mass = 0, node_mass = 0, kinetic = 0, node_kinetic = 0, strain = 0, works = 0;
  for (std::size_t r = 0; r < sums.size(); ++r) {
    mass += sums[r].mass;
    node_mass += sums[r].node_mass;
    kinetic += sums[r].kinetic;
    node_kinetic += sums[r].node_kinetic;
    strain += sums[r].strain;
    works += sums[r].power + power[r];
    for (int d = 0; d < D; ++d) sum.node_momentum[d] += sums[r].node_momentum[d];
  }
  EXPECT_NEAR(mass, one.mass, 1e-12 * one.mass) << name;
  EXPECT_NEAR(node_mass, one.node_mass, 1e-12 * one.mass) << name;
  EXPECT_NEAR(kinetic, one.kinetic, 1e-12 * one.kinetic) << name;
  EXPECT_NEAR(node_kinetic, one.node_kinetic, 1e-12 * one.kinetic) << name;
  EXPECT_NEAR(strain, one.strain, 1e-11 * (one.strain + one.kinetic)) << name;
  const double speed = std::sqrt(2 * one.mass * one.kinetic);
  EXPECT_LE(distance(sum.node_momentum, one.node_momentum), 1e-12 * speed) << name;
  const double acting = one.power + external_forces(whole, step).power;
  EXPECT_NEAR(works, acting, 1e-11 * (std::abs(acting) + one.kinetic)) << name;
}

// A body that moves and strains everywhere otherwise, on a grid with room at both ends or, along the
// first axis, periodic.
template <int D>
Problem<D> lively(const Method& method, int cells, bool periodic) {
  Problem<D> problem;
  constexpr double h = 0.1;
  Vector<D> upper = Vector<D>::Constant(10 * h);
  upper[0] = (periodic ? cells : cells + 6) * h;
  std::array<bool, D> repeats{};
  repeats[0] = periodic;
  problem.grid = periodic_grid<D>(Vector<D>::Zero(), upper, h, repeats);
  problem.periodic = repeats;
  problem.materials = {NeoHookean{Lame::from(1000, 0.3)}};
  problem.densities = {1000};
  problem.method = method;
  const double begins = periodic ? 0 : 3 * h;
  std::array<int, 3> counts{2 * cells, D > 1 ? 8 : 1, D > 2 ? 8 : 1};
  for (int i = 0; i < counts[0] * counts[1] * counts[2]; ++i) {
    Vector<D> X;
    std::array<int, 3> at{i % counts[0], i / counts[0] % counts[1], i / counts[0] / counts[1]};
    for (int d = 0; d < D; ++d)
      X[d] = (d == 0 ? begins : 3 * h) + (at[static_cast<std::size_t>(d)] + 0.5) * h / 2;
    problem.particles.add(X, Matrix<D>::Identity() * (h / 4), 1000, 0);
    const double phase = 2 * M_PI * X[0] / (cells * h);
    Vector<D>& v = problem.particles.v.back();
    for (int d = 0; d < D; ++d)
      v[d] = 0.1 * std::sin(1 + 2 * d + phase) + 0.05 * std::cos(3 * phase + 2 * X[D - 1]);
    if (periodic) v[0] += 1;  // so that some change their end
  }
  problem.gravity[D - 1] = -1;
  return problem;
}

bool goes_in_parts(const Method& method, int dimension) {
  return method.mass == MassMatrix::lumped && (dimension == 2 || method.basis != Basis::q8);
}

template <int D>
void expect_halves(bool periodic) {
  for (const Method& method : methods()) {
    if (!goes_in_parts(method, D) || (periodic && method.basis == Basis::q8)) continue;
    const Problem<D> problem = lively<D>(method, 24, periodic);
    const double half = periodic ? 1.2 : 1.5;
    expect_parts_move_as_the_whole(
        problem, 2, [&](const Vector<D>& X) { return X[0] < half ? 0 : 1; }, 0.01, 4, !periodic);
  }
}

TEST(Halves, OfABarMoveAsTheBar) {
  expect_halves<1>(false);
}
TEST(Halves, OfAPlateMoveAsThePlate) {
  expect_halves<2>(false);
}
TEST(Halves, OfAPeriodMoveAsThePeriod) {
  expect_halves<1>(true);
  expect_halves<2>(true);
}

// What is chosen beside the methods of the table.
TEST(Halves, OfEveryUpdateAndScheme) {
  for (const char* text :
       {"ugimp+stress=first", "cpdi2+stress=musl", "mpm+stress=musl", "bspline2+stress=first",
        "mpm+update=xpic+order=5", "cpdi1+update=fmpm+order=4", "bspline3+update=runge_kutta",
        "cpls+momentum_correction=true",
        "imls_mpm+momentum_correction=true+scheme=symplectic_euler",
        "bspline_mls+momentum_correction=true", "mpm+blend=0.3", "apic+stress=first"})
    expect_parts_move_as_the_whole(
        lively<2>(composed(text), 24, false), 2,
        [](const Vector<2>& X) { return X[0] < 1.43 ? 0 : 1; }, 0.01, 4);
}

// Any three parts, also those without a straight border and far apart.
TEST(Parts, OfAnyShape) {
  for (const char* name : {"mpm", "cpdi2", "cpls", "impm", "polypic", "fmpm"})
    expect_parts_move_as_the_whole(
        lively<2>(method_named(name), 24, false), 3,
        [](const Vector<2>& X) {
          return static_cast<int>(3 + std::floor(4 * X[0] + 2 * X[1])) % 3;
        },
        0.01, 4);
}

TEST(Parts, OfABodyIn3D) {
  for (const char* name : {"mpm", "cpdi1"}) {
    const Problem<3> problem = lively<3>(method_named(name), 8, false);
    expect_parts_move_as_the_whole(
        problem, 2, [](const Vector<3>& X) { return X[0] < 0.7 ? 0 : 1; }, 0.01, 2);
  }
}

// Walls, images beyond them, loads, a body force and damping act on parts as on the whole.
TEST(Parts, FeelAllThatActs) {
  for (const char* name : {"mpm", "cpdi1", "cpdi2", "cpls", "apic", "bspline2", "impm"}) {
    for (const bool images : {false, true}) {
      Problem<2> problem = lively<2>(method_named(name), 24, false);
      Boundary<2> left;
      left.axis = 0;
      left.at = images ? 0.417 : 0.3;
      left.images = images;
      left.velocity[0] = 0.0;
      if (images)
        for (std::size_t p = 0; p < problem.particles.size(); ++p) {
          problem.particles.X[p][0] += 0.117;
          problem.particles.x[p][0] += 0.117;
        }
      Boundary<2> below;
      below.axis = 1;
      below.at = 0.3;
      below.velocity = {HeldVelocity<2>([](const Vector<2>& x, double t) {
                          return 0.1 * std::sin(x[0] + 3 * t);
                        }),
                        0.0};
      problem.boundaries = {left, below};
      problem.damping = {0.2, 0.5};
      problem.body_force = [](const Particles<2>& particles, double t, int,
                              std::vector<Vector<2>>& out) {
        for (std::size_t p = 0; p < particles.size(); ++p)
          out[p] += Vector<2>(std::sin(particles.X[p][1] + t), particles.X[p][0]);
      };
      for (const std::size_t p : {0, 20, 21, 24, 25, 26, 47, 300}) {
        Load<2> load;
        load.particle = p;
        load.offset = {0.01, -0.02};
        load.area = {0.02, 0.05};
        load.force = [](const LoadedPlace<2>& place, double t) {
          return Vector<2>(-40 * place.area + Vector<2>(0.1 + t, 0));
        };
        problem.loads.push_back(load);
      }
      const double cut = images ? 1.617 : 1.5;  // between particles 23 and 24 of a row
      expect_parts_move_as_the_whole(
          problem, 2, [&](const Vector<2>& X) { return X[0] < cut ? 0 : 1; }, 0.01, 4);
    }
  }
}

TEST(Parts, NeedALumpedMass) {
  Problem<2> problem = lively<2>(method_named("mpm"), 24, false);
  problem.method.mass = MassMatrix::consistent;
  Together<2> all(problem, 1);
  OnePart<2> part(all, 0);
  EXPECT_THROW(Step<2>(problem, 10, &part), InvalidArgument);
}

}  // namespace
}  // namespace recon::mpm::test
