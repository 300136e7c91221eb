#include "recon/petsc/reconstruct.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "petsc/halo.hpp"

namespace recon::petsc {
namespace {

using detail::require;
using Matrix = Operator::Matrix;

void require_halo_suffices(const Options& options) {
  const NeighbourRule& rule = *options.neighbours;
  const bool known = std::holds_alternative<Radius>(rule) || std::holds_alternative<Radii>(rule) ||
                     std::holds_alternative<Nearest>(rule) ||
                     std::holds_alternative<NearestWithin>(rule);
  require(known, "neighbours", "radii or tensors of pairs, or ellipsoids",
          "must be Radius, Radii, Nearest or NearestWithin where particles are spread over ranks");
  require(!options.visible, "visible", "a function",
          "must not be said where particles are spread over ranks");
  require(options.unsupported == Unsupported::fill, "unsupported", "nearest",
          "must be fill where particles are spread over ranks");
  require(!std::isfinite(options.max_distance), "max_distance", options.max_distance,
          "must be infinite where particles are spread over ranks");
}

double positive(double radius) {
  require(radius > 0 && std::isfinite(radius), "support radius", radius,
          "must be positive and finite");
  return radius;
}

// The farthest that a support can reach, before stretch; 0 for Nearest: only the search can tell.
double reach_of(const Options& options, std::size_t targets) {
  const double grown = std::pow(std::max(1.0, options.grow.factor), options.grow.steps);
  if (const auto* radius = std::get_if<Radius>(&*options.neighbours))
    return positive(radius->radius) * grown;
  if (const auto* within = std::get_if<NearestWithin>(&*options.neighbours))
    return positive(within->radius) * grown;
  if (const auto* radii = std::get_if<Radii>(&*options.neighbours)) {
    require(radii->radii.size() == targets, "number of radii", radii->radii.size(),
            "must be that of the targets of this rank");
    double largest = 0;
    for (std::size_t t = 0; t < targets; ++t)
      largest = std::max(largest, positive(radii->radii[t]));
    return largest * grown;
  }
  return 0;
}

// How many of the nearest a target may ask for, grown supports included.
std::size_t most_neighbours(const Nearest& nearest, const Growth& grow) {
  const double grown = std::pow(std::max(1.0, grow.factor), grow.steps);
  return static_cast<std::size_t>(std::ceil(static_cast<double>(nearest.k) * grown)) +
         static_cast<std::size_t>(grow.steps);
}

struct Extent {
  Box<double> box;   // of the particles of all ranks, in stretched coordinates
  double count = 0;  // of them
};

Extent extent_of(const Communicator& ranks, const Box<double>& own, std::size_t count,
                 const std::array<double, max_dimension>& stretch) {
  Extent all{own, static_cast<double>(ranks.sum(static_cast<long long>(count)))};
  for (int d = 0; d < own.dimension; ++d) {
    all.box.upper[d] = ranks.largest(own.upper[d] / stretch[d]);
    all.box.lower[d] = -ranks.largest(-own.lower[d] / stretch[d]);
  }
  return all;
}

// A distance within which there are about k particles, were they even: a guess to begin with.
double guessed_reach(const Extent& all, double k) {
  double volume = 1, longest = 0;
  int axes = 0;
  for (int d = 0; d < all.box.dimension; ++d) {
    const double length = all.box.extent(d);
    if (!(length > 0 && std::isfinite(length))) continue;
    longest = std::max(longest, length);
    volume *= length;
    ++axes;
  }
  if (axes == 0) return 1;
  const double spacing = std::pow(volume * k / std::max(1.0, all.count), 1.0 / axes);
  return std::max(1.5 * spacing, 1e-6 * longest);
}

Need need_of(const Box<double>& targets, bool any, double reach, const Options& options) {
  Need need;
  need.any = any;
  for (int d = 0; d < targets.dimension && any; ++d) {
    const double wide = reach * options.stretch[d];
    // More than rounding of coordinates and distances; the search decides.
    const double margin = 1e-12 * (wide + std::abs(targets.lower[d]) + std::abs(targets.upper[d]));
    need.lower[d] = targets.lower[d] - wide - margin;
    need.upper[d] = targets.upper[d] + wide + margin;
  }
  return need;
}

std::vector<double> rows_of(const FieldView<double>& field, const char* points) {
  const auto width = static_cast<std::size_t>(field.components());
  std::vector<double> rows(field.size() * width);
  for (std::size_t p = 0; p < field.size(); ++p)
    for (int c = 0; c < field.components(); ++c) {
      const double value = field(p, c);
      if (!std::isfinite(value))
        detail::throw_invalid(
            "component " + std::to_string(c) + " of " + points + " " + std::to_string(p), value,
            "must be finite");
      rows[p * width + static_cast<std::size_t>(c)] = value;
    }
  return rows;
}

FieldView<double> view_of(const std::vector<double>& rows, int width) {
  constexpr std::ptrdiff_t step = sizeof(double);
  return {rows.size() / static_cast<std::size_t>(width), width, rows.data(), step * width, step};
}

// A halo, and what it has brought: a row for each particle, its place and, where there are any, its
// weight.
struct Brought {
  std::shared_ptr<Halo> halo;
  std::vector<double> rows;
  int dimension, width;

