// From particles to fields at targets, part by part, so that memory does not grow with the targets.
#pragma once

#include "field_plan.hpp"
#include "fit_choice.hpp"
#include "particles.hpp"
#include "programs/common/progress.hpp"
#include "recon/fields/field_set.hpp"
#include "recon/operators/fit_summary.hpp"

namespace recon::program {

struct Mapped {
  // In the order of the plan, each followed by its gradients; then the reports: neighbours, rank,
  // degree, status (0 full, 1 reduced, 2 nearest, 3 no_support, 4 too_far), smallest_pivot,
  // amplification, gradient_rank, gradient_amplification, limited (number of components whose
  // value was limited).
  FieldSet fields;
  FitReports reports;  // one per target
  LimitCount limited;
  std::size_t values = 0;  // mapped, at targets that have any
};

// Names of the reports among the fields.
const std::vector<std::string>& report_names();
// dvx_dx, dvx_dy, ...: component after component, the axes by their letters; none for a kernel sum.
std::vector<std::string> gradient_names(const PlannedField& field, const std::string& letters);

// gradient: also the exact gradients of all fields but kernel sums.
Mapped map_fields(const Particles& particles, const FieldPlan& plan, const FitOptions& options,
                  const PointsView<double>& targets, bool gradient, Progress& progress);

}  // namespace recon::program
