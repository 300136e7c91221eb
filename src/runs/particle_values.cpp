#include "runs/particle_values.hpp"

#include <cmath>
#include <limits>

#include "recon/runs/frames.hpp"
#include "runs/material_keys.hpp"

namespace recon::mpm {
namespace {

using Tensor = Eigen::Matrix<double, 3, 3>;

// With `beyond` on the diagonal along the axes that the problem does not have.
template <int D>
Tensor full(const Matrix<D>& matrix, double beyond) {
  Tensor out = beyond * Tensor::Identity();
  out.template topLeftCorner<D, D>() = matrix;
  return out;
}

template <int D>
Tensor full_stress(const Problem<D>& problem, const Particles<D>& particles, std::size_t p) {
  double beyond = 0;
  if constexpr (D < 3)
    beyond = std::visit(
        [&](const auto& material) {
          if constexpr (history_of<std::decay_t<decltype(material)>>() > 0) {
            const std::size_t history = particles.history.size() / particles.size();
            return material.template out_of_plane<D>(particles.F[p], particles.stress[p],
                                                     &particles.history[p * history]);
          } else {
            return material.template out_of_plane<D>(particles.F[p], particles.stress[p]);
          }
        },
        problem.materials[static_cast<std::size_t>(particles.body[p])]);
  return full<D>(particles.stress[p], beyond);
}

// The names of the history variables of all materials.
std::vector<std::string> history_fields() {
  std::vector<std::string> names;
  for_each_material([&]<class M>(const M&) {
    if constexpr (history_of<M>() > 0)
      names.insert(names.end(), M::history.begin(), M::history.end());
  });
  return names;
}

// NaN where the particle's material has no such variable.
template <int D>
double remembered(const Problem<D>& problem, const Particles<D>& particles, std::size_t p,
                  std::string_view name) {
  double value = std::numeric_limits<double>::quiet_NaN();
  const auto find = [&]<class M>(const M&) {
    const std::size_t history = particles.history.size() / particles.size();
    for (std::size_t i = 0; i < history_of<M>(); ++i)
      if constexpr (history_of<M>() > 0)
        if (M::history[i] == name) value = particles.history[p * history + i];
  };
  std::visit(find, problem.materials[static_cast<std::size_t>(particles.body[p])]);
  return value;
}

double pressure(const Tensor& stress) {
  return -stress.trace() / 3;
}

double von_mises(const Tensor& stress) {
  return std::sqrt(1.5) * (stress + pressure(stress) * Tensor::Identity()).norm();
}

}  // namespace

template <int D>
std::map<std::string, ParticleField> particle_fields_of(const Problem<D>& problem,
                                                        const Particles<D>& particles) {
  const auto number = [](const auto& get) {
    return ParticleField{1, [get](std::size_t p, double* to) { *to = get(p); }};
  };
  const auto whole = [](const auto& get) {
    return ParticleField{1, [get](std::size_t p, double* to) { *to = get(p); }, NumberType::int32};
  };
  const auto vector = [](const auto& get) {
    return ParticleField{D,
                         [get](std::size_t p, double* to) {
                           const Vector<D> value = get(p);
                           for (int d = 0; d < D; ++d) to[d] = value[d];
                         },
                         NumberType::float64, FieldKind::vector};
  };
  const auto tensor = [](const auto& get) {
    return ParticleField{9,
                         [get](std::size_t p, double* to) {
                           const Tensor value = get(p);
                           for (int c = 0; c < 9; ++c) to[c] = value(c / 3, c % 3);
                         },
                         NumberType::float64, FieldKind::tensor};
  };
  const auto stress = [&](std::size_t p) { return full_stress(problem, particles, p); };
  std::map<std::string, ParticleField> fields{
      {"velocity", vector([&](std::size_t p) { return particles.v[p]; })},
      {"displacement",
       vector([&](std::size_t p) -> Vector<D> { return particles.x[p] - particles.X[p]; })},
      {"stress", tensor(stress)},
      {"von_mises", number([=](std::size_t p) { return von_mises(stress(p)); })},
      {"pressure", number([=](std::size_t p) { return pressure(stress(p)); })},
      {"F", tensor([&](std::size_t p) { return full<D>(particles.F[p], 1); })},
      {"det_F", number([&](std::size_t p) { return particles.F[p].determinant(); })},
      {"density", number([&](std::size_t p) { return particles.density(p); })},
      {"mass", number([&](std::size_t p) { return particles.mass[p]; })},
      {"volume", number([&](std::size_t p) { return particles.volume(p); })},
      {"body", whole([&](std::size_t p) { return particles.body[p]; })},
      {"id", whole([](std::size_t p) { return static_cast<double>(p); })},
      {"velocity_gradient", tensor([&](std::size_t p) { return full<D>(particles.L[p], 0); })},
      {"energy", number([&](std::size_t p) { return particles.energy[p]; })},
  };
  for (const std::string& name : history_fields())
    fields.emplace(
        name, number([&, name](std::size_t p) { return remembered(problem, particles, p, name); }));
  return fields;
}

std::vector<std::string> default_particle_fields() {
  return {"velocity", "displacement", "stress", "von_mises", "pressure", "F",
          "det_F",    "density",      "mass",   "volume",    "body",     "id"};
}

std::span<const std::string> particle_fields() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all = default_particle_fields();
    all.insert(all.end(), {"velocity_gradient", "energy"});
    for (const std::string& name : history_fields()) all.push_back(name);
    return all;
  }();
  return names;
}

template std::map<std::string, ParticleField> particle_fields_of(const Problem<1>&,
                                                                 const Particles<1>&);
template std::map<std::string, ParticleField> particle_fields_of(const Problem<2>&,
                                                                 const Particles<2>&);
template std::map<std::string, ParticleField> particle_fields_of(const Problem<3>&,
                                                                 const Particles<3>&);

}  // namespace recon::mpm
