#include "average.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "mapping.hpp"
#include "recon/core/error.hpp"

namespace recon::program {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool has_value(const NamedField& field, std::size_t target) {
  for (int c = 0; c < field.components; ++c)
    if (std::isnan(field.view()(target, c))) return false;
  return true;
}

}  // namespace

void FrameAverage::add(const FieldSet& fields, const FitReports& reports) {
  const bool first = frames_ == 0;
  std::size_t at = 0;
  for (const NamedField& field : fields) {
    if (field.name == report_names().front()) break;
    if (first) {
      fields_.push_back({field.name, field.components, {}, {}, {}});
      fields_.back().mean.assign(field.values.size(), 0);
      fields_.back().m.assign(field.values.size(), 0);
      fields_.back().values.assign(field.size(), 0);
    }
    Field& sum = fields_[at++];
    if (field.values.size() != sum.mean.size())
      throw InvalidArgument("number of values of a frame", std::to_string(field.values.size()),
                            "must be that of the first frame");
    const std::size_t components = static_cast<std::size_t>(field.components);
    for (std::size_t t = 0; t < field.size(); ++t) {
      if (!has_value(field, t)) continue;
      const double count = ++sum.values[t];
      for (std::size_t i = t * components; i < (t + 1) * components; ++i) {
        const double deviation = field.values[i] - sum.mean[i];
        sum.mean[i] += deviation / count;
        sum.m[i] += deviation * (field.values[i] - sum.mean[i]);
      }
    }
  }
  if (first) full_.assign(reports.size(), 0);
  for (std::size_t t = 0; t < reports.size(); ++t)
    full_[t] += reports[t].status == FitStatus::full ? 1 : 0;
  ++frames_;
}

std::vector<std::uint32_t> FrameAverage::frames_of_targets() const {
  std::vector<std::uint32_t> frames(full_.size(), static_cast<std::uint32_t>(frames_));
  for (const Field& field : fields_)
    for (std::size_t t = 0; t < frames.size(); ++t)
      frames[t] = std::min(frames[t], field.values[t]);
  return frames;
}

std::size_t FrameAverage::sometimes_missing() const {
  const std::vector<std::uint32_t> frames = frames_of_targets();
  return static_cast<std::size_t>(std::count_if(
      frames.begin(), frames.end(), [&](std::uint32_t n) { return n > 0 && n < frames_; }));
}

std::size_t FrameAverage::always_missing() const {
  const std::vector<std::uint32_t> frames = frames_of_targets();
  return static_cast<std::size_t>(std::count(frames.begin(), frames.end(), 0u));
}

FieldSet FrameAverage::result(double fill) const {
  FieldSet result;
  for (const Field& field : fields_) {
    std::vector<double> mean = field.mean, deviation(field.m.size());
    const std::size_t components = static_cast<std::size_t>(field.components);
    for (std::size_t i = 0; i < mean.size(); ++i) {
      const std::uint32_t count = field.values[i / components];
      if (count == 0) mean[i] = fill;
      deviation[i] = count < 2 ? nan : std::sqrt(field.m[i] / (count - 1.0));
    }
    result.add(field.name + "_mean", field.components, std::move(mean));
    result.add(field.name + "_std", field.components, std::move(deviation));
  }
  const auto add_counts = [&](const char* name, const std::vector<std::uint32_t>& counts) {
    result.add(name, 1, std::vector<double>(counts.begin(), counts.end()), NumberType::int32);
  };
  add_counts("frames", frames_of_targets());
  add_counts("frames_full", full_);
  return result;
}

}  // namespace recon::program
