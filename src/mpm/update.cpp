// The updates that map once a step, and what they are chosen from.
#include "mpm/seen.hpp"
#include "recon/transfer/scatter.hpp"
#include "transfer/node_rows.hpp"

namespace recon::mpm {
namespace {

// What the particles of a step take from the nodes: v_p and what they carry beyond it, L and what
// follows from it, x.
struct Parts {
  bool velocity = true, strain = true, position = true;
};

// Nodal velocities of a step.
template <int D>
struct Carried {
  const std::vector<Vector<D>>& carried;    // moves the particles
  const std::vector<Vector<D>>& straining;  // makes L
  double kick;                              // by which accelerations count
};

// Velocities of the nodes as rows of four numbers, or with accelerations as rows of eight.
template <int D>
detail::NodeRows rows_of(const Problem<D>& problem, const std::vector<Vector<D>>& velocity,
                         const std::vector<Vector<D>>* acceleration) {
  detail::NodeRows rows(velocity.size(), acceleration ? 8 : 4);
  const auto write = [&](std::size_t begin, std::size_t end) {
    std::fill(rows[begin], rows[end], 0.0);
    for (std::size_t i = begin; i < end; ++i)
      for (int d = 0; d < D; ++d) {
        rows[i][d] = velocity[i][d];
        if (acceleration) rows[i][4 + d] = (*acceleration)[i][d];
      }
  };
  parallel_blocks(velocity.size(), nodes_per_block, problem.threads, write);
  return rows;
}

// v_p, x_p, L of all particles, and what follows.
template <class Functions, int D, class Shape>
void take(const Problem<D>& problem, const Policies<D>& policies, const Nodes<D>& nodes,
          const Carried<D>& from, Parts parts, double dt, State<D>& s, const Shape& shape_of) {
  Particles<D>& particles = s.particles;
  const Grid<D>& grid = nodes.grid;
  const double pic = problem.method.pic_part(from.kick);
  const std::size_t modes = mode_count(problem.method.velocity, D);
  const bool with_modes = parts.velocity && modes > 0;
  const auto kernels = detail::RowKernels<D>::best();
  const bool same = &from.straining == &from.carried;
  const detail::NodeRows rows = rows_of(problem, from.carried, &nodes.acceleration);
  const detail::NodeRows others =
      same ? detail::NodeRows(0, 4) : rows_of<D>(problem, from.straining, nullptr);
  const double* straining = same ? rows.data() : others.data();
  // What a particle or an image sees of the nodes, and the coefficients of its modes.
  struct Seen {
    Vector<D> v, a;
    Matrix<D> L;
  };
  const auto see = [&](const Particles<D>& of, std::size_t p, Functions& functions,
                       Vector<D>* coefficients) {
    functions.look(of, nodes, shape_of, p);
    if (with_modes) functions.look_along(problem, nodes, shape_of, of.x[p]);
    detail::Taken taken;
    kernels.take(functions.list(), rows.data(), straining, same ? 8 : 4, taken);
    if (with_modes) functions.coefficients(kernels, rows.data(), taken, coefficients);
    Seen seen;
    for (int d = 0; d < D; ++d) {
      seen.v[d] = taken.value[d];
      seen.a[d] = taken.value[4 + d];
      for (int c = 0; c < D; ++c) seen.L(c, d) = taken.slope[d][c];
    }
    return seen;
  };
  const auto each = [&](std::size_t p, Functions& functions, std::vector<Vector<D>>& of_image) {
    Vector<D>* const own = with_modes ? &particles.modes[p * modes] : nullptr;
    Seen seen = see(particles, p, functions, own);
    const auto add = [&](const Image<D>& image, std::size_t i) {
      of_image.resize(modes);
      const Seen there = see(nodes.images.particles, i, functions, of_image.data());
      seen.v += image.vector(there.v);
      seen.a += image.vector(there.a);
      seen.L += image.gradient(there.L);
      for (std::size_t r = 0; r < modes && with_modes; ++r)  // slopes along the axes (problem.cpp)
        own[r] += image.vector(of_image[r]) * Image<D>::signs(image.mirrored)[static_cast<int>(r)];
    };
    if (const int more = for_mirrors(problem, nodes, particles.x[p], p, add); more > 0) {
      seen.v /= 1 + more;
      seen.a /= 1 + more;
      seen.L /= 1 + more;
      for (std::size_t r = 0; r < modes && with_modes; ++r) own[r] /= 1 + more;
    }
    if (parts.strain) particles.L[p] = seen.L;
    if (parts.velocity)
      kick_particle<D>(pic, from.kick, seen.v.data(), seen.a.data(), particles.v[p].data());
    if (!parts.position) return;
    const Vector<D> place = particles.x[p];
    // Of a place beside the particle.
    const auto velocity_at = [&](const Vector<D>& x) {
      ContinuedLinearFunctions::Nodes<D> at;
      ContinuedLinearFunctions{}.at(grid, x, at);
      Vector<D> v = at.value(from.carried, trusted);
      const auto add_there = [&](const Image<D>& image, std::size_t) {
        ContinuedLinearFunctions{}.at(grid, Vector<D>(image.x + image.offset(x - place)), at);
        v += image.vector(at.value(from.carried, trusted));
      };
      const int more = for_mirrors(problem, nodes, place, p, add_there);
      return more > 0 ? Vector<D>(v / (1 + more)) : v;
    };
    particles.x[p] += dt * seen.v;
    shape_of.move(particles, p, velocity_at, dt);
  };
  parallel_blocks(s.own(), particles_per_block, problem.threads,
                  [&](std::size_t begin, std::size_t end) RECON_FLATTEN {
                    Functions functions;
                    std::vector<Vector<D>> of_image;
                    for (std::size_t p = begin; p < end; ++p) each(p, functions, of_image);
                    if (parts.strain) strain(problem, begin, end, dt, s);
                    if (parts.position) policies.boundaries.keep_inside(begin, end, s);
                  });
}

// flip and pic: v_i+ = v_i + k a_i carries and strains.
template <int D>
class SingleMap : public UpdatePolicy<D> {
 public:
  using UpdatePolicy<D>::UpdatePolicy;

