#include "mapping.hpp"

#include <algorithm>

#include "recon/operators/kernel_sum.hpp"
#include "recon/operators/reconstruct.hpp"

namespace recon::program {

namespace {

// A copy of some targets.
struct Part {
  std::array<std::vector<double>, max_dimension> axes;
  int dimension;

  Part(const PointsView<double>& targets, std::size_t begin, std::size_t end)
      : dimension(targets.dimension()) {
    for (int d = 0; d < dimension; ++d)
      for (std::size_t t = begin; t < end; ++t) axes[d].push_back(targets(t, d));
  }
  PointsView<double> view() const { return points_of_axes(axes, dimension); }
};

// Targets that are done at once: enough to be worth a call, few enough for the memory.
std::size_t part_size(std::size_t particles) {
  return std::clamp<std::size_t>(particles / 2, 20'000, 200'000);
}

void add_reports(FieldSet& fields, const std::vector<FitReport>& reports,
                 const LimitCount& limited) {
  std::size_t next = 0;
  const auto add = [&](NumberType type, auto number_of) {
    std::vector<double> values;
    values.reserve(reports.size());
    for (const FitReport& report : reports)
      values.push_back(static_cast<double>(number_of(report)));
    fields.add(report_names()[next++], 1, std::move(values), type);
  };
  add(NumberType::int32, [](const FitReport& r) { return r.neighbours; });
  add(NumberType::int32, [](const FitReport& r) { return r.rank; });
  add(NumberType::int32, [](const FitReport& r) { return r.degree; });
  add(NumberType::int32, [](const FitReport& r) { return static_cast<int>(r.status); });
  add(NumberType::float32, [](const FitReport& r) { return r.smallest_pivot; });
  add(NumberType::float32, [](const FitReport& r) { return r.amplification; });
  add(NumberType::int32, [](const FitReport& r) { return r.gradient_rank; });
  add(NumberType::float32, [](const FitReport& r) { return r.gradient_amplification; });
  fields.add(report_names()[next], 1,
             std::vector<double>(limited.components.begin(), limited.components.end()),
             NumberType::int32);
}

void append(const Eigen::MatrixXd& rows, std::vector<std::vector<double>>& columns) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto column = rows.col(static_cast<Eigen::Index>(c));
    columns[c].insert(columns[c].end(), column.begin(), column.end());
  }
}

class Mapper {
 public:
  Mapper(const Particles& particles, const FieldPlan& plan, const FitOptions& options,
         std::size_t targets, bool gradient)
      : plan_(plan),
        options_(options),
        sources_(particles.positions(), options.sources()),
        fields_(particles, plan, gradient, targets) {
    options_.domain = {};  // the Sources have it, and the weights
    options_.particle_weights = {};
    sums_.resize(plan.size());
  }

  void add(const PointsView<double>& targets) {
    const Reconstruction fit = reconstruct(sources_, targets, options_);
    LimitCount limited;
    limited.components.resize(targets.size());
    Eigen::MatrixXd values, slopes;
    if (const auto& data = fields_.data()) {
      values = fit.apply(data->view(), {.limit = options_.limit, .count = &limited});
      if (fields_.gradient()) slopes = fit.gradient().apply(data->view());
    }
    fields_.add(fit.report().all(), values, slopes, limited);
    if (has_sums(plan_)) add_sums(targets, fit);
  }

  Mapped result() { return fields_.result(*options_.solver, std::move(sums_)); }

 private:
  // Over the support of each target's fit, or one of the sums' own.
  void add_sums(const PointsView<double>& targets, const Reconstruction& fit) {
    std::vector<double> radii(targets.size());
    for (std::size_t t = 0; t < radii.size(); ++t) radii[t] = fit.support(t);
    KernelOptions how{.weight = options_.weight, .form = *options_.form, .support = Radii{radii}};
    if (options_.sum_radius) how.support = Radius{*options_.sum_radius};
    how.threads = options_.threads;
    const CsrOperator<double> kernels = kernel_operator(sources_, targets, how);
    for (std::size_t f = 0; f < plan_.size(); ++f) {
      if (!plan_[f].is_kernel_sum()) continue;
      const Eigen::MatrixXd sums = kernels.apply(field_of(plan_[f].amounts));
      for (std::size_t t = 0; t < radii.size(); ++t) {
        // The support of a target that has the nearest particle reaches it, unlike the one asked
        // for.
        const bool nearest = !options_.sum_radius && fit.report()[t].status == FitStatus::nearest;
        sums_[f].push_back(nearest ? 0 : sums(static_cast<Eigen::Index>(t), 0));
      }
    }
  }

