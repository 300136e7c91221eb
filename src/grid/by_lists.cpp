#include "grid/by_lists.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "core/instantiate.hpp"
#include "recon/core/progress.hpp"
#include "recon/neighbourhood/find_neighbours_with.hpp"
#include "recon/operators/reconstruct.hpp"

namespace recon {
namespace {

constexpr std::size_t nodes_at_once = 4096;

template <class Scalar>
using Matrix = typename BasicGridReconstruction<Scalar>::Matrix;

// The nodes first .. first + count - 1 of a grid.
template <class Scalar>
class Nodes {
 public:
  explicit Nodes(const StructuredGrid<Scalar>& grid) : grid_(grid) {}

  PointsView<Scalar> at(std::size_t first, std::size_t count) {
    for (int d = 0; d < grid_.dimension; ++d) axes_[d].resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto index = grid_.index(first + i);
      for (int d = 0; d < grid_.dimension; ++d) axes_[d][i] = grid_.coordinate(index[d], d);
    }
    return points_of_axes(axes_, grid_.dimension);
  }

 private:
  const StructuredGrid<Scalar>& grid_;
  std::array<std::vector<Scalar>, max_dimension> axes_;
};

// Rows `first` and on, of `components` columns from `column` on.
template <class Scalar>
FieldSpan<Scalar> part_of(Matrix<Scalar>& matrix, std::size_t first, std::size_t count, int column,
                          int components) {
  constexpr auto size = static_cast<std::ptrdiff_t>(sizeof(Scalar));
  const auto rows = static_cast<std::ptrdiff_t>(matrix.rows());
  return {count, components, matrix.data() + column * rows + static_cast<std::ptrdiff_t>(first),
          size, rows * size};
}

// The rule for some of the targets.
NeighbourRule part_of(const NeighbourRule& rule, std::size_t first, std::size_t count) {
  if (const auto* own = std::get_if<Radii>(&rule)) return Radii{own->radii.subspan(first, count)};
  if (const auto* own = std::get_if<Ellipsoids>(&rule))
    return Ellipsoids{own->tensors.part(first, count)};
  if (const auto* pairs = std::get_if<PairEllipsoids>(&rule); pairs && pairs->targets.size() > 0)
    return PairEllipsoids{pairs->particles, pairs->targets.part(first, count), pairs->support};
  const auto* pairs = std::get_if<PairRadii>(&rule);
  if (!pairs || pairs->targets.empty()) return rule;
  return PairRadii{pairs->particles, pairs->targets.subspan(first, count), pairs->support};
}

// Messages about targets speak of those in hand.
template <class Apply>
void with_place(std::size_t first, std::size_t field, std::size_t fields, const Apply& apply) {
  try {
    apply();
  } catch (const InvalidArgument& error) {
    std::string place = fields > 1 ? " (field " + std::to_string(field) : "";
    if (first > 0)
      place += (place.empty() ? " (" : ", ") +
               ("target 0 is node " + std::to_string(first) + " of the grid");
    if (place.empty()) throw;
    throw InvalidArgument(error.argument() + place + ")", error.value(), error.rule());
  }
}

}  // namespace

template <class Scalar>
BasicGridReconstruction<Scalar> by_lists(const BasicSources<Scalar>& sources,
                                         const std::vector<FieldView<Scalar>>& fields,
                                         const StructuredGrid<Scalar>& grid, Options options,
                                         const GridApply& apply) {
  const std::size_t nodes = grid.size();
  detail::require_valid_rule<Scalar>(*options.neighbours, grid.dimension, nodes, sources.size());
  options.domain = {};  // the Sources have it, and the stretch and the weights
  options.stretch = SourcesOptions{}.stretch;
  options.particle_weights = {};
  std::size_t first = 0;
  if (options.visible)
    options.visible = [&first, visible = options.visible](std::size_t t, std::size_t p) {
      return visible(first + t, p);
    };
  const NeighbourRule rule = *options.neighbours;

  int components = 0;
  for (const auto& field : fields) components += field.components();
  const int D = grid.dimension;
  const auto rows = static_cast<Eigen::Index>(nodes);
  Matrix<Scalar> values(rows, components);
  Matrix<Scalar> gradients(apply.gradients ? rows : 0, apply.gradients ? components * D : 0);
  std::vector<FitReport> reports;
  reports.reserve(nodes);
  LimitCount limited;
  if (apply.limit != Limit::none) limited.components.assign(nodes, 0);

  // Each part is told of as its share of the whole.
  const Progress whole = options.progress;
  std::size_t count = 0;
  auto told = std::chrono::steady_clock::now();
  const auto tell = [&](double of_part) {
    told = std::chrono::steady_clock::now();
    return whole((static_cast<double>(first) + of_part * static_cast<double>(count)) /
                 static_cast<double>(nodes));
  };
  if (whole) options.progress = tell;

  Nodes<Scalar> places(grid);
  std::optional<BasicReconstruction<Scalar>> fit;
  for (; first < nodes; first += nodes_at_once) {
    count = std::min(nodes_at_once, nodes - first);
    const PointsView<Scalar> at = places.at(first, count);
    options.neighbours = part_of(rule, first, count);
    if (fit)
      fit->update(at, *options.neighbours);
    else
      fit.emplace(sources, at, options);
    const auto& of_these = fit->report().all();
    reports.insert(reports.end(), of_these.begin(), of_these.end());
    CsrOperator<Scalar> slopes;
    if (apply.gradients) slopes = fit->gradient(*apply.gradients);
    int column = 0;
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const int width = fields[f].components();
      LimitCount count_of_these;
      with_place(first, f, fields.size(), [&] {
        fit->apply(fields[f], part_of<Scalar>(values, first, count, column, width),
                   {.limit = apply.limit, .count = &count_of_these});
        if (apply.gradients)
          slopes.apply(fields[f], part_of<Scalar>(gradients, first, count, column * D, width * D));
      });
      for (std::size_t t = 0; t < count && apply.limit != Limit::none; ++t)
        limited.components[first + t] += count_of_these.components[t];
      column += width;
    }
    const bool due = std::chrono::steady_clock::now() - told > std::chrono::milliseconds(100);
    if (whole && due && first + count < nodes && !tell(1)) throw Cancelled();
  }
  limited.total();
  return {std::move(values), std::move(gradients), FitReports(std::move(reports), *options.solver),
          std::move(limited)};
}

template GridReconstruction by_lists(const Sources&, const std::vector<FieldView<double>>&,
                                     const StructuredGrid<double>&, Options, const GridApply&);
RECON_FLOAT(template GridReconstructionF by_lists(const SourcesF&,
                                                  const std::vector<FieldView<float>>&,
                                                  const StructuredGrid<float>&, Options,
                                                  const GridApply&);)

}  // namespace recon
