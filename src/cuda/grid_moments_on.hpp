// Moments of the particles of a GPU at the nodes of a grid, and what is solved from them, for any
// executor (host.hpp): one thread for each node, which gathers its particles cell by cell.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "cuda/fit.hpp"
#include "cuda/reconstruction_on.hpp"
#include "grid/grid_plan.hpp"
#include "grid/solve_moments.hpp"

namespace recon::cuda {

// The nodes, and what particles weigh there.
template <int D, class T>
struct NodeWeights {
  T origin[D], spacing[D], rho[D];
  std::uint32_t counts[D];
  AnyWeight weight;
  WeightForm form;
  T least_weight;

  RECON_DEVICE void place(std::size_t node, T* x) const {
    for (int d = 0; d < D; ++d) {
      x[d] = origin[d] + static_cast<T>(node % counts[d]) * spacing[d];
      node /= counts[d];
    }
  }
  // Of xi = (x_p - x) / rho.
  RECON_DEVICE T weight_at(const std::array<T, D>& xi) const {
    T q[D], w[D];
    T q2 = 0;
    for (int d = 0; d < D; ++d) {
      q[d] = xi[d] < T(0) ? -xi[d] : xi[d];
      if (!(q[d] < T(1))) return 0;
      q2 += xi[d] * xi[d];
    }
    if (form == WeightForm::radial) {
      const T length = detail::square_root(q2);
      weight.evaluate(&length, w, static_cast<T*>(nullptr), 1);
      return w[0];
    }
    weight.evaluate(q, w, static_cast<T*>(nullptr), D);
    T product = w[0];
    for (int d = 1; d < D; ++d) product *= w[d];
    return product;
  }
  // The rounding error of xi at a node.
  RECON_DEVICE T noise(const T* x) const {
    T size = 1;
    for (int d = 0; d < D; ++d) size = most_of(size, 1 + std::abs(x[d]) / rho[d]);
    return std::numeric_limits<T>::epsilon() * size;
  }
};

// Calls use(xi, w, place) for the particles that have a weight at x, a place of the grid.
template <int D, class T, class Use>
RECON_DEVICE void for_weighted(const CloudView<D, T>& cloud, const NodeWeights<D, T>& nodes,
                               const T* x, const Use& use) {
  if (cloud.count == 0) return;
  double half[D];
  T per_rho[D];
  for (int d = 0; d < D; ++d) {
    half[d] = static_cast<double>(nodes.rho[d]);
    per_rho[d] = 1 / nodes.rho[d];
  }
  Around<D, T>(cloud, x).in_box(
      half, std::numeric_limits<double>::max(), [&](std::uint32_t place, T) {
        std::array<T, D> xi;
        for (int d = 0; d < D; ++d)
          xi[d] = (cloud.x[std::size_t{place} * D + d] - x[d]) * per_rho[d];
        const T w = nodes.weight_at(xi);
        if (w > T(0)) use(xi, w, place);
      });
}

// Sums the moments of node after node: the number of particles, sum w xi^alpha as Monomials<D, 2 R>,
// and for each component sum w xi^alpha u as Monomials<D, R>, in the order of the particles.
template <int D, int R, class T>
struct SumMoments {
  static constexpr int M = Monomials<D, 2 * R>::size, m = Monomials<D, R>::size, at_once = 3;
  // As many components as a thread has registers for beside the moments.
  static constexpr int with_first = R < 2 ? at_once : 0;
  CloudView<D, T> cloud;
  const std::uint32_t* order;
  NodeWeights<D, T> nodes;
  Field<const T> field;
  T* to;

