#include "recon/mpm/problem.hpp"

#include <algorithm>
#include <cmath>

#include "core/entries.hpp"
#include "mpm/modes.hpp"
#include "mpm/pointwise.hpp"

namespace recon::mpm {

namespace {
using recon::detail::require;
}  // namespace

void validate_density(double density) {
  require(density > 0 && std::isfinite(density), "density", density, "must be positive and finite");
}

void TimeOptions::validate() const {
  require(end > 0, "end", end, "must be positive");
  require(!courant || (*courant > 0 && std::isfinite(*courant)), "courant", courant.value_or(0),
          "must be positive and finite");
  require(rule != StepRule::fixed || (step > 0 && std::isfinite(step)), "step", step,
          "must be positive and finite");
  require(!rest || (*rest > 0 && *rest < 1), "tolerance", rest.value_or(0),
          "must lie between 0 and 1");
}

void Damping::validate() const {
  require(local >= 0 && local < 1, "local", local, "must be at least 0 and below 1");
  require(mass >= 0 && std::isfinite(mass), "mass", mass, "must be finite and not negative");
}

template <int D>
bool Boundary<D>::is_on_nodes(const Grid<D>& grid) const {
  const double plane = (at - grid.lower()[axis]) / grid.h(), nearest = std::round(plane);
  return std::abs(plane - nearest) < 1e-6 && nearest >= 0 && nearest <= grid.cells(axis);
}

template <int D>
int Boundary<D>::face(const Grid<D>& grid) const {
  const auto plane = std::lround((at - grid.lower()[axis]) / grid.h());
  return plane == 0 ? -1 : plane == grid.cells(axis) ? 1 : 0;
}

template <int D>
bool Boundary<D>::is_upper(const Grid<D>& grid) const {
  return 2 * at > grid.lower()[axis] + grid.upper(axis);
}

template <int D>
bool Boundary<D>::holds_all() const {
  for (const auto& value : velocity)
    if (!value) return false;
  return true;
}

namespace {

template <int D>
void validate_images(const Boundary<D>& boundary, const Grid<D>& grid) {
  const double at = boundary.at, lower = grid.lower()[boundary.axis],
               upper = grid.upper(boundary.axis);
  const double beyond = std::min(at - lower, upper - at) / grid.h();
  require(beyond >= image_cells - 1e-6, "at of a boundary with images", at,
          "must be a plane of nodes of the grid, or leave four cells of the grid beyond it for "
          "images of particles");
  require(std::abs(2 * at - lower - upper) > 2e-6 * grid.h(), "at of a boundary with images", at,
          "must be nearer to one face of the grid, beyond which no body lies");
  require((boundary.from.array() == -std::numeric_limits<double>::infinity()).all() &&
              (boundary.to.array() == std::numeric_limits<double>::infinity()).all(),
          "from of a boundary with images", boundary.from.transpose(),
          "must not be given: the whole plane has images");
  require(!boundary.symmetry, "symmetry of a boundary with images", "true",
          "must be that of its images");
  int given = 0;
  bool zero = true;
  for (const auto& value : boundary.velocity) {
    given += value ? 1 : 0;
    zero = zero && (!value || *value == 0.0);
  }
  require(zero && boundary.velocity[boundary.axis] && (given == 1 || given == D),
          "velocity of a boundary with images", "given",
          "must be zero along its axis, and zero or free along all others");
}

}  // namespace

template <int D>
void Boundary<D>::validate(const Grid<D>& grid) const {
  require(axis >= 0 && axis < D, "axis of a boundary", axis, "must be an axis of the grid");
  if (images) return validate_images(*this, grid);
  require(is_on_nodes(grid), "place of a boundary", at, "must be a plane of nodes of the grid");
  for (const auto& value : velocity)
    require(!value || value->varies() || std::isfinite((*value)({}, 0)), "velocity of a boundary",
            value && !value->varies() ? (*value)({}, 0) : 0, "must be finite");
  bool whole = true;
  for (int d = 0; d < D; ++d) {
    if (d == axis) continue;
    const double first = std::max(0.0, std::ceil((from[d] - grid.lower()[d]) / grid.h() - 1e-6));
    const double last = std::min(static_cast<double>(grid.cells(d)),
                                 std::floor((to[d] - grid.lower()[d]) / grid.h() + 1e-6));
    require(first <= last, "from of a boundary", from.transpose(),
            "must leave nodes of the plane between it and to");
    whole = whole && first == 0 && last == grid.cells(d);
  }
  if (!symmetry) return;
  require(face(grid) != 0, "place of a plane of symmetry", at, "must be a face of the grid");
  require(whole, "from of a plane of symmetry", from.transpose(),
          "must not leave out nodes: the whole face is one of symmetry");
  bool held = true;
  for (int d = 0; d < D; ++d) held = held && (d == axis ? velocity[d] == 0.0 : !velocity[d]);
  require(held, "velocity of a plane of symmetry", "given",
          "must be zero along the axis and free on the others");
}

template <int D>
void Load<D>::validate(std::size_t particles) const {
  require(particle < particles && force, "particle of a load", particle,
          "must be one of the particles, with a force");
  require(offset.allFinite(), "offset of a load", offset.transpose(), "must be finite");
  require(area.allFinite(), "area of a load", area.transpose(), "must be finite");
}

template <int D>
Kept Problem<D>::kept() const {
  Kept kept{method.domain == Domain::cpdi2, mode_count(method.velocity, D), 0};
  for (const Material& material : materials)
    kept.history = std::max(kept.history, history_of(material));
  return kept;
}

template <int D>
std::pair<double, double> Problem<D>::room(int axis) const {
  std::pair<double, double> room{grid.lower()[axis], grid.upper(axis)};
  if (periodic[axis]) {
    room.first += image_cells * grid.h();
    room.second -= image_cells * grid.h();
  }
  for (const Boundary<D>& boundary : boundaries)
    if (boundary.images && boundary.axis == axis)
      (boundary.is_upper(grid) ? room.second : room.first) = boundary.at;
  return room;
}

template <int D>
bool Problem<D>::has_images() const {
  return std::find(periodic.begin(), periodic.end(), true) != periodic.end() ||
         std::any_of(boundaries.begin(), boundaries.end(),
                     [](const Boundary<D>& each) { return each.images; });
}

namespace {

// What images need of boundaries and method.
template <int D>
void validate_images(const Problem<D>& problem) {
  if (!problem.has_images()) return;
  const Method& method = problem.method;
  require(method.mass == MassMatrix::lumped, "mass of the method", name_of(method.mass),
          "must be lumped where particles have images: nodes beyond the last of them would count "
          "in the solution");
  std::array<std::array<int, 2>, D> planes{};
  for (const Boundary<D>& boundary : problem.boundaries) {
    require(!problem.periodic[boundary.axis], "axis of a boundary", "xyz"[boundary.axis],
            "must not be periodic");
    if (!boundary.images) continue;
    require(++planes[boundary.axis][boundary.is_upper(problem.grid)] == 1,
            "at of a boundary with images", boundary.at,
            "must be the only one at this end of its axis");
    require(method.velocity != VelocityMap::polynomial, "velocity of the method",
            name_of(method.velocity),
            "must not be polynomial at a boundary with images: its coefficients belong to one "
            "place of the grid's cells; affine and all others can");
    require(D == 1 || !boundary.holds_all() || method.quadrature == Quadrature::particles,
            "quadrature of the method", name_of(method.quadrature),
            "must be over particles at a fixed boundary with images, whose stresses are no "
            "tensors of one material; a roller can");
  }
  for (int d = 0; d < D; ++d) {
    if (problem.periodic[d])
      require(problem.grid.cells(d) > 2 * image_cells, "cells of the grid along an axis",
              problem.grid.cells(d),
              "must be more than the eight beyond the ends of a period (periodic_grid)");
    const auto [from, to] = problem.room(d);
    require(from < to, "at of a boundary with images", to, "must leave room for bodies");
  }
}

}  // namespace

template <int D>
void Problem<D>::validate(const Particles<D>& all, bool complete) const {
  const std::size_t count = all.size();
  require(count > 0, "particles", count, "must be at least one");
  require(count < 0xffffffffu, "particles", count, "must be fewer than 2^32 - 1");
  all.arrays(kept(), [&](const ParticleArray& array, const auto& values) {
    if (array.kept && !complete && values.empty()) return;
    if (values.size() != count * array.per_particle)
      recon::detail::throw_invalid(std::string(array.name) + " of the particles", values.size(),
                                   "must be " + std::to_string(array.per_particle) +
                                       " for each of the " + std::to_string(count) + " positions" +
                                       (array.kept && !complete ? ", or none" : ""));
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!recon::detail::entries_finite(values[i])) [[unlikely]]
        recon::detail::throw_invalid(
            std::string(array.name) + " of particle " + std::to_string(i / array.per_particle),
            recon::detail::entries_text(values[i]), "must be finite");
  });
  const bool images = has_images();
  std::array<std::pair<double, double>, D> rooms;
  for (int d = 0; d < D; ++d) {
    const double margin = (periodic[d] ? 1e-6 : 0.5) * grid.h();
    rooms[d] = {room(d).first - margin, room(d).second + margin};
  }
  for (std::size_t p = 0; p < count; ++p) {
    // One text for what is wrong with a particle.
    const auto of = [&](bool holds, const char* what, const auto& value, const char* rule) {
      if (!holds) [[unlikely]]
        recon::detail::throw_invalid(std::string(what) + " of particle " + std::to_string(p), value,
                                     rule);
    };
    of(grid.contains(all.x[p]), "position", all.x[p].transpose(), "must lie in the grid");
    for (int d = 0; d < D && images; ++d)
      of(all.x[p][d] >= rooms[d].first && all.x[p][d] <= rooms[d].second, "position",
         all.x[p].transpose(),
         "must lie in the period and not beyond a boundary with images by more than half a cell");
    of(all.mass[p] > 0, "mass", all.mass[p], "must be positive");
    of(all.volume0[p] > 0, "volume0", all.volume0[p], "must be positive");
    of(all.F[p].determinant() > 0, "det F", all.F[p].determinant(), "must be positive");
    of(all.half_edges[p].determinant() != 0, "half_edges", all.half_edges[p].determinant(),
       "must span a volume");
    of(all.body[p] >= 0 && static_cast<std::size_t>(all.body[p]) < materials.size(), "body",
       all.body[p], "must be the number of a material");
  }
}