  void move(Step<D>& step, State<D>& s, double dt) const final {
    Nodes<D>& nodes = step.changeable_nodes();
    const Problem<D>& problem = this->problem_;
    const double kick = problem.method.kick(s.last_dt, dt);
    const double before = s.time - problem.method.velocity_lag(s.last_dt), after = before + kick;
    step.policies().boundaries.drive(before, after, nodes);
    std::vector<Vector<D>> carried = this->carried(step, s, kick);  // empty: nodes.velocity
    const auto receive = [&](const std::vector<Vector<D>>& straining, Parts parts) {
      const Carried<D> from{carried.empty() ? nodes.velocity : carried, straining, kick};
      with_seen<D>(problem.method, [&]<class Functions>(auto shape_of, Kind<Functions>) {
        take<Functions>(problem, step.policies(), nodes, from, parts, dt, s, shape_of);
      });
    };
    switch (problem.method.stress) {
      case StressUpdate::last: {  // L of the nodes' velocities after the kick
        const std::vector<Vector<D>> limited = this->limited(step, dt, kick, after);
        receive(limited.empty() ? nodes.velocity : limited, {});
        s.tick(dt);
        break;
      }
      case StressUpdate::musl:  // of what the new v_p show to the nodes at the old x_p
        if (carried.empty()) carried = nodes.velocity;
        receive(carried, {.strain = false, .position = false});
        step.to_nodes(s);
        step.policies().boundaries.give(after, nodes, nodes.velocity);
        receive(nodes.velocity, {.velocity = false});
        s.tick(dt);
        break;
      case StressUpdate::first:  // of what they show there at the new x_p
        receive(nodes.velocity, {.strain = false});
        s.tick(dt);
        step.to_nodes(s);
        receive(nodes.velocity, {.velocity = false, .position = false});
    }
  }

 protected:
  // Makes nodes.velocity that of which L is made, and returns what carries the particles; empty:
  // the same.
  virtual std::vector<Vector<D>> carried(Step<D>& step, const State<D>&, double kick) const {
    Nodes<D>& nodes = step.changeable_nodes();
    accelerate(nodes, kick, nodes.velocity);
    return {};
  }
  static void accelerate(const Nodes<D>& nodes, double kick, std::vector<Vector<D>>& velocity) {
    for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += kick * nodes.acceleration[i];
  }

 private:
  // The nodes' velocities of which L is made, where some have a mass that is too small for the
  // step; empty where none has.
  static std::vector<Vector<D>> limited(const Step<D>& step, double dt, double kick, double after) {
    const Nodes<D>& nodes = step.nodes();
    std::vector<Vector<D>> velocity;
    if (nodes.stiffness.empty()) return velocity;
    const double heaviest = nodes.heaviest();
    for (std::size_t i = 0; i < nodes.stiffness.size(); ++i) {
      const double left_out =
          left_out_of_strain(nodes.mass[i], nodes.stiffness[i], kick, dt, heaviest);
      if (left_out == 0) continue;
      if (velocity.empty()) velocity = nodes.velocity;
      velocity[i] -= left_out * nodes.internal[i];
    }
    if (!velocity.empty()) step.policies().boundaries.give(after, nodes, velocity);
    return velocity;
  }
};

// xpic and fmpm.
template <int D>
class Filtered : public SingleMap<D> {
 public:
  using SingleMap<D>::SingleMap;

