#include "mpm/velocity_fit.hpp"

#include "recon/core/parallel.hpp"
#include "recon/operators/reconstruct.hpp"

namespace recon::mpm {
namespace {

// Particles, and after them the corners of their domains with the velocity
// v_c = v_p + L_p (x_c - x_p) (Tran et al. 2019, eq. 25, 41).
template <int D>
struct Data {
  std::vector<Vector<D>> x, v;

  Data(const Particles<D>& particles, int threads) : x(particles.x), v(particles.v) {
    constexpr std::size_t corner_count = Particles<D>::corner_count;
    const std::size_t count = particles.size();
    x.resize(count * (1 + corner_count));
    v.resize(x.size());
    parallel_blocks(count, 1024, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) {
        const auto corners = particles.domain(p);
        for (std::size_t a = 0; a < corner_count; ++a) {
          const std::size_t at = count + p * corner_count + a;
          x[at] = corners[a];
          v[at] = particles.v[p] + particles.L[p] * (corners[a] - particles.x[p]);
        }
      }
    });
  }
};

template <int D>
void on_grid(const Problem<D>& problem, const std::vector<Vector<D>>& x,
             const std::vector<Vector<D>>& v, Nodes<D>& nodes) {
  const auto fit =
      reconstruct_on_grid(points_of(x), {field_of(v)}, problem.grid.nodes(),
                          {.degree = problem.method.degree, .threads = problem.threads});
  nodes.fit = fit.report();
  nodes.fit_nodes.resize(nodes.mass.size());
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    nodes.fit_nodes[i] = static_cast<std::uint32_t>(i);
    if (!(nodes.mass[i] > 0)) continue;
    if (fit.report()[i].status == FitStatus::no_support)
      ++nodes.unfitted;
    else
      nodes.mapped[i] = fit.values().row(static_cast<Eigen::Index>(i)).transpose();
  }
}

// The same fit node by node, by graded Gram-Schmidt.
template <int D>
void with_lists(const Problem<D>& problem, Nodes<D>& nodes) {
  std::vector<Vector<D>> targets;
  nodes.fit_nodes.clear();
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    if (!(nodes.mass[i] > 0)) continue;
    nodes.fit_nodes.push_back(static_cast<std::uint32_t>(i));
    targets.push_back(problem.grid.position(i));
  }
  const Reconstruction fit = reconstruct(points_of(problem.particles.x), points_of(targets),
                                         {.degree = problem.method.degree,
                                          .weight = Weight::cubic_b_spline,
                                          .form = WeightForm::tensor_product,
                                          .neighbours = Radius{2 * problem.grid.h()},
                                          .solver = Solver::gram_schmidt,
                                          .threads = problem.threads});
  std::vector<Vector<D>> fitted(targets.size());
  fit.apply(field_of(problem.particles.v), field_of(fitted));
  nodes.fit = fit.report();
  for (std::size_t t = 0; t < targets.size(); ++t) {
    if (fit.report()[t].status == FitStatus::no_support)
      ++nodes.unfitted;
    else
      nodes.mapped[nodes.fit_nodes[t]] = fitted[t];
  }
}

}  // namespace

template <int D>
void fit_velocity(const Problem<D>& problem, Nodes<D>& nodes) {
  const Particles<D>& particles = problem.particles;
  if (problem.method.velocity == VelocityMap::mls) {
    on_grid(problem, particles.x, particles.v, nodes);
  } else if (problem.method.velocity == VelocityMap::imls) {
    with_lists(problem, nodes);
  } else {
    const Data<D> data(particles, problem.threads);
    on_grid(problem, data.x, data.v, nodes);
  }
}

template void fit_velocity(const Problem<1>&, Nodes<1>&);
template void fit_velocity(const Problem<2>&, Nodes<2>&);
template void fit_velocity(const Problem<3>&, Nodes<3>&);

}  // namespace recon::mpm