template <int D>
void Problem<D>::validate() const {
  for (int d = 0; d < D; ++d)
    require(grid.cells(d) >= 1, "cells of the grid along an axis", grid.cells(d),
            "must be at least one");
  require(materials.size() == densities.size(), "densities", densities.size(),
          "must be one for each material");
  require(gravity.allFinite(), "gravity", gravity.transpose(), "must be finite");
  require(threads >= 0 && threads <= 1024, "threads", threads, "must be from 0 (all) to 1024");
  method.validate(D);
  if (is_element(method.basis))
    for (int d = 0; d < D; ++d)
      require(grid.cells(d) % 2 == 0, "cells of the grid along an axis", grid.cells(d),
              "must be even with elements of 2 x 2 cells");
  for (const Material& material : materials) validate_material(material);
  for (const double density : densities) validate_density(density);
  for (const Boundary<D>& boundary : boundaries) {
    boundary.validate(grid);
    for (const auto& value : boundary.velocity)
      require(!value || !value->varies() || method.mass == MassMatrix::lumped, "mass of the method",
              name_of(method.mass),
              "must be lumped where a boundary holds a velocity that varies: forces on the free "
              "nodes would depend on accelerations of the held ones");
  }
  validate_images(*this);
  validate(particles);
  for (const Load<D>& load : loads) load.validate(particles.size());
  damping.validate();
  time.validate();
}

