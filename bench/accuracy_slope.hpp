// Orders of convergence: the slope of log(error) over log(h) by least squares.
#pragma once

#include <cmath>
#include <vector>

namespace recon_bench {

inline double slope(const std::vector<double>& h, const std::vector<double>& errors) {
  const auto n = static_cast<double>(h.size());
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < h.size(); ++i) {
    mean_x += std::log(h[i]) / n;
    mean_y += std::log(errors[i]) / n;
  }
  for (std::size_t i = 0; i < h.size(); ++i) {
    xx += std::pow(std::log(h[i]) - mean_x, 2);
    xy += (std::log(h[i]) - mean_x) * (std::log(errors[i]) - mean_y);
  }
  return xy / xx;
}

}  // namespace recon_bench