 protected:
  std::vector<Vector<D>> carried(Step<D>& step, const State<D>& s, double kick) const override {
    Nodes<D>& nodes = step.changeable_nodes();
    if (this->problem_.method.update == Update::fmpm) {
      this->accelerate(nodes, kick, nodes.velocity);
      nodes.velocity = filtered(step, s, std::move(nodes.velocity));
      return {};
    }
    std::vector<Vector<D>> smooth = filtered(step, s, nodes.velocity);  // L is of the nodes' own
    this->accelerate(nodes, kick, smooth);
    this->accelerate(nodes, kick, nodes.velocity);
    return smooth;
  }

 private:
  // sum_{j < m} (1 - S+ S)^j of a velocity, zero where one is held for j > 0.
  std::vector<Vector<D>> filtered(const Step<D>& step, const State<D>& s,
                                  std::vector<Vector<D>> velocity) const {
    const Problem<D>& problem = this->problem_;
    const Particles<D>& particles = s.particles;
    const std::vector<double>& mass = step.nodes().mass;
    const ImageParticles<D>& images = step.nodes().images;
    const auto kernels = detail::RowKernels<D>::best();
    const auto add = [&]<class Functions>(auto shape_of, Kind<Functions>) {
      std::vector<Vector<D>> left = velocity;
      std::vector<Vector<D>> of_all;  // what particles see of `left`, where others show it as well
      const auto rows_of_particles = [&](const Particles<D>& of) {
        return ScatterByRows(of.size(), problem.threads, [&](std::size_t p) {
          return shape_of.nodes_along(step.nodes().grid, of, p, D - 1);
        });
      };
      const ScatterByRows order = rows_of_particles(particles);
      const ScatterByRows order_of_images = rows_of_particles(images.particles);
      for (int j = 1; j < problem.method.order; ++j) {
        const detail::NodeRows from = rows_of<D>(problem, left, nullptr);
        detail::NodeRows back(left.size(), 4);
        std::fill(back[0], back[left.size()], 0.0);
        const auto see = [&](const Functions& at) {
          alignas(32) std::array<double, 4> four;
          kernels.take_four(at.list(), from.data(), four.data());
          return Vector<D>(Eigen::Map<const Vector<D>>(four.data()));
        };
        if (step.parts() || !images.of.empty()) {
          of_all.assign(particles.size(), Vector<D>::Zero());
          parallel_blocks(s.own(), particles_per_block, problem.threads,
                          [&](std::size_t begin, std::size_t end) RECON_FLATTEN {
                            Functions at;
                            for (std::size_t p = begin; p < end; ++p) {
                              at.look(particles, step.nodes(), shape_of, p);
                              of_all[p] = see(at);
                            }
                          });
          if (step.parts()) step.parts()->copy_to(s, of_all);
        }
        // Adds what `of` show, shown(p, their functions).
        const auto give_back = [&](const Particles<D>& of, const ScatterByRows& in_order,
                                   const auto& shown) {
          in_order.add<Functions>([&](std::size_t p, Functions& at) RECON_FLATTEN {
            at.look(of, step.nodes(), shape_of, p);
            const Vector<D> v = of.mass[p] * shown(p, at);
            alignas(32) std::array<double, 4> four{};
            std::copy(v.begin(), v.end(), four.begin());
            kernels.give_four(at.list(), four.data(), back.data());
          });
        };
        give_back(particles, order, [&](std::size_t p, const Functions& at) {
          return of_all.empty() ? see(at) : of_all[p];
        });
        if (!images.of.empty())
          give_back(images.particles, order_of_images, [&](std::size_t i, const Functions&) {
            return images.of[i].vector(of_all[images.of[i].of]);
          });
        for (std::size_t i = 0; i < left.size(); ++i)
          for (int d = 0; d < D && mass[i] != 0; ++d) left[i][d] -= back[i][d] / mass[i];
        step.policies().boundaries.rest(step.nodes(), left);
        for (std::size_t i = 0; i < left.size(); ++i) velocity[i] += left[i];
      }
    };
    with_seen<D>(problem.method, add);
    return velocity;
  }
};

}  // namespace

template <int D>
std::unique_ptr<const UpdatePolicy<D>> make_update(const Problem<D>& problem) {
  const Update update = problem.method.update;
  if (update == Update::runge_kutta) return make_runge_kutta(problem);
  if (update == Update::xpic || update == Update::fmpm)
    return std::make_unique<Filtered<D>>(problem);
  return std::make_unique<SingleMap<D>>(problem);
}

#define RECON_INSTANTIATE(D) \
  template std::unique_ptr<const UpdatePolicy<D>> make_update(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