template <int D>
TimeStep choose_step(const Problem<D>& problem, const Particles<D>& particles) {
  const TimeOptions& time = problem.time;
  if (time.rule == StepRule::fixed) return {time.step, 0};
  const double courant = time.courant.value_or(problem.method.default_courant(D));
  TimeStep slowest{std::numeric_limits<double>::infinity(), 0};
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const Lame& elastic = lame(problem.materials[particles.body[p]]);
    const double speed = fastest(time.rule, elastic, particles.mass[p], particles.volume0[p],
                                 particles.F[p].determinant(), particles.v[p].norm());
    const double dt = courant * problem.grid.h() / speed;
    if (dt < slowest.dt) slowest = {dt, p};
  }
  return slowest;
}

template <int D>
double courant_of(const Problem<D>& problem, const Particles<D>& particles, double dt) {
  double fastest = 0;
  for (std::size_t p = 0; p < particles.size(); ++p)
    fastest = std::max(
        fastest, lame(problem.materials[particles.body[p]]).p_wave_speed(particles.density(p)) +
                     particles.v[p].norm());
  return fastest * dt / problem.grid.h();
}

#define RECON_INSTANTIATE(D)                                             \
  template struct Boundary<D>;                                           \
  template struct Load<D>;                                               \
  template struct Problem<D>;                                            \
  template TimeStep choose_step(const Problem<D>&, const Particles<D>&); \
  template double courant_of(const Problem<D>&, const Particles<D>&, double);
RECON_INSTANTIATE(1)
RECON_INSTANTIATE(2)
RECON_INSTANTIATE(3)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
