#include "recon/runs/manufactured.hpp"

#include <numbers>

#include "recon/core/names.hpp"
#include "recon/core/parallel.hpp"
#include "recon/runs/jet.hpp"

namespace recon::mpm {
namespace {

constexpr double pi = std::numbers::pi;

struct Vibration {
  static constexpr const char* name = "vibration";
  static double period(double c) { return 2 / c; }
  template <int D, class T>
  static std::array<T, D> displacement(const std::array<T, D>& X, const T& t, double G, double c) {
    std::array<T, D> u;
    for (int d = 0; d < D; ++d) u[d] = T(G) * sin(T(pi) * X[d]) * sin(T(c * pi) * t);
    return u;
  }
};

struct AxisVibration : Vibration {
  static constexpr const char* name = "axis_vibration";
  template <int D, class T>
  static std::array<T, D> displacement(const std::array<T, D>& X, const T& t, double G, double c) {
    std::array<T, D> u;
    for (int d = 0; d < D; ++d) u[d] = T(G) * sin(T(2 * pi) * X[d]) * sin(T(c * pi) * t);
    return u;
  }
};

struct WaveAlongX : Vibration {
  static constexpr const char* name = "wave_along_x";
  template <int D, class T>
  static std::array<T, D> displacement(const std::array<T, D>& X, const T& t, double G, double c) {
    std::array<T, D> u;
    u.fill(T(0));
    u[0] = AxisVibration::displacement<D, T>(X, t, G, c)[0];
    return u;
  }
};

struct Ring {
  static constexpr const char* name = "ring";
  static constexpr double inner = 0.4, outer = 0.6, mean = 0.5;
  static double period(double c) { return 4 * mean / c; }
  template <int D, class T>
  static std::array<T, D> displacement(const std::array<T, D>& X, const T& t, double G, double c) {
    constexpr double base = outer - 3 * inner;
    constexpr double c1 = -6 * inner / (outer * base),
                     c2 = 3 * (inner + outer) / (outer * outer * base),
                     c3 = -2 / (outer * outer * base);
    const T R = sqrt(X[0] * X[0] + X[1] * X[1]);
    const T stretch = T(G) * sin(T(c * pi / (2 * mean)) * t) * ((T(c3) * R + T(c2)) * R + T(c1));
    return {stretch * X[0], stretch * X[1]};
  }
};

struct Vortex {
  static constexpr const char* name = "vortex";
  static double period(double c) { return 2 / c; }
  template <int D, class T>
  static std::array<T, D> displacement(const std::array<T, D>& X, const T& t, double G, double c) {
    const T s = sqrt(X[0] * X[0] + X[1] * X[1]) - T(1), s2 = s * s;
    const T angle = T(G) * sin(T(c * pi) * t) * (T(1) - T(32) * s2 + T(256) * s2 * s2);
    return {X[0] * cos(angle) - X[1] * sin(angle) - X[0],
            X[0] * sin(angle) + X[1] * cos(angle) - X[1]};
  }
};

template <int D, class Motion>
class Solution final : public Manufactured<D> {
  using State = typename Manufactured<D>::State;

 public:
  Solution(double G, const NeoHookean& material, double density)
      : G_(G), material_(material), density_(density), c_(material.bar_wave_speed(density)) {}

  std::string name() const override { return Motion::name; }
  double period() const override { return Motion::period(c_); }

  State at(const Vector<D>& X, double t) const override {
    using J = Jet<D + 1>;
    std::array<J, D> place;
    for (int d = 0; d < D; ++d) place[d] = J::variable(X[d], d);
    const auto u = Motion::template displacement<D>(place, J::variable(t, D), G_, c_);

    State state;
    Matrix<D> rate;
    std::array<Matrix<D>, D> dF;  // d F / d X_b
    for (int i = 0; i < D; ++i) {
      state.displacement[i] = u[i].value;
      state.velocity[i] = u[i].first[D];
      state.body_force[i] = u[i].second(D, D);
      for (int a = 0; a < D; ++a) {
        state.F(i, a) = u[i].first[a] + (i == a ? 1 : 0);
        rate(i, a) = u[i].second(D, a);
        for (int b = 0; b < D; ++b) dF[b](i, a) = u[i].second(a, b);
      }
    }
    const Matrix<D> inverse = state.F.inverse();
    state.velocity_gradient = rate * inverse;
    const double mu = material_.mu, lambda = material_.lambda;
    const double factor = lambda * std::log(state.F.determinant()) - mu;
    for (int b = 0; b < D; ++b) {
      const Matrix<D> change = inverse * dF[b];  // of ln J: its trace
      const Matrix<D> dP = mu * dF[b] + lambda * change.trace() * inverse.transpose() -
                           factor * (change * inverse).transpose();
      state.body_force -= dP.col(b) / density_;
    }
    return state;
  }

 private:
  double G_;
  NeoHookean material_;
  double density_, c_;
};

}  // namespace

std::vector<std::string> manufactured_names() {
  return {Vibration::name, AxisVibration::name, WaveAlongX::name, Ring::name, Vortex::name};
}

template <int D>
std::shared_ptr<const Manufactured<D>> make_manufactured(std::string_view name, double G,
                                                         const NeoHookean& material,
                                                         double density) {
  std::shared_ptr<const Manufactured<D>> made;
  const auto offer = [&](auto motion) {
    using Motion = decltype(motion);
    if (name != Motion::name) return;
    if constexpr (D == 2 || std::is_base_of_v<Vibration, Motion>)
      made = std::make_shared<Solution<D, Motion>>(G, material, density);
    else
      recon::detail::throw_invalid("manufactured solution", name, "is defined in 2-D only");
  };
  offer(Vibration{});
  offer(AxisVibration{});
  offer(WaveAlongX{});
  offer(Ring{});
  offer(Vortex{});
  if (!made)
    recon::detail::throw_invalid("manufactured solution", name,
                                 suggest(name, manufactured_names()));
  return made;
}

const NeoHookean& material_of_exact(const std::vector<Material>& materials) {
  recon::detail::require(materials.size() == 1, "bodies with an exact solution", materials.size(),
                         "must be one");
  const auto* material = std::get_if<NeoHookean>(&materials[0]);
  recon::detail::require(material != nullptr, "material of an exact solution",
                         name_of(materials[0]), "must be neo_hookean");
  return *material;
}

template <int D>
void follow(const std::shared_ptr<const Manufactured<D>>& exact, Problem<D>& problem) {
  Particles<D>& particles = problem.particles;
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const auto state = exact->at(particles.X[p], 0);
    particles.v[p] = state.velocity;
    particles.L[p] = state.velocity_gradient;
  }
  problem.body_force = [exact](const Particles<D>& at, double t, int threads,
                               std::vector<Vector<D>>& out) {
    parallel_blocks(at.size(), 1024, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) out[p] += exact->at(at.X[p], t).body_force;
    });
  };
}

#define RECON_INSTANTIATE(D)                                                                    \
  template std::shared_ptr<const Manufactured<D>> make_manufactured(std::string_view, double,   \
                                                                    const NeoHookean&, double); \
  template void follow(const std::shared_ptr<const Manufactured<D>>&, Problem<D>&);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
