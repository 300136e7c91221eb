// y' = f(y) for position, velocity and deformation; f is the map and the rates of flip.
#include "mpm/policies.hpp"

namespace recon::mpm {
namespace {

template <int D>
class RungeKutta : public UpdatePolicy<D> {
 public:
  using UpdatePolicy<D>::UpdatePolicy;

  void move(Step<D>& step, State<D>& s, double dt) const override {
    constexpr int stages = 4;
    constexpr double part[stages] = {0.5, 0.5, 1, 0}, weight[stages] = {1, 2, 2, 1};
    const State<D> start = s;
    std::vector<Rates> sum(s.particles.size()), rates(s.particles.size());
    for (int stage = 0; stage < stages; ++stage) {
      const bool last = stage + 1 == stages;
      step.policies().boundaries.drive(start.time, start.time + dt, step.changeable_nodes());
      rates_of(step.nodes(), s, weight[stage] / 6, rates, sum);
      s.particles = start.particles;
      advance(step, last ? sum : rates, last ? dt : part[stage] * dt, s);
      if (last) break;
      s.time = start.time + part[stage] * dt;
      step.to_nodes(s);
    }
    s.time = start.time;
    s.tick(dt);
  }

 private:
  struct Rates {
    Vector<D> x = Vector<D>::Zero(), v = Vector<D>::Zero();
    Matrix<D> L = Matrix<D>::Zero(), F = Matrix<D>::Zero();
    void add(double factor, const Rates& other) {
      x += factor * other.x;
      v += factor * other.v;
      L += factor * other.L;
      F += factor * other.F;
    }
  };

  // And adds `weight` times the rates to their sum.
  void rates_of(const Nodes<D>& nodes, const State<D>& s, double weight, std::vector<Rates>& rates,
                std::vector<Rates>& sum) const {
    const Particles<D>& particles = s.particles;
    with_shape(this->problem_.method, [&](auto shape_of) {
      using Seen = typename decltype(shape_of)::template Nodes<D>;
      const auto each = [&](std::size_t p, const auto& shape, Seen& at) {
        rates[p].x = shape.value(nodes.velocity, trusted);
        rates[p].v = shape.value(nodes.acceleration, trusted);
        rates[p].L = shape.gradient(nodes.velocity, trusted);
        const auto add = [&](const Image<D>& image, std::size_t i) {
          functions_of(nodes.images.particles, nodes, shape_of, i, at);
          rates[p].x += image.vector(at.value(nodes.velocity, trusted));
          rates[p].v += image.vector(at.value(nodes.acceleration, trusted));
          rates[p].L += image.gradient(at.gradient(nodes.velocity, trusted));
        };
        const int more = for_mirrors(this->problem_, nodes, particles.x[p], p, add);
        if (more > 0) {
          rates[p].x /= 1 + more;
          rates[p].v /= 1 + more;
          rates[p].L /= 1 + more;
        }
        rates[p].F = rates[p].L * particles.F[p];
        sum[p].add(weight, rates[p]);
      };
      for_each_shape<Seen>(this->problem_, s, nodes, shape_of, each,
                           [](std::size_t, std::size_t) {});
    });
  }

  // From the state at the beginning of the step.
  void advance(const Step<D>& step, const std::vector<Rates>& rates, double dt, State<D>& s) const {
    Particles<D>& particles = s.particles;
    parallel_blocks(s.own(), particles_per_block, this->problem_.threads,
                    [&](std::size_t begin, std::size_t end) {
                      for (std::size_t p = begin; p < end; ++p) {
                        particles.L[p] = rates[p].L;
                        particles.F[p] += dt * rates[p].F;
                        particles.x[p] += dt * rates[p].x;
                        particles.v[p] += dt * rates[p].v;
                      }
                      strain_to(this->problem_, begin, end, dt, s);
                      step.policies().boundaries.keep_inside(begin, end, s);
                    });
  }
};

}  // namespace

template <int D>
std::unique_ptr<const UpdatePolicy<D>> make_runge_kutta(const Problem<D>& problem) {
  return std::make_unique<RungeKutta<D>>(problem);
}

#define RECON_INSTANTIATE(D) \
  template std::unique_ptr<const UpdatePolicy<D>> make_runge_kutta(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
