#include "recon/petsc/reconstruct_on_grid.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "grid/grid_plan.hpp"
#include "recon/petsc/reconstruct.hpp"

namespace recon::petsc {
namespace {

using detail::require;

// The coordinates of particles as the nodes of a piece see them, and the nodes that they see.
class Reach {
 public:
  Reach(const DistributedGrid& grid, const Options& options) : grid_(grid) {
    const Options all = options.for_grid(grid.all());
    const Radius* radius = std::get_if<Radius>(&*all.neighbours);
    require(radius != nullptr, "neighbours", "a support for each node",
            "must be Radius or, with a B-spline as weight, empty for sums of moments");
    for (int d = 0; d < dimension(); ++d)
      support_[d] = radius->radius * all.stretch[d] / grid.all().spacing[d];
  }

  // The image of a coordinate that is nearest to the rank's own nodes.
  double image(double x, int d) const {
    if (!grid_.periodic()[d]) return x;
    const double middle =
        static_cast<double>(grid_.owned_begin()[d]) + 0.5 * static_cast<double>(owned(d));
    const double nodes = static_cast<double>(grid_.all().counts[d]);
    const double periods = std::round((middle - grid_.place(x, d)) / nodes);
    return x + periods * nodes * grid_.all().spacing[d];
  }

  void require_within(double x, std::size_t particle, int d) const {
    const double u = grid_.place(x, d);
    double first = std::floor(u - support_[d]) + 1, last = std::ceil(u + support_[d]) - 1;
    if (!grid_.periodic()[d]) {
      first = std::max(first, 0.0);
      last = std::min(last, static_cast<double>(grid_.all().counts[d]) - 1);
    }
    const auto begin = static_cast<double>(grid_.piece_begin()[d]);
    const double end = begin + static_cast<double>(grid_.piece().counts[d]) - 1;
    if (first > last || (first >= begin && last <= end)) return;
    detail::throw_invalid(
        detail::coordinate_name(particle, d, "particles"), x,
        "must see no nodes beyond this rank's piece, which are " + detail::to_text(begin) + " to " +
            detail::to_text(end) + ", but sees " + detail::to_text(first) + " to " +
            detail::to_text(last) + ": bring it to its rank, or have more ghosts");
  }

 private:
  int dimension() const { return grid_.all().dimension; }
  std::size_t owned(int d) const { return grid_.owned().counts[d]; }

  const DistributedGrid& grid_;
  std::array<double, max_dimension> support_{};
};

void require_no_domain(const Options& options) {
  require(!options.domain.any(), "domain", "periodic",
          "must not be said: the grid says which axes are periodic");
}

}  // namespace

GridMoments moments_of_piece(const PointsView<double>& points,
                             const std::vector<FieldView<double>>& fields,
                             const DistributedGrid& grid, const Options& options) {
  options.validate();
  require_no_domain(options);
  const int dimension = grid.all().dimension;
  require(points.dimension() == dimension, "dimension of the points", points.dimension(),
          "must be that of the grid");
  const Reach reach(grid, options);
  const bool periodic = grid.domain().any();
  std::array<std::vector<double>, max_dimension> images;
  for (int d = 0; d < dimension; ++d) {
    if (periodic) images[d].resize(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (!std::isfinite(points(p, d)))
        detail::throw_invalid(detail::coordinate_name(p, d, "particles"), points(p, d),
                              "must be finite");
      const double x = reach.image(points(p, d), d);
      if (periodic) images[d][p] = x;
      reach.require_within(x, p, d);
    }
  }
  if (!periodic) return {points, fields, grid.piece(), options};
  return {points_of_axes(images, dimension), fields, grid.piece(), options};
}

GridReconstruction solve_owned(std::span<const double> sums, int components,
                               const DistributedGrid& grid, const Options& options,
                               const GridApply& apply) {
  require_no_domain(options);
  Options all = options;
  all.particle_weights = {};
  const std::array<const void*, max_dimension> nowhere{};
  const PointsView<double> no_points(0, grid.all().dimension, nowhere, {});
  std::vector<FieldView<double>> no_fields;
  if (components > 0) no_fields.push_back({0, components, nullptr, 0, 0});
  GridMoments moments(no_points, no_fields, grid.owned(), all);
  require(sums.size() == moments.values().size(), "numbers of this rank's nodes", sums.size(),
          "must be those of the moments of each node of owned()");
  std::copy(sums.begin(), sums.end(), moments.values().begin());
  return moments.solve(apply);
}

namespace {

// From the particles that the nodes of a rank see, as reconstruct() has it.
GridReconstruction by_halos(const PointsView<double>& points,
                            const std::vector<FieldView<double>>& fields, int components,
                            const DistributedGrid& grid, const Options& options,
                            const GridApply& apply) {
  Options all = options.for_grid(grid.all());
  all.domain = grid.domain();
  const auto nodes = grid.owned().nodes();
  const Reconstruction fit(grid.communicator().get(), points, nodes.view(), all);
  const int dimension = grid.all().dimension;
  const auto rows = static_cast<Eigen::Index>(grid.owned().size());
  GridReconstruction::Matrix values(rows, components);
  GridReconstruction::Matrix gradients(apply.gradients ? rows : 0,
                                       apply.gradients ? components * dimension : 0);
  LimitCount limited;
  if (apply.limit != Limit::none) limited.components.assign(grid.owned().size(), 0);
  std::optional<Operator> slopes;
  if (apply.gradients) slopes = fit.gradient(*apply.gradients);
  Eigen::Index column = 0;
  for (const FieldView<double>& field : fields) {
    LimitCount of_field;
    values.middleCols(column, field.components()) =
        fit.apply(field, {.limit = apply.limit, .count = &of_field});
    for (std::size_t i = 0; i < limited.components.size(); ++i)
      limited.components[i] += of_field.components[i];
    if (slopes)
      gradients.middleCols(column * dimension, field.components() * dimension) =
          slopes->apply(field);
    column += field.components();
  }
  limited.total();
  return {std::move(values), std::move(gradients), fit.report(), std::move(limited)};
}

}  // namespace

GridReconstruction reconstruct_on_grid(const PointsView<double>& points,
                                       const std::vector<FieldView<double>>& fields,
                                       const DistributedGrid& grid, const Options& options,
                                       const GridApply& apply) {
  int components = 0;
  for (const FieldView<double>& field : fields) components += field.components();
  std::optional<GridMoments> moments;
  bool halos = false;
  grid.communicator().together([&] {
    options.validate();
    apply.validate();
    require_no_domain(options);
    halos = apply.limit != Limit::none || beyond_moments(grid.all(), options, apply);
  });
  grid.communicator().together(
      [&] {
        if (!halos) moments.emplace(moments_of_piece(points, fields, grid, options));
      },
      "degree, components of the fields, or whether moments are enough",
      {static_cast<double>(options.degree), static_cast<double>(components),
       static_cast<double>(fields.size()), static_cast<double>(halos)});
  if (halos) return by_halos(points, fields, components, grid, options, apply);
  const std::vector<double> sums = grid.sum(moments->values(), moments->per_node());
  moments.reset();
  GridReconstruction fit;
  grid.communicator().together([&] { fit = solve_owned(sums, components, grid, options, apply); });
  return fit;
}

}  // namespace recon::petsc
