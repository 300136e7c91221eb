// What --fields asks for: columns of the file, fields derived from them, and sums over kernels.
//
//   a column       mapped as it is
//   speed          sqrt(vx^2 + vy^2 + vz^2) of each particle, then mapped
//   velocity       vx, vy (, vz) as one field of several components
//   density, number_density, solid_fraction    kernel sums, see recon/operators/kernel_sum.hpp
//   all            every column of numbers but labels (id, type, image flags, ...) and coordinates
// A column of the file goes before a derived field of the same name.
#pragma once

#include <string>
#include <vector>

#include "particles.hpp"

namespace recon::program {

struct PlannedField {
  std::string name;
  std::vector<std::string> columns;  // of the particles, one per component; none for a kernel sum
  std::vector<double> amounts;       // of a kernel sum: what each particle contributes
  bool is_kernel_sum() const { return columns.empty(); }
};

using FieldPlan = std::vector<PlannedField>;

bool has_sums(const FieldPlan& plan);

// `fields` as --fields has it, `components` as each --components does ("v=vx,vy,vz"). Derived
// columns are added to the table of the particles.
FieldPlan plan_fields(Particles& particles, const std::string& fields,
                      const std::vector<std::string>& components);

// Columns that `all` stands for.
std::vector<std::string> mappable_columns(const Particles& particles);
// Derived fields that these particles have.
std::vector<std::string> derivable_fields(const Particles& particles);

}  // namespace recon::program
