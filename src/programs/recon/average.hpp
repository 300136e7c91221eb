// Mean and standard deviation over frames of each field at each target.
//
//     mean = (1/n) sum_i v_i,   s = sqrt(sum_i (v_i - mean)^2 / (n - 1)),
// over the n frames in which the target has a value (not NaN), updated frame by frame without
// differences of large sums (Welford 1962):
//     d = v - mean,   mean += d / n,   m += d (v - mean),   s = sqrt(m / (n - 1)).
// No mean without a value, no s for fewer than two: NaN. Memory: two numbers for each value of a
// frame, whatever the number of frames.
#pragma once

#include <cstdint>
#include <vector>

#include "recon/fields/field_set.hpp"
#include "recon/operators/fit_summary.hpp"

namespace recon::program {

class FrameAverage {
 public:
  // `fields` of a frame, up to the reports; the same fields at the same targets in every call.
  void add(const FieldSet& fields, const FitReports& reports);

  std::size_t frames() const { return frames_; }
  // Targets that have a value in some frames and not in others, and those that never have one.
  std::size_t sometimes_missing() const;
  std::size_t always_missing() const;

  // NAME_mean and NAME_std for each field, then frames (in how many the target has values of all
  // fields) and frames_full (in how many its fit reached the full degree). A target without any
  // value has the mean `fill`.
  FieldSet result(double fill) const;

 private:
  struct Field {
    std::string name;
    int components = 1;
    std::vector<double> mean, m;
    std::vector<std::uint32_t> values;  // how many, per target
  };
  std::vector<std::uint32_t> frames_of_targets() const;

  std::size_t frames_ = 0;
  std::vector<Field> fields_;
  std::vector<std::uint32_t> full_;
};

}  // namespace recon::program
