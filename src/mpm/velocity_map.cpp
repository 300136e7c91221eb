// What particles give to the nodes, and the fitted velocity maps.
#include <numeric>

#include "mpm/seen.hpp"
#include "recon/operators/reconstruct.hpp"
#include "recon/transfer/scatter.hpp"

namespace recon::mpm {
namespace {

// The sums over particles. A particle shows to its node k
//   v_p                       mass_weighted, and fits before they are made
//   v_p + L_p (x_k - x_p)     taylor
//   v_p + sum_r c_r s_r(x_k)  affine, polynomial
template <int D, class Shape, class Seen>
struct Scatter {
  const Problem<D>& problem;
  const Particles<D>& particles;
  const std::vector<Vector<D>>& b;
  const FromParticles& from;
  const Nodes<D>& nodes;
  detail::NodeRows& rows;    // mass, momentum, internal force and stiffness of each node
  detail::NodeRows& pushes;  // what body forces give; none where b is empty
  const Shape shape_of;
  const Grid<D>& grid = nodes.grid;
  const VelocityMap map = problem.method.velocity;
  const bool shows_more = map == VelocityMap::taylor || mode_count(map, D) > 0;
  const std::size_t modes = mode_count(map, D);
  const detail::RowKernels<D> kernels = detail::RowKernels<D>::best();

  struct Scratch {
    Seen seen;
    std::vector<double> coefficients;  // of the velocity that the particle shows beyond its own
    detail::Given given{};
  };

  void run() const {
    const auto touched = [&](std::size_t p) {
      return shape_of.nodes_along(grid, particles, p, D - 1);
    };
    const auto add = [&](std::size_t p, Scratch& scratch) RECON_FLATTEN { this->add(p, scratch); };
    scatter_by_rows<Scratch>(particles.size(), problem.threads, touched, add);
  }

  void add(std::size_t p, Scratch& scratch) const {
    if (from.leaves_out(grid, particles.x[p])) return;
    Seen& seen = scratch.seen;
    detail::Given& given = scratch.given;
    const double volume = seen.look(particles, nodes, shape_of, p);
    const double mass = particles.mass[p];
    for (int d = 0; d < D; ++d) given.value[1 + d] = mass * particles.v[p][d];
    if (shows_more) {
      seen.look_along(problem, nodes, shape_of, particles.x[p]);
      if (map == VelocityMap::taylor)
        show_also(scratch, mass,
                  [&](std::size_t d) { return particles.L[p].col(static_cast<int>(d)); });
      else
        show_also(scratch, mass, [&](std::size_t r) -> const Vector<D>& {
          return particles.modes[p * modes + r];
        });
    }
    if (from.mass_and_force) {
      given.value[0] = mass;
      const Matrix<D> pull = -volume * particles.stress[p];
      for (int d = 0; d < D; ++d)
        for (int c = 0; c < D; ++c) given.slope[d][c] = pull(c, d);
      if (!nodes.stiffness.empty()) {
        const Lame& elastic = lame(problem.materials[static_cast<std::size_t>(particles.body[p])]);
        given.squared = volume * (elastic.lambda + 2 * elastic.mu);
      }
      if (!b.empty()) {
        alignas(32) std::array<double, 4> push{};
        for (int d = 0; d < D; ++d) push[static_cast<std::size_t>(d)] = mass * b[p][d];
        kernels.give_four(seen.list(), push.data(), pushes.data());
      }
    }
    kernels.give(seen.list(), given, rows.data());
  }

  // With the coefficients c(r) of the modes; those that the functions cannot tell count as zero.
  template <class Coefficient>
  void show_also(Scratch& scratch, double mass, const Coefficient& c) const {
    scratch.given.modes = scratch.seen.modes();
    const std::size_t count = scratch.given.modes.count;
    scratch.coefficients.assign(4 * count, 0);
    scratch.given.coefficients = scratch.coefficients.data();
    for (std::size_t r = 0; r < count; ++r) {
      if (map != VelocityMap::taylor && !scratch.seen.tells(r)) continue;
      for (int d = 0; d < D; ++d)
        scratch.coefficients[4 * r + 1 + static_cast<std::size_t>(d)] = mass * c(r)[d];
    }
  }
};

// Particles, and after them the corners of their domains with the velocity
// v_c = v_p + L_p (x_c - x_p) (Tran et al. 2019, eq. 25, 41).
template <int D>
struct WithCorners {
  std::vector<Vector<D>> x, v;

