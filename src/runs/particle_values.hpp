// The fields of particles that frames and probes show, by name.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "recon/fields/field_set.hpp"
#include "recon/mpm/problem.hpp"

namespace recon::mpm {

// put(p, to) writes the `components` numbers of particle p.
struct ParticleField {
  int components;
  std::function<void(std::size_t p, double* to)> put;
  NumberType type = NumberType::float64;
  FieldKind kind = FieldKind::scalars;
};

// All of particle_fields() (frames.hpp). Problem and particles must outlive them.
template <int D>
std::map<std::string, ParticleField> particle_fields_of(const Problem<D>& problem,
                                                        const Particles<D>& particles);

}  // namespace recon::mpm
