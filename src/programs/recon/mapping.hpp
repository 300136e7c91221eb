// From particles to fields at targets, part by part, so that memory does not grow with the targets.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

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

// The fields of a plan, collected from fits at targets, some at a time.
class MappedFields {
 public:
  // Refers to the particles and the plan. `targets`: how many there will be about.
  MappedFields(const Particles& particles, const FieldPlan& plan, bool gradient,
               std::size_t targets);

  // The columns of the particles that are mapped, each once; nothing where all are kernel sums.
  const std::optional<NamedField>& data() const { return data_; }
  bool gradient() const { return gradient_; }
  // Values of data() at more targets and, with gradients, slopes of each component along each axis.
  void add(std::span<const FitReport> reports, const Eigen::MatrixXd& values,
           const Eigen::MatrixXd& slopes, const LimitCount& limited);
  // `sums` are those of the fields of the plan that are kernel sums. Leaves nothing here.
  Mapped result(Solver asked, std::vector<std::vector<double>> sums = {});

 private:
  void add_mapped(const PlannedField& field, FieldSet& fields);

  const Particles& particles_;
  const FieldPlan& plan_;
  bool gradient_;
  std::vector<std::string> columns_;  // of the particles, each once
  std::optional<NamedField> data_;
  std::vector<std::vector<double>> values_, slopes_;  // per column, and per column and axis
  std::vector<FitReport> reports_;
  LimitCount limited_;
};

// gradient: also the exact gradients of all fields but kernel sums.
Mapped map_fields(const Particles& particles, const FieldPlan& plan, const FitOptions& options,
                  const PointsView<double>& targets, bool gradient, Progress& progress);

}  // namespace recon::program