  const FieldPlan& plan_;
  FitOptions options_;
  Sources sources_;
  MappedFields fields_;
  std::vector<std::vector<double>> sums_;  // per field of the plan
};

}  // namespace

const std::vector<std::string>& report_names() {
  static const std::vector<std::string> names{
      "neighbours",     "rank",          "degree",        "status",
      "smallest_pivot", "amplification", "gradient_rank", "gradient_amplification",
      "limited"};
  return names;
}

std::vector<std::string> gradient_names(const PlannedField& field, const std::string& letters) {
  std::vector<std::string> names;
  for (const std::string& column : field.columns)
    for (const char letter : letters)
      names.push_back("d" + (field.columns.size() == 1 ? field.name : column) + "_d" + letter);
  return names;
}

MappedFields::MappedFields(const Particles& particles, const FieldPlan& plan, bool gradient,
                           std::size_t targets)
    : particles_(particles), plan_(plan), gradient_(gradient) {
  for (const PlannedField& field : plan)
    for (const std::string& column : field.columns)
      if (std::find(columns_.begin(), columns_.end(), column) == columns_.end())
        columns_.push_back(column);
  if (!columns_.empty()) data_ = particles.table.field("fields", columns_);
  values_.resize(columns_.size());
  for (auto& column : values_) column.reserve(targets);
  slopes_.resize(gradient ? columns_.size() * static_cast<std::size_t>(particles.dimension) : 0);
  for (auto& column : slopes_) column.reserve(targets);
}

void MappedFields::add(std::span<const FitReport> reports, const Eigen::MatrixXd& values,
                       const Eigen::MatrixXd& slopes, const LimitCount& limited) {
  reports_.insert(reports_.end(), reports.begin(), reports.end());
  append(values, values_);
  append(slopes, slopes_);
  limited_.components.insert(limited_.components.end(), limited.components.begin(),
                             limited.components.end());
}

Mapped MappedFields::result(Solver asked, std::vector<std::vector<double>> sums) {
  Mapped mapped;
  for (std::size_t f = 0; f < plan_.size(); ++f) {
    if (plan_[f].is_kernel_sum())
      mapped.fields.add(plan_[f].name, 1, std::move(sums[f]));
    else
      add_mapped(plan_[f], mapped.fields);
  }
  mapped.fields.step = particles_.table.step;
  mapped.fields.time = particles_.table.time;
  add_reports(mapped.fields, reports_, limited_);
  limited_.total();
  mapped.limited = std::move(limited_);
  mapped.reports = FitReports(std::move(reports_), asked);
  const FitSummary& summary = mapped.reports.summary();
  mapped.values = columns_.size() * (summary.targets - summary.no_support - summary.too_far);
  return mapped;
}

void MappedFields::add_mapped(const PlannedField& field, FieldSet& fields) {
  const auto place_of = [&](const std::string& column) {
    return static_cast<std::size_t>(std::find(columns_.begin(), columns_.end(), column) -
                                    columns_.begin());
  };
  const std::size_t components = field.columns.size();
  std::vector<double> values(reports_.size() * components);
  for (std::size_t c = 0; c < components; ++c) {
    const std::vector<double>& column = values_[place_of(field.columns[c])];
    for (std::size_t t = 0; t < column.size(); ++t) values[t * components + c] = column[t];
  }
  fields.add(field.name, static_cast<int>(components), std::move(values));
  if (!gradient_) return;
  const std::size_t dimension = static_cast<std::size_t>(particles_.dimension);
  const std::vector<std::string> names = gradient_names(field, particles_.letters);
  for (std::size_t i = 0; i < names.size(); ++i)
    fields.add(names[i], 1,
               slopes_[place_of(field.columns[i / dimension]) * dimension + i % dimension]);
}

Mapped map_fields(const Particles& particles, const FieldPlan& plan, const FitOptions& options,
                  const PointsView<double>& targets, bool gradient, Progress& progress) {
  Mapper mapper(particles, plan, options, targets.size(), gradient);
  const std::size_t size = part_size(particles.size());
  for (std::size_t begin = 0; begin < targets.size(); begin += size) {
    const std::size_t end = std::min(begin + size, targets.size());
    mapper.add(Part(targets, begin, end).view());
    progress.advance(end - begin);
  }
  return mapper.result();
}

}  // namespace recon::program