  RECON_DEVICE void operator()(std::size_t node) const {
    T* const out = to + node * static_cast<std::size_t>(1 + M + field.components * m);
    T x[D];
    nodes.place(node, x);
    T sums[1 + M];
    for (T& sum : sums) sum = 0;
    T rights[at_once * m];
    for (T& right : rights) right = 0;
    const int first = least_of(with_first, field.components);
    for_weighted(cloud, nodes, x, [&](const std::array<T, D>& xi, T w, std::uint32_t place) {
      T terms[M];
      Monomials<D, 2 * R>::evaluate(xi, terms);
      sums[0] += w > nodes.least_weight ? T(1) : T(0);
      for (int a = 0; a < M; ++a) sums[1 + a] += w * terms[a];
      add(place, w, terms, 0, first, rights);
    });
    for (int a = 0; a < 1 + M; ++a) out[a] = sums[a];
    put(rights, first, out + 1 + M);
    for (int c = first; c < field.components; c += at_once)
      sum_components(x, c, least_of(at_once, field.components - c), out + 1 + M + c * m);
  }

 private:
  // Adds w terms u of some components to their sums.
  RECON_DEVICE void add(std::uint32_t place, T w, const T* terms, int first, int count,
                        T* sums) const {
    const T* const u = field.data + std::ptrdiff_t{order[place]} * field.point_stride;
    for (int c = 0; c < at_once; ++c) {  // a fixed number: sums stay in registers
      if (c >= count) continue;
      const T own = w * u[(first + c) * field.component_stride];
      for (int a = 0; a < m; ++a) sums[c * m + a] += own * terms[a];
    }
  }
  RECON_DEVICE static void put(const T* sums, int count, T* out) {
    for (int c = 0; c < at_once; ++c)
      for (int a = 0; a < m && c < count; ++a) out[c * m + a] = sums[c * m + a];
  }
  RECON_DEVICE void sum_components(const T* x, int first, int count, T* out) const {
    T sums[at_once * m];
    for (T& sum : sums) sum = 0;
    for_weighted(cloud, nodes, x, [&](const std::array<T, D>& xi, T w, std::uint32_t place) {
      T terms[m];
      Monomials<D, R>::evaluate(xi, terms);
      add(place, w, terms, first, count, sums);
    });
    put(sums, count, out);
  }
};

// Values, gradients (unless null) and reports of node after node.
template <int D, int R, class T>
struct SolveNodes {
  static constexpr int M = Monomials<D, 2 * R>::size, m = Monomials<D, R>::size;
  NodeWeights<D, T> nodes;
  FitTolerances tolerances;
  int components;
  const T* moments;
  T empty;  // where there is no particle
  Field<T> values, gradients;
  FitReport* reports;

  RECON_DEVICE void operator()(std::size_t node) const {
    const T* const from = moments + node * static_cast<std::size_t>(1 + M + components * m);
    T x[D];
    nodes.place(node, x);
    FitReport own;
    for (int c = 0; c < components; ++c) put(node, c, empty, nullptr);
    detail::solve_moments<T, D, R>(
        from, nodes.noise(x), tolerances, R,
        [&](const auto& matrix, bool safe, const T&, const FitReport& report, const auto& partial) {
          if (!safe) return;
          own = report;
          constexpr int terms = std::decay_t<decltype(matrix)>::m;
          for (int c = 0; c < components; ++c) {
            std::array<T, terms> b;
            for (int j = 0; j < terms; ++j) b[j] = from[1 + M + c * m + j];
            b = matrix.solve(b);
            std::array<T, D> slope{};
            for (int d = 0; d < D && terms > 1; ++d) slope[d] = b[terms == 1 ? 0 : 1 + d];
            if (partial) slope = partial->project(slope);
            put(node, c, b[0], slope.data());
          }
        });
    if (reports) reports[node] = own;
  }

 private:
  // slope: times rho; null: the same as for the value where there is none.
  RECON_DEVICE void put(std::size_t node, int c, T value, const T* slope) const {
    const auto at = static_cast<std::ptrdiff_t>(node);
    values.data[at * values.point_stride + c * values.component_stride] = value;
    for (int d = 0; d < D && gradients.data; ++d)
      gradients.data[at * gradients.point_stride + (c * D + d) * gradients.component_stride] =
          slope ? slope[d] / nodes.rho[d] : empty;
  }
};

template <class Executor, int D, class T, class Compiled>
class GridMomentsOn {
  template <class U>
  using Array = typename Executor::template Array<U>;