  WithCorners(const Particles<D>& particles, int threads) : x(particles.x), v(particles.v) {
    constexpr std::size_t corner_count = Particles<D>::corner_count;
    const std::size_t count = particles.size();
    x.resize(count * (1 + corner_count));
    v.resize(x.size());
    parallel_blocks(count, particles_per_block, threads, [&](std::size_t begin, std::size_t end) {
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

// The fits of the nodes nodes.fit_nodes: value(t) is v_i of the one with number t. Where no point
// lies in the support of a node, the mass-weighted velocity is kept, and the node counted.
template <int D, class Value>
void accept(const FitReports& report, const Value& value, Nodes<D>& nodes) {
  nodes.fit = report;
  for (std::size_t t = 0; t < nodes.fit_nodes.size(); ++t) {
    const std::uint32_t i = nodes.fit_nodes[t];
    if (!(nodes.mass[i] > 0)) continue;
    if (report[t].status == FitStatus::no_support)
      nodes.unfitted += nodes.is_known(i) ? 1 : 0;
    else
      nodes.mapped[i] = value(t);
  }
}

// A fit to velocities at places and their images.
template <int D>
class FitMap : public MapPolicy<D> {
 public:
  explicit FitMap(const Problem<D>& problem)
      : MapPolicy<D>(problem), images_(images_of(problem, true)) {}

 protected:
  using Vectors = std::vector<Vector<D>>;

  void fit(const State<D>& s, Nodes<D>& nodes) const final {
    if (this->problem_.method.velocity == VelocityMap::cpls) {
      const WithCorners<D> data(s.particles, this->problem_.threads);
      return fit_mirrored(data.x, data.v, nodes);
    }
    fit_mirrored(s.particles.x, s.particles.v, nodes);
  }
  virtual void fit_to(const Vectors& x, const Vectors& v, Nodes<D>& nodes) const = 0;

 private:
  void fit_mirrored(const Vectors& x, const Vectors& v, Nodes<D>& nodes) const {
    if (images_.empty()) return fit_to(x, v, nodes);
    const auto seen = images_.of(x);
    fit_to(with_places(x, seen), with_vectors(v, seen), nodes);
  }
  Images<D> images_;
};

// The fit of all nodes at once, by moments.
template <int D>
class GridMap : public FitMap<D> {
 public:
  using FitMap<D>::FitMap;

 protected:
  void fit_to(const std::vector<Vector<D>>& x, const std::vector<Vector<D>>& v,
              Nodes<D>& nodes) const override {
    const Problem<D>& problem = this->problem_;
    const auto fit =
        reconstruct_on_grid(points_of(x), {field_of(v)}, nodes.grid.nodes(),
                            {.degree = problem.method.degree, .threads = problem.threads});
    nodes.fit_nodes.resize(nodes.mass.size());
    std::iota(nodes.fit_nodes.begin(), nodes.fit_nodes.end(), 0u);
    const auto value = [&](std::size_t i) {
      return fit.values().row(static_cast<Eigen::Index>(i)).transpose();
    };
    accept(fit.report(), value, nodes);
  }
};

// The fit node by node, by graded Gram-Schmidt.
template <int D>
class ImlsMap : public FitMap<D> {
 public:
  using FitMap<D>::FitMap;

 protected:
  void fit_to(const std::vector<Vector<D>>& x, const std::vector<Vector<D>>& v,
              Nodes<D>& nodes) const override {
    const Problem<D>& problem = this->problem_;
    std::vector<Vector<D>> targets;
    nodes.fit_nodes.clear();
    for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
      if (!(nodes.mass[i] > 0)) continue;
      nodes.fit_nodes.push_back(static_cast<std::uint32_t>(i));
      targets.push_back(nodes.grid.position(i));
    }
    const Reconstruction fit = reconstruct(points_of(x), points_of(targets),
                                           {.degree = problem.method.degree,
                                            .weight = Weight::cubic_b_spline,
                                            .form = WeightForm::tensor_product,
                                            .neighbours = Radius{2 * problem.grid.h()},
                                            .solver = Solver::gram_schmidt,
                                            .threads = problem.threads});
    std::vector<Vector<D>> fitted(targets.size());
    fit.apply(field_of(v), field_of(fitted));
    accept(
        fit.report(), [&](std::size_t t) { return fitted[t]; }, nodes);
  }
};

}  // namespace

template <int D>
void MapPolicy<D>::to_nodes(const State<D>& s, const std::vector<Vector<D>>& b,
                            const FromParticles& from, Nodes<D>& nodes) const {
  const Problem<D>& problem = this->problem_;
  const std::size_t count = nodes.mass.size();
  const bool pushed = !b.empty() && from.mass_and_force;
  detail::NodeRows rows(count, 8), pushes(pushed ? count : 0, 4);
  const auto for_nodes = [&](const auto& work) {
    parallel_blocks(count, nodes_per_block, problem.threads, work);
  };
  for_nodes([&](std::size_t begin, std::size_t end) {
    std::fill(rows[begin], rows[end], 0.0);
    if (pushed) std::fill(pushes[begin], pushes[end], 0.0);
  });
  with_seen<D>(problem.method, [&]<class Seen>(auto shape_of, Kind<Seen>) {
    using Sum = Scatter<D, decltype(shape_of), Seen>;
    Sum{problem, s.particles, b, from, nodes, rows, pushes, shape_of}.run();
    const ImageParticles<D>& images = nodes.images;
    if (!images.of.empty())
      Sum{problem, images.particles, images.body_force, from, nodes, rows, pushes, shape_of}.run();
  });
  for_nodes([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double* row = rows[i];
      nodes.mass[i] += row[0];
      for (int d = 0; d < D; ++d) {
        nodes.momentum[i][d] += row[1 + d];
        nodes.force[i][d] += row[4 + d];
        if (pushed) nodes.force[i][d] += pushes[i][d];
      }
      if (nodes.stiffness.empty()) continue;
      for (int d = 0; d < D; ++d) nodes.internal[i][d] += row[4 + d];
      nodes.stiffness[i] += row[7];
    }
  });
}

template <int D>
void MapPolicy<D>::velocities(const State<D>& s, OtherParts<D>* parts, Nodes<D>& nodes) const {
  fit(s, nodes);
  const Method& method = this->problem_.method;
  if (!method.momentum_correction || method.keeps_momentum()) return;
  const Particles<D>& particles = s.particles;
  Vector<D> missing = Vector<D>::Zero();
  double mass = 0;
  for (std::size_t p = 0; p < s.own(); ++p) missing += particles.mass[p] * particles.v[p];
  for (std::size_t i = 0; i < nodes.mass.size(); ++i) {
    missing -= nodes.share_of(i) * nodes.mass[i] * nodes.mapped[i];
    mass += nodes.share_of(i) * nodes.mass[i];
  }
  if (parts) {
    std::array<double, D + 1> sums{};
    for (int d = 0; d < D; ++d) sums[static_cast<std::size_t>(d)] = missing[d];
    sums[D] = mass;
    parts->sum(sums);
    for (int d = 0; d < D; ++d) missing[d] = sums[static_cast<std::size_t>(d)];
    mass = sums[D];
  }
  for (std::size_t i = 0; i < nodes.mass.size(); ++i)
    if (nodes.mass[i] != 0) nodes.mapped[i] += missing / mass;
}

template <int D>
std::unique_ptr<const MapPolicy<D>> make_map(const Problem<D>& problem) {
  if (problem.method.velocity == VelocityMap::imls) return std::make_unique<ImlsMap<D>>(problem);
  if (is_fit(problem.method.velocity)) return std::make_unique<GridMap<D>>(problem);
  return std::make_unique<MapPolicy<D>>(problem);
}

#define RECON_INSTANTIATE(D)   \
  template class MapPolicy<D>; \
  template std::unique_ptr<const MapPolicy<D>> make_map(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