  Brought(std::shared_ptr<Halo> of, std::span<const double> own, int axes, bool weighted)
      : halo(std::move(of)), dimension(axes), width(axes + (weighted ? 1 : 0)) {
    rows = halo->spread(own, width);
  }
  PointsView<double> cloud() const {
    const std::ptrdiff_t step = static_cast<std::ptrdiff_t>(sizeof(double)) * width;
    std::array<const void*, max_dimension> first{};
    for (int d = 0; d < dimension && halo->all() > 0; ++d) first[d] = rows.data() + d;
    return {halo->all(), dimension, first, {step, step, step}};
  }
  std::vector<double> weights() const {
    std::vector<double> all;
    for (std::size_t p = 0; p < halo->all() && width > dimension; ++p)
      all.push_back(
          rows[p * static_cast<std::size_t>(width) + static_cast<std::size_t>(dimension)]);
    return all;
  }
};

// A field at all particles that a rank works with, and with Limit::relaxed the bounds of all ranks'
// data. Collective.
struct BroughtField {
  std::vector<double> all;
  std::vector<DataBounds> bounds;

  BroughtField(const Halo& halo, const FieldView<double>& field, Limit limit) {
    std::vector<double> own;
    halo.ranks().together(
        [&] {
          detail::require_limit(limit);
          require(field.size() == halo.own(), "values of the field", field.size(),
                  "must be one for each particle of this rank");
          own = rows_of(field, "particle");
        },
        "components of the field, or limit",
        {static_cast<double>(field.components()), static_cast<double>(limit)});
    const auto width = static_cast<std::size_t>(field.components());
    for (std::size_t c = 0; c < width && limit == Limit::relaxed; ++c) {
      detail::DataRange<double> range;
      for (std::size_t at = c; at < own.size(); at += width) range.add(own[at]);
      const double least = -halo.ranks().largest(-range.least);
      const double greatest = halo.ranks().largest(range.greatest);
      if (least <= greatest) bounds.push_back({least, greatest});  // else no rank has particles
    }
    all = halo.spread(own, field.components());
  }
};

// Whether there are as many particles as a target may ask for, or all there are.
bool can_suffice(const Halo& halo, const Options& options) {
  const auto* nearest = std::get_if<Nearest>(&*options.neighbours);
  return !nearest || halo.all() == static_cast<std::size_t>(halo.total()) ||
         halo.all() >= most_neighbours(*nearest, options.grow);
}

// Whether the k nearest of all targets were there: none can lie farther than what was asked for.
bool sufficed(const Halo& halo, const recon::Reconstruction& fit, int dimension,
              std::size_t targets, double reach, const Options& options) {
  if (!std::holds_alternative<Nearest>(*options.neighbours) ||
      halo.all() == static_cast<std::size_t>(halo.total()))
    return true;
  const bool cube = options.form == WeightForm::tensor_product;
  const double diagonal = cube ? std::sqrt(static_cast<double>(dimension)) : 1;
  for (std::size_t t = 0; t < targets; ++t)
    if (!(fit.support(t) * diagonal <= reach)) return false;
  return true;
}

}  // namespace

Reconstruction::Reconstruction(MPI_Comm comm, const PointsView<double>& points,
                               const PointsView<double>& targets, const Options& options) {
  const Communicator ranks(comm);
  Options all = options;
  Box<double> box, own_box;
  std::vector<double> own;
  double reach = 0;
  const int dimension = points.dimension();
  const bool weighted = ranks.largest(options.particle_weights.empty() ? 0 : 1) > 0;
  ranks.together(
      [&] {
        options.validate();
        require(targets.dimension() == dimension, "dimension of the targets", targets.dimension(),
                "must be that of the points");
        all = options.for_points(dimension);
        all.domain.validate(dimension);
        require_halo_suffices(all);
        const PointCloud<double> cloud(points, "points", all.domain);
        own_box = cloud.box();
        box = PointCloud<double>(targets, "targets", all.domain).box();
        reach = reach_of(all, targets.size());
        const std::size_t weights = options.particle_weights.size();
        require(weights == (weighted ? points.size() : 0), "number of particle_weights", weights,
                "must be that of the points, on all ranks or on none");
        for (std::size_t p = 0; p < points.size(); ++p) {
          for (int d = 0; d < dimension; ++d) own.push_back(points(p, d));
          if (!weighted) continue;
          const double weight = options.particle_weights[p];
          if (!(weight > 0 && std::isfinite(weight)))
            detail::throw_invalid("particle_weights of particle " + std::to_string(p), weight,
                                  "must be positive and finite");
          own.push_back(weight);
        }
      },
      "dimension, degree, kind of neighbours, stretch or domain",
      {static_cast<double>(dimension), static_cast<double>(options.degree),
       options.neighbours ? static_cast<double>(options.neighbours->index()) : -1,
       options.stretch[0], options.stretch[1], options.stretch[2],
       static_cast<double>(options.domain.periodic[0]),
       static_cast<double>(options.domain.periodic[1]),
       static_cast<double>(options.domain.periodic[2]), options.domain.lower[0],
       options.domain.lower[1], options.domain.lower[2], options.domain.upper[0],
       options.domain.upper[1], options.domain.upper[2]});

  if (const auto* nearest = std::get_if<Nearest>(&*all.neighbours)) {
    const Extent extent = extent_of(ranks, own_box, points.size(), all.stretch);
    reach = guessed_reach(extent, static_cast<double>(most_neighbours(*nearest, all.grow))) *
            std::max(1.0, nearest->factor);
  }
  for (int round = 1;; ++round) {
    const Brought brought(
        std::make_shared<Halo>(ranks, points, need_of(box, targets.size() > 0, reach, all),
                               all.domain),
        own, dimension, weighted);
    bool enough = targets.size() == 0 || can_suffice(*brought.halo, all);
    ranks.together([&] {
      if (!enough) return;
      const std::vector<double> weights = brought.weights();
      Options local = all;
      local.particle_weights = weights;
      local_ = recon::Reconstruction(brought.cloud(), targets, local);
      enough = sufficed(*brought.halo, local_, dimension, targets.size(), reach, all);
    });
    if (ranks.largest(enough ? 0 : 1) > 0) {
      if (!enough) reach *= 2;
      continue;
    }
    halo_ = brought.halo;
    brought.halo->rounds = round;
    return;
  }
}

std::size_t Reconstruction::halo_size() const {
  return halo_->all() - halo_->own();
}
int Reconstruction::halo_rounds() const {
  return halo_->rounds;
}

Matrix Operator::apply(const FieldView<double>& field) const {
  const BroughtField data(*halo_, field, Limit::none);
  Matrix out;
  halo_->ranks().together([&] { out = local_.apply(view_of(data.all, field.components())); });
  return out;
}

Matrix Reconstruction::apply(const FieldView<double>& field, const Apply& how) const {
  const BroughtField data(*halo_, field, how.limit);
  Matrix out;
  halo_->ranks().together([&] {
    Apply local = how;
    local.bounds = data.bounds;
    out = local_.apply(view_of(data.all, field.components()), local);
  });
  return out;
}

Matrix Operator::apply_transpose(const FieldView<double>& field) const {
  std::vector<double> sums;
  const int width = field.components() / blocks();
  halo_->ranks().together(
      [&] {
        require(field.components() % blocks() == 0 && width > 0, "components of the field",
                field.components(), "must be a multiple of the numbers per entry");
        require(field.size() == rows(), "values of the field", field.size(),
                "must be one for each target of this rank");
        const Matrix rows = local_.apply_transpose(field);
        sums.resize(halo_->all() * static_cast<std::size_t>(width));
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            sums.data(), static_cast<Eigen::Index>(halo_->all()), width) = rows;
      },
      "components of the field", {static_cast<double>(field.components())});
  const std::vector<double> own = halo_->gather(sums, width);
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      own.data(), static_cast<Eigen::Index>(halo_->own()), width);
}

std::vector<Operator::Entry> Operator::row(std::size_t target) const {
  const auto local = local_.row(target);
  std::vector<Entry> entries;
  for (std::size_t e = 0; e < local.size(); ++e) {
    Entry& entry = entries.emplace_back();
    entry.particle = halo_->ids()[local.particle(e)];
    for (int b = 0; b < blocks(); ++b) entry.values.push_back(local.value(e, b));
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.particle < b.particle; });
  return entries;
}

}  // namespace recon::petsc
