#include "gpu/plan.hpp"

#include <map>
#include <utility>

#include "mpm/policies.hpp"
#include "recon/gpu/run.hpp"

namespace recon::mpm {
namespace {

bool fits(const Method& method) {
  return is_fit(method.velocity) || method.quadrature == Quadrature::cells;
}

// Calls no(argument, value, those that have a form) for the first choice of a method without one.
template <class No>
void find_lacking(const Method& method, const No& no) {
  const auto has = [&]<class Enum>(const char* key, Enum value, std::initializer_list<Enum> with) {
    std::string others;
    for (const Enum each : with) {
      if (each == value) return true;
      others += (others.empty() ? "" : ", ") + std::string(name_of(each));
    }
    no(std::string(key) + " of the method", std::string(name_of(value)), others);
    return false;
  };
  has("domain", method.domain, {Domain::point, Domain::cpdi2}) &&
      has("basis", method.basis,
          {Basis::linear, Basis::bspline2, Basis::bspline3, Basis::mls_bspline2}) &&
      has("velocity", method.velocity,
          {VelocityMap::mass_weighted, VelocityMap::mls, VelocityMap::affine}) &&
      has("quadrature", method.quadrature, {Quadrature::particles, Quadrature::cells}) &&
      has("update", method.update, {Update::flip, Update::pic}) &&
      has("mass", method.mass, {MassMatrix::lumped});
  if (!fits(method)) return;
  if (method.degree != 1) no("degree of the method", std::to_string(method.degree), "1");
  if (method.momentum_correction && !method.keeps_momentum())
    no("momentum_correction of the method", "true", "false");
  if (method.quadrature == Quadrature::cells && method.at_negative_mass == AtNegativeMass::stop)
    no("negative_mass of the method", "stop", "report");
}

}  // namespace

std::vector<std::string> methods_on_gpu() {
  std::vector<std::string> names;
  for (const Method& method : methods()) {
    bool lacks = false;
    find_lacking(method, [&](const auto&...) { lacks = true; });
    if (!lacks) names.push_back(method.name);
  }
  return names;
}

template <int D>
void require_form_on_gpu(const Problem<D>& problem) {
  find_lacking(problem.method,
               [](const std::string& argument, const std::string& value, const std::string& with) {
                 std::string methods;
                 for (const std::string& name : methods_on_gpu())
                   methods += (methods.empty() ? "" : ", ") + name;
                 recon::detail::throw_invalid(argument, value,
                                              "has no form for a GPU; those that have: " + with +
                                                  "; methods that have: " + methods);
               });
  const auto lacks = [](const char* argument, const auto& value, const char* rule) {
    recon::detail::throw_invalid(argument, value, std::string("has no form for a GPU: ") + rule);
  };
  for (int d = 0; d < D; ++d)
    if (problem.periodic[static_cast<std::size_t>(d)])
      lacks("periodic of the grid", std::string(1, "xyz"[d]), "no axis may be periodic");
  for (const Boundary<D>& boundary : problem.boundaries)
    if (boundary.images)
      lacks("images of a boundary", boundary.at, "boundaries must be planes of nodes");
  for (const Boundary<D>& boundary : problem.boundaries)
    if (boundary.symmetry && fits(problem.method))
      lacks("symmetry of a boundary", boundary.at, "fits do not see images of particles there");
  if (problem.body_force)
    lacks("body_force", "given", "of forces on bodies only gravity that is constant has one");
  if (!problem.loads.empty())
    lacks("loads", problem.loads.size(), "there must be no forces on surfaces and particles");
}

template <int D>
Plan<D>::Plan(const Problem<D>& problem)
    : nodes(problem.grid.nodes()),
      centres(cell_centres(problem.grid.nodes())),
      kept(problem.kept()),
      method(problem.method),
      time(problem.time),
      damping(problem.damping),
      courant(problem.time.courant.value_or(problem.method.default_courant(D))),
      materials(problem.materials) {
  const Grid<D>& whole = problem.grid;
  grid.h_ = whole.h();
  grid.inverse_h_ = whole.inverse_h();
  for (int d = 0; d < D; ++d) {
    grid.lower_[d] = whole.lower()[d];
    grid.cells_[d] = whole.cells(d);
    gravity[d] = problem.gravity[d];
  }
  const BoundaryPolicy<D> boundaries(problem);
  for (const Boundary<D>* boundary : boundaries.walls()) {
    const int axis = boundary->axis;
    const bool upper = boundary->face(whole) > 0;
    WallNumbers<D> wall{axis, upper, upper ? whole.upper(axis) : whole.lower()[axis], {}, {}};
    for (int d = 0; d < D; ++d) {
      wall.from[d] = boundary->from[d];
      wall.to[d] = boundary->to[d];
    }
    walls.push_back(wall);
  }
  // Of boundaries that hold the same component the last one counts, as in a loop over them.
  struct Given {
    HeldVelocity<D> velocity;
    Vector<D> x;
  };
  std::map<std::pair<std::uint32_t, int>, Given> last;
  for (const HeldComponent<D>& each : boundaries.held_in(whole, {}))
    last.insert_or_assign({each.node, each.axis}, Given{*each.velocity, each.x});
  std::vector<Given> given;
  for (const auto& [place, one] : last) {
    held.push_back({place.first, place.second, one.velocity.varies()});
    given.push_back(one);
  }
  held_velocities = [given = std::move(given)](double t) {
    std::vector<double> velocities;
    for (const Given& each : given) velocities.push_back(each.velocity(each.x, t));
    return velocities;
  };
}

#define RECON_INSTANTIATE(D) \
  template struct Plan<D>;   \
  template void require_form_on_gpu(const Problem<D>&);
RECON_DIMENSIONS(RECON_INSTANTIATE)
#undef RECON_INSTANTIATE

}  // namespace recon::mpm