 public:
  using Sources = SourcesOn<Executor, D, T>;

  GridMomentsOn(std::shared_ptr<Sources> sources, const StructuredGrid<T>& grid, int components,
                const Options& options)
      : sources_(std::move(sources)), executor_(sources_->executor()) {
    using detail::require;
    grid.validate();
    require(grid.dimension == D, "dimension of the grid", grid.dimension,
            "must be that of the Sources");
    require(components >= 1, "components", components, "must be at least 1");
    options.validate();
    options.validate_with_sources();
    require(options.weight.named().has_value(), "weight", "of your own",
            "must be one of recon::Weight on a GPU");
    require(!options.progress, "progress", "given", "must be empty on a GPU");
    if (const auto beyond = beyond_moments<T>(grid, options, {})) throw *beyond;
    require(Compiled::with(options.degree, [](auto) {}), "degree", options.degree,
            "must be one of those that are compiled for a GPU");
    require(!sources_->frame().any_period(), "domain of the Sources", "periodic",
            "must not be periodic for sums of moments");
    const GridPlan<T> plan(grid, options, components);
    for (int d = 0; d < D; ++d) {
      require(sources_->frame().stretch[d] == 1, "stretch of the Sources",
              sources_->frame().stretch[d], "must be 1 for sums of moments");
      nodes_.origin[d] = grid.origin[d];
      nodes_.spacing[d] = grid.spacing[d];
      nodes_.rho[d] = static_cast<T>(plan.axes[d].rho);
      nodes_.counts[d] = static_cast<std::uint32_t>(grid.counts[d]);
    }
    nodes_.weight = {*options.weight.named()};
    nodes_.form = plan.form;
    nodes_.least_weight = plan.least_weight;
    count_ = grid.size();
    components_ = components;
    per_node_ = plan.quantities();
    degree_ = options.degree;
    fill_ = static_cast<T>(options.fill_value);
    tolerances_ = options.tolerances;
    executor_->provide(values_, count_ * static_cast<std::size_t>(per_node_));
    executor_->provide(reports_, count_);
  }
  GridMomentsOn(const GridMomentsOn&) = delete;
  GridMomentsOn& operator=(const GridMomentsOn&) = delete;

  // Sums the moments of the particles where they are now.
  void sum(const Field<const T>& field) {
    field.validate("field", sources_->size());
    detail::require(field.components == components_, "components of the field", field.components,
                    "must be those of the moments");
    Compiled::with(degree_, [&](auto r) {
      executor_->for_each(
          count_, SumMoments<D, decltype(r)::value, T>{sources_->view(), sources_->order(), nodes_,
                                                       field, values_.data()});
    });
  }

  // gradients.data null: none.
  void solve(const Field<T>& values, const Field<T>& gradients) {
    values.validate("values", count_);
    detail::require(values.components == components_, "components of the values", values.components,
                    "must be those of the moments");
    if (gradients.data) {
      gradients.validate("gradients", count_);
      detail::require(gradients.components == D * components_, "components of the gradients",
                      gradients.components, "must be D times those of the moments");
    }
    Compiled::with(degree_, [&](auto r) {
      executor_->for_each(count_, SolveNodes<D, decltype(r)::value, T>{
                                      nodes_, tolerances_, components_, values_.data(), fill_,
                                      values, gradients, reports_.data()});
    });
  }

  std::size_t nodes() const { return count_; }
  int per_node() const { return per_node_; }
  T* values() { return values_.data(); }
  const FitReport* reports() const { return reports_.data(); }
  const NodeWeights<D, T>& weights() const { return nodes_; }
  const FitTolerances& tolerances() const { return tolerances_; }

 private:
  std::shared_ptr<Sources> sources_;
  std::shared_ptr<Executor> executor_;
  NodeWeights<D, T> nodes_{};
  std::size_t count_ = 0;
  int components_ = 1, per_node_ = 0, degree_ = 0;
  T fill_ = 0;
  FitTolerances tolerances_;
  Array<T> values_;
  Array<FitReport> reports_;
};

}  // namespace recon::cuda
