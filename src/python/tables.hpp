// Tables of particles as Python objects.
#pragma once

#include <pybind11/pybind11.h>

#include "recon/fields/particle_table.hpp"

namespace recon::python {

// The table that an object is, or null.
const ParticleTable* table_of(pybind11::handle object);

}  // namespace recon::python
