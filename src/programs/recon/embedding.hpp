// Results in a plane or on a line of space, as VTK has it: always three axes.
//
// Fields in, say, x and z lie in ParaView where the particles are: the missing axis gets one node,
// at the coordinate that all particles share (0 where they share none), and vectors a third
// component, 0. Data in x, or x and y, are written as they are.
#pragma once

#include "particles.hpp"
#include "recon/fields/field_set.hpp"
#include "recon/points/structured_grid.hpp"

namespace recon::program {

// As write() does it, for .vti and .vtp.
void write_embedded(const std::string& path, const Particles& particles,
                    const StructuredGrid<double>& grid, const FieldSet& fields);
void write_embedded(const std::string& path, const Particles& particles,
                    const PointsView<double>& points, const FieldSet& fields);

}  // namespace recon::program
