#include "recon/transfer/point_functions.hpp"

namespace recon {

void detail::throw_coordinate(double x, int axis) {
  throw_invalid("coordinate of a particle along axis " + std::to_string(axis), x, "must be finite");
}

std::string_view name_of(SplineBorder border) {
  switch (border) {
    case SplineBorder::corrected:
      return "corrected";
    case SplineBorder::extra_column:
      return "extra_column";
    case SplineBorder::linear_cells:
      return "linear_cells";
  }
  return "";
}

}  // namespace recon
